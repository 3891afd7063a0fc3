"""Operating points of a program, and what it computes there."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.errors import InputError, Named, RunError, UnknownNameError
from m4e_fmi.model import Model, as_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import (
    TIME,
    Jacobian,
    LocalLaw,
    Part,
    Program,
    Variable,
    evaluated,
    singular_loop,
)
from m4e_fmi.shown import listing
from m4e_fmi.simulate import started

Floats = NDArray[np.float64]
T = TypeVar("T")
System = Program | Model | str | Path


def program_and_model(system: System) -> tuple[Program, Model | None]:
    """The program of a system, and its model if it is one."""
    if isinstance(system, Program):
        return system, None
    model = as_model(system)
    return model_program(model), model


@dataclass(frozen=True)
class OperatingPoint:
    """A state of a program: vectors in the order of its variables, SI; `time` [s]."""

    program: Program = field(repr=False)
    states: Floats
    inputs: Floats
    parameters: Floats
    time: float = 0.0

    @cached_property
    def values(self) -> dict[str, float]:
        """Every state, input and parameter by name."""
        groups = (
            (self.program.states, self.states),
            (self.program.inputs, self.inputs),
            (self.program.parameters, self.parameters),
        )
        return Named(
            f"{self.program.name} has no state, input, parameter or output",
            {
                v.name: float(value)
                for variables, vector in groups
                for v, value in zip(variables, vector, strict=True)
            },
        )

    def __getitem__(self, name: str) -> float:
        """A state, input, parameter or output at the point, in SI; UnknownNameError without one."""
        if name not in self.values and name in {v.name for v in self.program.outputs}:
            return float(Evaluation(observed(self.program, [name])).at(self)[0])
        return self.values[name]

    def with_states(self, states: Floats) -> OperatingPoint:
        """The point with other states (n,), in their SI units."""
        return replace(self, states=states)

    def with_values(self, values: Mapping[str, float]) -> OperatingPoint:
        """The point with other values, in SI, of some states, inputs and parameters by name."""
        p, now = self.program, {**self.values, **values}
        groups = (p.states, p.inputs, p.parameters)
        states, inputs, parameters = (np.array([now[v.name] for v in group]) for group in groups)
        return replace(self, states=states, inputs=inputs, parameters=parameters)

    def __repr__(self) -> str:
        def lines(variables: Sequence[Variable], vector: Floats) -> list[str]:
            pairs = zip(variables, vector, strict=True)
            return [f"{v.name} = {value:.6g} {v.unit}" for v, value in pairs]

        return listing(
            f"OperatingPoint of {self.program.name!r} at t = {self.time:g} s",
            states=lines(self.program.states, self.states),
            inputs=lines(self.program.inputs, self.inputs),
            parameters=lines(self.program.parameters, self.parameters),
        )


LARGEST_DERIVATIVE = 1e100
"""Beyond this it is that of a direction whose length is zero: see `planar.norm`."""
COINCIDING = 1e-100
"""Distance [m] below which points coincide."""
MEASURE = re.compile(r"(?:.+\.)?load\.\w+\.(distance|extension|gap|power)")

MOST_RENEWALS = 30
"""Of parts that take each other's values; alone, a part is renewed once."""
SAME = 1e-9
"""Change of an input of such a part that is none, over 1 + its value."""

At = OperatingPoint | Mapping[str, float | str] | None
"""Where: values by name, as for `simulate`; what is not named has its start value."""


def operating_point(
    program: Program, at: At = None, *, time: float | None = None, model: Model | None = None
) -> OperatingPoint:
    """The point of `program` with the values of `at`; InputError names what it does not have.

    Of a `model`, it says where in its file a value is missing. RunError if an algebraic loop of a
    composed program is singular there. Parts whose equations hold about a point only are `renewed`
    about it, unless `at` is a point, which has all that belongs to it.
    """
    is_point = isinstance(at, OperatingPoint)
    if isinstance(at, OperatingPoint):
        time = at.time if time is None else time
        at = at.values
    program = started(program, at or {}, model)
    groups = (program.states, program.inputs, program.parameters)
    vectors = [np.array([v.start for v in group]) for group in groups]
    point = OperatingPoint(program, *vectors, time=time or 0.0)
    if names := singular_loop(program, {**point.values, TIME: point.time}):
        message = f"{program.name}: the algebraic loop of {names} is singular there"
        raise RunError(message, "look at the gains around the loop: their product is 1")
    return point if is_point else renewed(point)


