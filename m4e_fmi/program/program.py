"""Program: an ODE with named, described, unit-bearing variables, held as one tape.

ẋ = f(t, x, u, p)        y = g(t, x, u, p)        c = h(p)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import Protocol, runtime_checkable

from m4e_fmi.errors import UnknownNameError
from m4e_fmi.program.tape import COMMUTATIVE, Operation, Scalar, Tape
from m4e_fmi.shown import listing, one_line

TIME = "time"
GROUPS = ("parameters", "inputs", "states", "outputs", "calculated")


@dataclass(frozen=True)
class Variable:
    """One scalar variable of a program.

    `unit` is an SI unit as FMI spells it ("m/s2", "kg.m2", "N.m/rad"; "1" for none).
    `derivative_of` names the variable that this one is the time derivative of: a master may
    extrapolate that variable with this one.
    `tunable` parameters may change between steps, others only before the start.
    `local` states and outputs are visible but not meant to be connected.
    `minimum` and `maximum` hold between them, both included, every value with which the equations
    mean something. `nominal` is the order of magnitude of its values, all in `unit`.
    """

    name: str
    unit: str
    description: str
    start: float = 0.0
    derivative_of: str | None = None
    tunable: bool = False
    local: bool = False
    display_unit: str | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 1.0


class Solution(Protocol):
    """A part of a program that solves equations, and how their solution changes.

    A program with a Solution has cheaper derivatives: they go through the `balance` and one more
    solve with the existing factors, instead of through the factoring.
    """

    @property
    def unknowns(self) -> Sequence[Scalar]:
        """The scalars that are solved for."""
        ...

    def balance(self) -> Sequence[Scalar]:
        """Scalars that the unknowns depend on, none of them an unknown; recorded when asked for."""
        ...

    def drive(self, change: Mapping[int, Scalar]) -> Mapping[int, Scalar]:
        """Right-hand side for a `change` of the balance, by place; linear, local."""
        ...

    def response(self, drive: Mapping[int, Scalar]) -> Sequence[Scalar | int]:
        """Change of the unknowns for a `drive`; 0 for unchanged ones."""
        ...


@dataclass(frozen=True)
class Part:
    """A program that is part of another one, there called `name`.

    `nodes` are the values of its parameters, inputs and states, by name, as nodes of the other's
    tape. `origin` is what it was recorded from, such as a model; None if that is not known.
    """

    name: str
    program: Program = field(repr=False)
    nodes: Mapping[str, int] = field(repr=False)
    origin: object = field(default=None, repr=False)


@runtime_checkable
class LocalLaw(Protocol):
    """The `origin` of a part whose equations hold about a point only, such as a tangent.

    Parameters of the part say where that is and how it is there.
    """

    @property
    def errors(self) -> Mapping[str, float]:
        """Errors of the parameters that were found last, in their units; of others 0."""
        ...

    def parameters_at(self, inputs: Mapping[str, float]) -> Mapping[str, float]:
        """The parameters with which the part holds about these values of its inputs, by name.

        RunError where that cannot be found out.
        """
        ...


@dataclass(frozen=True)
class Loop:
    """An algebraic loop of a composed program, solved for the `inputs` that cut it.

    `shares` are nodes of each pivot's remaining share of its terms [1]: at zero the loop is
    singular.
    """

    inputs: tuple[str, ...]
    shares: tuple[int, ...] = field(repr=False)


@dataclass(frozen=True, eq=False)
class Program:
    """A recorded system of ordinary differential equations.

    Each tuple of `Variable`s is in the order of its vector. `rates[i]` is the tape node of the time
    derivative of `states[i]`, `results[i]` that of `outputs[i]`, `constants[i]` that of
    `calculated[i]`, which depends on parameters only. `solutions` say how the rates were solved
    for, if they were, `parts` what programs it was composed of, and `loops` where their equations
    may have no solution; none of them is needed to run it.

    Programs are equal if they have the same variables, in the same order, and do the same with
    them: to the bit they give the same results then, on whatever tapes they are.
    """

    name: str
    description: str
    tape: Tape = field(repr=False)
    parameters: tuple[Variable, ...]
    inputs: tuple[Variable, ...]
    states: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    calculated: tuple[Variable, ...]
    rates: tuple[int, ...] = field(repr=False)
    results: tuple[int, ...] = field(repr=False)
    constants: tuple[int, ...] = field(repr=False)
    solutions: tuple[Solution, ...] = field(default=(), repr=False, compare=False)
    parts: tuple[Part, ...] = field(default=(), repr=False, compare=False)
    loops: tuple[Loop, ...] = field(default=(), repr=False, compare=False)

    def __eq__(self, other: object) -> bool:
        table: dict[Operation, int] = {}
        return (
            isinstance(other, Program)
            and all(
                getattr(self, field) == getattr(other, field)
                for field in ("name", "description", *GROUPS)
            )
            and self._identities(table) == other._identities(table)
        )

    def _identities(self, table: dict[Operation, int]) -> list[int]:
        """For each rate, output and calculated parameter a number that is the same for the same
        operations; `table` is shared."""
        roots = [*self.rates, *self.results, *self.constants]
        numbers: dict[int, int] = {}
        for k in self.tape.reachable(roots):
            kind, *operands = self.tape.operations[k]
            if self.tape.arguments(k):
                operands = [numbers[a] for a in operands]
                if kind in COMMUTATIVE:
                    operands.sort()
            numbers[k] = table.setdefault((kind, *operands), len(table))
        return [numbers[k] for k in roots]

    def __hash__(self) -> int:
        return hash((self.name, self.description, *(getattr(self, group) for group in GROUPS)))

    def dependencies(self, node: int) -> frozenset[str]:
        """Names of the inputs, states and parameters (and `time`) that a node depends on."""
        known = self._dependencies.get(node)
        return self.tape.symbols_of(node) if known is None else known

    @cached_property
    def _dependencies(self) -> dict[int, frozenset[str]]:
        """Names that each rate, output and calculated parameter depends on, by node."""
        return self.tape.symbols_of_each([*self.rates, *self.results, *self.constants])

    def operations(self, roots: Iterable[int]) -> list[int]:
        """Nodes that one evaluation of `roots` computes, in order.

        What depends on parameters only is computed once for all evaluations and left out.
        """
        fixed = {v.name for v in self.parameters}
        varying: set[int] = set()
        for k in self.tape.reachable(roots):
            operation = self.tape.operations[k]
            if operation[0] == "symbol":
                if operation[1] not in fixed:
                    varying.add(k)
            elif not varying.isdisjoint(self.tape.arguments(k)):
                varying.add(k)
        return [k for k in sorted(varying) if self.tape.arguments(k)]

    def with_start(self, values: dict[str, float]) -> Program:
        """The same program with other start values; UnknownNameError names what
        it does not have."""

        def changed(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
            return tuple(replace(v, start=float(values.get(v.name, v.start))) for v in variables)

        groups = {k: changed(getattr(self, k)) for k in ("parameters", "inputs", "states")}
        known = {v.name for group in groups.values() for v in group}
        unknown = sorted(set(values) - known)
        if unknown:
            complaint = f"{self.name} has no parameter, input or state"
            raise UnknownNameError.of(complaint, unknown, known)
        return replace(self, **groups)

    def __str__(self) -> str:
        lines = [f"program {self.name}: {one_line(self.description)}", self._size()]
        for title in GROUPS:
            variables: tuple[Variable, ...] = getattr(self, title)
            lines.append(f"{title} ({len(variables)})")
            lines += [f"  {v.name} [{v.unit}] {one_line(v.description)}" for v in variables]
        return "\n".join(lines)

    def _size(self) -> str:
        rates, outputs = (len(self.operations(r)) for r in (self.rates, self.results))
        return f"{rates} operations for the rates, {outputs} for all outputs"

    def __repr__(self) -> str:
        return listing(
            f"Program {self.name!r}: {self._size()}",
            **{group: getattr(self, group) for group in GROUPS},
        )


class Recorder:
    """Recorder of a Program: declare variables, compute with their scalars, declare the outputs.

    >>> r = Recorder("decay", "exponential decay")
    >>> k = r.parameter(Variable("k", "1/s", "rate", start=2.0))
    >>> x = r.state(Variable("x", "1", "what decays", start=1.0))
    >>> r.rate("x", -k * x)
    >>> program = r.program()
    """

    def __init__(self, name: str, description: str, *, tape: Tape | None = None) -> None:
        self.name = name
        self.description = description
        self.tape = Tape() if tape is None else tape
        self.time = self.tape.symbol(TIME)
        self._variables: dict[str, dict[str, Variable]] = {group: {} for group in GROUPS}
        self._rates: dict[str, int] = {}
        self._names: set[str] = set()
        self._results: list[int] = []
        self._constants: list[int] = []

    def _declare(self, group: str, variable: Variable) -> None:
        name = variable.name
        if name == TIME:
            raise ValueError(f"{self.name}: {TIME!r} is the name of the independent variable")
        if name in self._names:
            raise ValueError(f"{self.name}: variable {name!r} is declared twice")
        self._names.add(name)
        self._variables[group][name] = variable

    def parameter(self, variable: Variable) -> Scalar:
        """Declare a parameter. ValueError, here as below, for a name that is taken."""
        self._declare("parameters", variable)
        return self.tape.symbol(variable.name)

    def input(self, variable: Variable) -> Scalar:
        """Declare an input."""
        self._declare("inputs", variable)
        return self.tape.symbol(variable.name)

    def state(self, variable: Variable) -> Scalar:
        """Declare a state, which needs a `rate`."""
        self._declare("states", variable)
        return self.tape.symbol(variable.name)

    def rate(self, name: str, value: Scalar | float) -> None:
        """Set the time derivative of state `name` to `value`. ValueError if it has one already."""
        if name not in self._variables["states"] or name in self._rates:
            raise ValueError(f"{self.name}: {name!r} is not a state, or already has its rate")
        self._rates[name] = self._index(value)

    def output(self, variable: Variable, value: Scalar | float) -> None:
        """Declare an output of this `value`."""
        self._declare("outputs", variable)
        self._results.append(self._index(value))

    def calculate(self, variable: Variable, value: Scalar | float) -> None:
        """Declare a calculated parameter: computed once, from parameters only."""
        self._declare("calculated", variable)
        self._constants.append(self._index(value))

    def _index(self, value: Scalar | float) -> int:
        return value.index if isinstance(value, Scalar) else self.tape.constant(value).index

    def variables(self, *groups: str) -> Iterator[Variable]:
        """All that is declared in these groups, such as "parameters", in their order."""
        return chain.from_iterable(self._variables[group].values() for group in groups)

    def program(self, *, solutions: tuple[Solution, ...] = ()) -> Program:
        """The finished program.

        ValueError if a state has no rate, if a scalar or a `derivative_of` names no variable, or if
        a calculated parameter depends on more than parameters.
        """
        symbols = self.tape.symbols_of_each(self._constants)
        for v, index in zip(self.variables("calculated"), self._constants, strict=True):
            if foreign := symbols[index] - set(self._variables["parameters"]):
                raise ValueError(f"{self.name}: {v.name!r} depends on {sorted(foreign)}")
        missing = sorted(set(self._variables["states"]) - set(self._rates))
        if missing:
            raise ValueError(f"{self.name}: no rate for state {', '.join(missing)}")
        rates = tuple(self._rates[name] for name in self._variables["states"])
        self._check_symbols([*rates, *self._results, *self._constants])
        for v in self.variables(*GROUPS):
            if v.derivative_of is not None and v.derivative_of not in self._names:
                message = f"{v.name!r} cannot be the derivative of {v.derivative_of!r}"
                raise ValueError(f"{self.name}: {message}, which is not declared")
        return Program(
            name=self.name,
            description=self.description,
            tape=self.tape,
            rates=rates,
            results=tuple(self._results),
            constants=tuple(self._constants),
            solutions=solutions,
            parameters=tuple(self.variables("parameters")),
            inputs=tuple(self.variables("inputs")),
            states=tuple(self.variables("states")),
            outputs=tuple(self.variables("outputs")),
            calculated=tuple(self.variables("calculated")),
        )

    def _check_symbols(self, roots: Iterable[int]) -> None:
        readable = {v.name for v in self.variables("parameters", "inputs", "states")}
        strangers = self.tape.names - readable - {TIME}
        if not strangers:
            return
        for index in self.tape.reachable(roots):
            operation = self.tape.operations[index]
            if operation[0] == "symbol" and operation[1] in strangers:
                raise ValueError(f"{self.name}: {operation[1]!r} is used but not declared")

    def __repr__(self) -> str:
        return listing(f"Recorder of {self.name!r}: {self.tape!r}", **self._variables)
