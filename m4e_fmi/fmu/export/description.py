"""Declarations of FMUs: the variables of a program or a Python slave, independent of any file.

`described` says it of a program that is as `shown`. How it is written down is in
`model_description`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.export.selection import with_outputs
from m4e_fmi.fmu.importer.reading import OWN_TOOL, Description
from m4e_fmi.fmu.importer.reading import Variable as ReadVariable
from m4e_fmi.program import TIME, Program, Variable
from m4e_fmi.program.dependence import KINDS, kinds
from m4e_fmi.runtime.declarations import METHODS
from m4e_fmi.shown import listing, short
from m4e_fmi.units import parse_unit

FMI_VERSIONS = ("2", "3")
LAST_ERROR = "last_error"


@short
@dataclass(frozen=True)
class FmuVariable:
    """One scalar variable of an FMU, in FMI 2.0's words.

    `dependencies` names the inputs and states that an output depends on at one moment (None: all);
    `initial_dependencies` names what its initial value depends on (None: all). `kinds` and
    `initial_kinds` say how, in FMI's words, one for each name; None declares nothing. Values
    outside `minimum` … `maximum`, both included, are refused. `nominal` is an order of magnitude.
    """

    name: str
    unit: str
    description: str
    causality: str = "local"
    variability: str = "continuous"
    initial: str | None = None
    start: float | str | None = None
    type: str = "Real"
    dependencies: tuple[str, ...] | None = ()
    initial_dependencies: tuple[str, ...] | None = ()
    kinds: tuple[str, ...] | None = None
    initial_kinds: tuple[str, ...] | None = None
    derivative_of: str | None = None
    display_unit: str | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 1.0


@dataclass(frozen=True)
class ModelDescription:
    """Name, description, variables and default experiment (times in seconds) of an FMU.

    `tolerance` is the relative one of its integrator where an importer gives none.

    The value reference of a variable is its index among the variables of its type. `derivatives`
    names the rates of the states, in the order of the states; empty where they are not all there.
    `goes_back` is False of a Python slave whose state cannot be saved and restored.
    """

    name: str
    description: str
    variables: tuple[FmuVariable, ...]
    stop_time: float = 10.0
    step_size: float = 0.01
    tolerance: float = 1e-8
    derivatives: tuple[str, ...] = ()
    goes_back: bool = True

    def __repr__(self) -> str:
        return listing(f"ModelDescription of {self.name!r}", variables=self.variables)


@short
@dataclass(frozen=True)
class PythonSource:
    """A slave in Python: `slave` is "module:Class", found among `modules` (file name → path).

    All modules are packed side by side into one package of a unique name; they import one another
    relatively (``from .slave_base import M4eSlave``). `data` (file name → content) goes there too.
    """

    description: ModelDescription
    slave: str
    modules: dict[str, Path]
    data: dict[str, bytes]


@dataclass(frozen=True)
class Options:
    """The arguments of `build_fmu`, where they are explained; InputError with all that is wrong."""

    native: bool = False
    fmi: str = "2"
    method: str = "dop853"
    tolerance: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    outputs: tuple[str, ...] | None = None
    documentation: Mapping[str, bytes] = field(default_factory=dict)
    sources: bool = False

    def __post_init__(self) -> None:
        problems = []
        for what, value, known in (
            ("FMI version", self.fmi, FMI_VERSIONS),
            ("method", self.method, METHODS),
        ):
            if value not in known:
                remedy = suggestion(str(value), known)
                problems.append(Problem(f"there is no {what} {value!r}", remedy))
        for what, value in (
            ("tolerance", self.tolerance),
            ("stop time", self.stop_time),
            ("step size", self.step_size),
        ):
            if value is not None and not _is_positive(value):
                remedy = f"give a number{'' if what == 'tolerance' else ' of seconds'} above 0"
                problems.append(Problem(f"the {what} must be positive, got {value!r}", remedy))
        if self.fmi == "3" and not self.native:
            problems.append(Problem("FMI 3.0 is for native FMUs", "add native, or take FMI 2"))
        if self.sources and not self.native:
            problems.append(Problem("C sources are for native FMUs", "leave them out"))
        problems += [
            Problem(f"{name!r} is not a place for documentation", "begin it with documentation/")
            for name in self.documentation
            if not name.startswith("documentation/")
        ]
        InputError.raise_for(problems)


def _is_positive(value: object) -> bool:
    """True for a number above 0 that is finite."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    return 0 < float(value) < math.inf