def local_parts(program: Program) -> list[tuple[Part, LocalLaw]]:
    """The parts whose equations hold about a point only, and their laws."""
    return [(part, part.origin) for part in program.parts if isinstance(part.origin, LocalLaw)]


def renewed(point: OperatingPoint) -> OperatingPoint:
    """`point` with the equations of all `local_parts` holding about it.

    RunError if a law has none there, or if they do not come to an end with each other.
    """
    parts, before = local_parts(point.program), None
    if not parts:
        return point
    for _ in range(MOST_RENEWALS):
        inputs = _inputs(point, [part for part, _ in parts])
        if before is not None and all(
            abs(v - before[k]) <= SAME * (1.0 + abs(v)) for k, v in inputs.items()
        ):
            return point
        before, found = inputs, dict[str, float]()
        for part, law in parts:
            own = {v.name: inputs[f"{part.name}.{v.name}"] for v in part.program.inputs}
            parameters = law.parameters_at(own)
            found |= {f"{part.name}.{name}": value for name, value in parameters.items()}
        point = point.with_values(found)
    names = ", ".join(part.name for part, _ in parts)
    message = f"{point.program.name}: {names} take no values together that stay as they are"
    raise RunError(message, "give one of them as equations, or keep it open")


def _inputs(point: OperatingPoint, parts: Sequence[Part]) -> dict[str, float]:
    """The values of the inputs of parts, as ``part.input``."""
    variables = [(part, v.name) for part in parts for v in part.program.inputs]
    nodes = {f"{part.name}.{name}": part.nodes[name] for part, name in variables}
    values = {**point.values, TIME: point.time}
    found = evaluated(point.program.tape, list(nodes.values()), values)
    return {name: found[node] for name, node in nodes.items()}


class Evaluation:
    """The outputs of a program at operating points."""

    def __init__(self, program: Program) -> None:
        from m4e_fmi.runtime.engine import Engine

        self.program = program
        self._engine = Engine(program)

    def at(self, point: OperatingPoint, *more: float) -> Floats:
        """Outputs at `point`, shape (n_outputs,), in their units.

        `more` are values of inputs that only this program has.
        """
        self._engine.set_parameters(point.parameters)
        self._engine.set_inputs([*point.inputs, *more])
        return self._engine.outputs(point.time, point.states)


class Matrix:
    """A matrix of exact derivatives, dense at operating points."""

    def __init__(self, derivatives: Jacobian) -> None:
        self.derivatives = derivatives
        self._entries = Evaluation(derivatives.program)

    def at(self, point: OperatingPoint) -> Floats:
        """∂rows/∂columns at `point`, shape (rows, columns), in SI; RunError unless finite."""
        d = self.derivatives
        matrix = np.zeros((len(d.rows), len(d.columns)))
        matrix[list(d.row_indices), list(d.column_indices)] = self._entries.at(point)
        wrong = ~(np.abs(matrix) < LARGEST_DERIVATIVE)
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            message = (
                f"{d.program.name}: the derivative of {d.rows[row]} by {d.columns[column]} "
                f"is {matrix[row, column]} at t = {point.time:g} s"
            )
            raise RunError(message, "look for a singular configuration or a division by zero")
        return matrix