def shown(program: Program, options: Options) -> Program:
    """The part of `program` that its FMU shows."""
    chosen = program if options.outputs is None else with_outputs(program, options.outputs)
    return with_rates(chosen)


def described(program: Program, options: Options) -> ModelDescription:
    """The description of an FMU of a program that is as `shown`."""
    return asked(describe(program), options)


def asked(description: ModelDescription, options: Options) -> ModelDescription:
    """`description` with the default experiment that is asked for, and the variable for errors.

    InputError for a variable of that name, and a step longer than the experiment.
    """
    if any(v.name == LAST_ERROR for v in description.variables):
        message = f"{description.name}: every FMU has a variable {LAST_ERROR!r} of its own"
        raise InputError.single(message, "give yours another name")
    last_error = FmuVariable(
        name=LAST_ERROR,
        unit="",
        description="Text of the error that stopped this component; empty while all is well",
        variability="discrete",
        initial="calculated",
        type="String",
    )
    asked = {key: getattr(options, key) for key in ("tolerance", "stop_time", "step_size")}
    result = replace(
        description,
        variables=(*description.variables, last_error),
        **{key: value for key, value in asked.items() if value is not None},
    )
    if result.step_size > result.stop_time:
        message = f"the step size {result.step_size:g} s is longer than the default experiment"
        remedy = f"it stops at {result.stop_time:g} s: take a shorter step, or a later stop time"
        raise InputError.single(message, remedy)
    return result


def describe(
    program: Program, *, stop_time: float = 10.0, step_size: float = 0.01
) -> ModelDescription:
    """The FMU variables of `program`: parameters, calculated, inputs, states, outputs."""
    rates = _rates_shown(program)
    complete = len(rates) == len(program.states)
    return ModelDescription(
        program.name,
        program.description,
        tuple(_variables(program)),
        stop_time=stop_time,
        step_size=step_size,
        derivatives=tuple(rates[v.name] for v in program.states) if complete else (),
    )


def _variables(program: Program) -> Iterator[FmuVariable]:
    moving = {TIME, *(v.name for v in (*program.inputs, *program.states))}
    known = moving | {v.name for v in program.parameters}
    needs = kinds(program, [*program.results, *program.constants])

    def first(node: int) -> dict[str, str]:
        """Kinds at the start, where factors are knowns themselves: only constant ones are not."""
        return {
            name: kind if kind == KINDS[0] else KINDS[-1]
            for name, kind in needs[node].items()
            if name in known
        }

    for v in program.parameters:
        variability = "tunable" if v.tunable else "fixed"
        yield _variable(v, "parameter", variability, "exact", start=v.start)
    for v, node in zip(program.calculated, program.constants, strict=True):
        tunable = any(p.tunable for p in program.parameters if p.name in needs[node])
        variability = "tunable" if tunable else "fixed"
        yield _variable(v, "calculatedParameter", variability, "calculated", first=first(node))
    for v in program.inputs:
        yield _variable(v, "input", "continuous", None, start=v.start)
    for v in program.states:
        now = {v.name: "constant"}
        yield _variable(
            v, "local" if v.local else "output", "continuous", "exact", start=v.start, now=now
        )
    for v, node in zip(program.outputs, program.results, strict=True):
        now = {name: kind for name, kind in needs[node].items() if name in moving}
        yield _variable(
            v,
            "local" if v.local else "output",
            "continuous",
            "calculated",
            now=now,
            first=first(node),
        )