class Lines:
    """The loads of a program that act along the line between two points."""

    def __init__(self, program: Program) -> None:
        names = [v.name for v in program.outputs if MEASURE.fullmatch(v.name)]
        self._observed = observed(program, names)
        self._evaluation = Evaluation(self._observed) if names else None

    def check(self, point: OperatingPoint) -> None:
        """RunError if a force has no derivative at `point`: its two points coincide there.

        A stop that is not in contact has one, and a spring that is at rest there and has a
        potential.
        """
        if self._evaluation is None:
            return
        outputs = zip(self._observed.outputs, self._evaluation.at(point), strict=True)
        loads: dict[str, dict[str, float]] = {}
        for variable, value in outputs:
            load, _, measure = variable.name.rpartition(".")
            loads.setdefault(load, {})[measure] = float(value)
        for load, measures in loads.items():
            free = measures.get("gap", 0.0) > 0.0
            resting = "power" not in measures and abs(measures.get("extension", 1.0)) < COINCIDING
            if measures.get("distance", 1.0) < COINCIDING and not free and not resting:
                name = self._observed.name
                load = load.replace("load.", "", 1)
                message = f"{name}: the two points of load {load} coincide at t = {point.time:g} s"
                why = "its force acts along the line between them, and has no derivative there"
                remedy = "take another point, or a bushing, which is linear in place and velocity"
                raise RunError(f"{message}: {why}", remedy)


def rate_unit(unit: str) -> str:
    """The unit of the rate of something in `unit`: m → m/s → m/s2."""
    return f"{unit}2" if unit.endswith("/s") else f"({unit})/s" if "/" in unit else f"{unit}/s"


def unit_by(of: Variable, by: Variable) -> str:
    """The unit of a derivative: m and N/m → m/(N/m)."""
    divided = by.unit if by.unit.isalnum() else f"({by.unit})"
    return of.unit if by.unit == "1" else f"{of.unit}/{divided}"


def observed(program: Program, names: Sequence[str]) -> Program:
    """`program` with these outputs only: outputs, states, or rates of states as ``der(name)``.

    InputError names what it does not have.
    """
    known: dict[str, tuple[Variable, int]] = {}
    for v, rate in zip(program.states, program.rates, strict=True):
        known[v.name] = (v, program.tape.node(("symbol", v.name)))
        name = f"der({v.name})"
        known[name] = (Variable(name, rate_unit(v.unit), f"Rate of {v.name}"), rate)
    known |= {v.name: (v, k) for v, k in zip(program.outputs, program.results, strict=True)}
    chosen = _chosen(known, names, f"{program.name} has no output or state")
    outputs, results = tuple(v for v, _ in chosen), tuple(k for _, k in chosen)
    return replace(program, outputs=outputs, results=results)


def causes(program: Program, names: Sequence[str], *, states: bool) -> tuple[Variable, ...]:
    """Inputs, parameters, and with `states` states by name; InputError names what is unknown."""
    groups = [program.inputs, program.parameters, *([program.states] if states else [])]
    known = {v.name: v for group in groups for v in group}
    what = "input, parameter or state" if states else "input or parameter"
    return tuple(_chosen(known, names, f"{program.name} has no {what}"))


def _chosen(known: Mapping[str, T], names: Sequence[str], complaint: str) -> list[T]:
    """The members with these names; InputError with all that are unknown."""
    if isinstance(names, str):
        raise InputError.single(f"expected a list of names, got {names!r}", f"write [{names!r}]")
    unknown = [name for name in names if name not in known]
    if unknown:
        raise UnknownNameError.of(complaint, unknown, known)
    return [known[name] for name in names]


def place(name: str, variables: Sequence[Variable]) -> int:
    """The place of a variable among others; UnknownNameError if it is not one of them."""
    names = [v.name for v in variables]
    if name not in names:
        raise UnknownNameError.of("there is no", [name], names)
    return names.index(name)


def motion(program: Program) -> list[tuple[int, int]]:
    """Positions of the states that are (coordinate, its velocity), in the order of coordinates."""
    place = {v.name: k for k, v in enumerate(program.states)}
    return sorted(
        (place[v.derivative_of], k)
        for k, v in enumerate(program.states)
        if v.derivative_of in place
    )


def integrals(program: Program, outputs: Sequence[str]) -> set[int]:
    """Positions of the states on which no rate depends, of other states than such, and no output.

    `outputs` names outputs, states, or rates of states as ``der(name)``.
    """
    seen = observed(program, outputs)
    read = set[str]().union(*(seen.dependencies(node) for node in seen.results))
    needs = [program.dependencies(node) for node in program.rates]
    found: set[int] = set()
    while True:
        kept = [names for k, names in enumerate(needs) if k not in found]
        used = read.union(*kept)
        more = {k for k, v in enumerate(program.states) if v.name not in used} - found
        if not more:
            return found
        found |= more