def _variable(
    v: Variable,
    causality: str,
    variability: str,
    initial: str | None,
    *,
    start: float | None = None,
    now: Mapping[str, str] | None = None,
    first: Mapping[str, str] | None = None,
) -> FmuVariable:
    """A variable of a program; `now` and `first` are kinds of dependencies by name."""
    now, first = now or {}, first or {}
    return FmuVariable(
        name=v.name,
        unit=v.unit,
        description=v.description,
        causality=causality,
        variability=variability,
        initial=initial,
        start=start,
        dependencies=tuple(now),
        initial_dependencies=tuple(first),
        kinds=tuple(now.values()),
        initial_kinds=tuple(first.values()),
        derivative_of=v.derivative_of,
        display_unit=v.display_unit,
        minimum=v.minimum,
        maximum=v.maximum,
        nominal=v.nominal,
    )


def with_rates(program: Program) -> Program:
    """`program` with the rate of every state as an output: local ``der(x)`` where none is it."""
    shown = _rates_shown(program)
    missing = [
        (v, node)
        for v, node in zip(program.states, program.rates, strict=True)
        if v.name not in shown
    ]
    rates = [
        Variable(
            f"der({v.name})",
            _rate_unit(v.unit),
            f"Rate: {v.description}".removesuffix(": "),
            derivative_of=v.name,
            local=True,
        )
        for v, _ in missing
    ]
    return replace(
        program,
        outputs=(*program.outputs, *rates),
        results=(*program.results, *(node for _, node in missing)),
    )


def _rate_unit(unit: str) -> str:
    """The unit of the time derivative of what has `unit`."""
    if unit.endswith("/s"):
        return f"{unit}2"
    return f"{unit}.s" if "/" in unit else f"{unit}/s"


def _rates_shown(program: Program) -> dict[str, str]:
    """State → the output that is its rate."""
    rates = {v.name: k for v, k in zip(program.states, program.rates, strict=True)}
    outputs = zip(program.outputs, program.results, strict=True)
    return {
        y.derivative_of: y.name
        for y, k in outputs
        if y.derivative_of and rates.get(y.derivative_of) == k
    }


def expected_description(source: Program | PythonSource, path: Path) -> Description:
    """The description of the FMU of `source` that is to be built at `path`, as it will be read.

    It has the variables and which input is the rate of which; of dependencies and of what the FMU
    can do it tells nothing.
    """
    options = Options()
    if isinstance(source, Program):
        found = described(shown(source, options), options)
    else:
        found = asked(source.description, options)
    count: dict[str, int] = {}
    variables = {}
    for v in found.variables:
        reference = count[v.type] = count.get(v.type, -1) + 1
        unit = v.unit if v.type == "Real" else ""
        variables[v.name] = ReadVariable(
            name=v.name,
            value_reference=reference,
            type=v.type,
            causality=v.causality,
            variability=v.variability,
            initial="exact" if v.causality == "input" else v.initial,
            unit=unit,
            dimension=parse_unit(unit) if unit else None,
            offset=0.0,
            description=v.description,
            derivative_of=v.derivative_of,
            nominal=v.nominal,
            fmi_type=v.type,
            start=None if v.start is None else str(v.start),
            minimum=v.minimum,
            maximum=v.maximum,
        )
    inputs = {v.name for v in found.variables if v.causality == "input"}
    return Description(
        path=path,
        identifier=found.name,
        guid="",
        variables=variables,
        dependencies={},
        initial_dependencies={},
        undeclared=frozenset(),
        output_derivatives={},
        input_derivatives={
            v.derivative_of: v.name
            for v in found.variables
            if v.derivative_of is not None and {v.name, v.derivative_of} <= inputs
        },
        tool=OWN_TOOL,
    )
