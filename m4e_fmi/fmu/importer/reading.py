"""The description of an FMU file, read and checked before anything of it is unpacked or run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import fmpy
from fmpy.model_description import ModelVariable, ValidationError
from fmpy.model_description import Unit as RawUnit

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.files_read import file_hash
from m4e_fmi.fmu.importer.elements import (
    SCALARS,
    FmpyDescription,
    FmpyUnknown,
    flattened,
    owner,
    translate_1,
    unit_of,
)
from m4e_fmi.fmu.importer.flaws import flaws
from m4e_fmi.fmu.importer.opening import MODEL_DESCRIPTION, check_archive, refusal
from m4e_fmi.shown import listing
from m4e_fmi.units import BASE_UNITS, Unit, parse_unit

KNOWN = ("input", "parameter")
MOST_ELEMENTS = 1_000_000
"""Elements that the arrays of an FMU may have together."""
STRUCTURAL = "structuralParameter"
MOST_DERIVATIVES = 2
"""Highest time derivative of inputs that is used; FMUs do not declare which they take."""
OWN_TOOL = "m4e_fmi "
"""Beginning of the generation tool of FMUs that are built here; a version follows."""


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    `dimension` is the unit with its base-unit exponents and factor, None where the FMU gives no
    unit; `offset` is what the unit adds after the factor (0 for all but temperatures). `items` are
    the values of an enumeration by their names. `nominal` is the order of magnitude of a Real in
    its unit, 1 where the FMU says nothing, `minimum` and `maximum` are its range. `type` is FMI
    2.0's name for what `fmi_type` is called in the FMU's own version, `start` the start value as
    the FMU writes it. Of an element of an array, `value_reference` is a key: see `elements.locate`.
    """

    name: str
    value_reference: int
    type: str
    causality: str
    variability: str
    initial: str | None
    unit: str
    dimension: Unit | None
    offset: float
    description: str
    derivative_of: str | None
    items: Mapping[str, int] = field(default_factory=dict)
    nominal: float = 1.0
    fmi_type: str = ""
    start: str | None = None
    minimum: float = -math.inf
    maximum: float = math.inf


@dataclass(frozen=True)
class Description:
    """A co-simulation FMU: its file, identity, variables and declared dependencies.

    `content` is the SHA-256 of the file as it was read, which is not used once it is another.

    `version` is 1.0, 2.0 or 3.0; the rest is told in FMI 2.0's words, arrays as their elements.
    `dependencies[y]` are the inputs that output y depends on at a communication point,
    `initial_dependencies[y]` the inputs and parameters that the initial value of output or
    calculated parameter y depends on. Where an FMU declares nothing (`undeclared`, for outputs at a
    communication point), FMI says that everything may matter, and that is what stands here;
    `resolved` tells of outputs whose dependencies are known from elsewhere, and how (see
    `cosim.wiring.structure`). `output_derivatives` and `input_derivatives` lead from a variable to
    the one declared as its time derivative.
    `start_time`, `stop_time` and `step_size` are the default experiment's [s], `internal_step` that
    by which the FMU goes inside, if it tells one (fixedInternalStepSize, FMI 3.0), `tool` the one
    that made it.

    What the FMU can do: `saves_state` (fmi2GetFMUstate, fmi2SetFMUstate), `serializes_state`
    (fmi2SerializeFMUstate, fmi2DeSerializeFMUstate), follow time derivatives of inputs up to
    the `input_order` (fmi2SetRealInputDerivatives; 0: none), `directional_derivatives`
    (fmi2GetDirectionalDerivative), `has_events` (event mode, FMI 3.0). What it cannot: make
    steps of different sizes (`constant_step`), be instantiated more than once in a process
    (`once_per_process`).
    """

    path: Path
    identifier: str
    guid: str
    variables: dict[str, Variable] = field(repr=False)
    dependencies: dict[str, frozenset[str]] = field(repr=False)
    initial_dependencies: dict[str, frozenset[str]] = field(repr=False)
    undeclared: frozenset[str] = field(repr=False)
    output_derivatives: dict[str, str] = field(repr=False)
    input_derivatives: dict[str, str] = field(repr=False)
    resolved: Mapping[str, str] = field(default_factory=dict, repr=False)
    version: str = "2.0"
    start_time: float = 0.0
    stop_time: float | None = None
    step_size: float | None = None
    internal_step: float | None = None
    constant_step: bool = False
    saves_state: bool = False
    serializes_state: bool = False
    input_order: int = 0
    directional_derivatives: bool = False
    has_events: bool = False
    once_per_process: bool = False
    tool: str = ""
    content: str = ""

    @property
    def is_own(self) -> bool:
        """True of an FMU that was built by this package."""
        return self.tool.startswith(OWN_TOOL)

    def of_causality(self, *causalities: str) -> list[Variable]:
        """The variables of these causalities."""
        return [v for v in self.variables.values() if v.causality in causalities]

    def __repr__(self) -> str:
        kinds = ("parameter", "input", "output")
        groups = {f"{kind}s": self.of_causality(kind) for kind in kinds}
        title = f"Description of {self.path.name!r}: FMI {self.version}"
        return listing(f"{title}, {len(self.variables)} variables", **groups)


def read_description(path: str | Path, structure: Mapping[str, int] | None = None) -> Description:
    """The description of the FMU at `path`, after all checks that need no unpacking.

    `structure` has values for structural parameters, which are sizes of arrays; the others are at
    their defaults. Checked: a readable ZIP archive; its unpacked size and ratio; no name twice with
    different contents, none that leads out of the folder; a model description without DOCTYPE; FMI
    1.0, 2.0 or 3.0 for co-simulation, without another tool and without clocks that the master would
    have to drive; a binary for this platform. InputError names the file and the remedy.
    """
    path = Path(path)
    content = file_hash(path) or ""
    names, text = check_archive(path)
    raw = raw_description(path, text)
    tool = translate_1(raw, text) if raw.fmiVersion == "1.0" else ""
    _check_kind(path, raw, names, tool)
    if not raw.fmiVersion.startswith("3."):
        return replace(_translated(path, raw, {}), content=content)
    _resize(path, raw, structure or {})
    types = {v.valueReference: v.type for v in raw.modelVariables}
    flat = flattened(raw, text, SCALARS)
    return replace(_translated(path, flat, types), content=content)


def resized(description: Description, start: Mapping[str, object]) -> Description:
    """The description of the FMU with the start values that structural parameters are given."""
    variables = description.variables
    structure = {
        name: value
        for name, value in start.items()
        if name in variables
        and variables[name].causality == STRUCTURAL
        and isinstance(value, int)
        and value >= 0
    }
    return read_description(description.path, structure) if structure else description


def raw_description(path: Path, text: bytes) -> FmpyDescription:
    """FMPy's reading of the FMU at `path`, whose model description is `text`.

    InputError with the lines of all that cannot be understood.
    """
    cannot = f"{MODEL_DESCRIPTION} cannot be understood"
    if found := flaws(text):
        raise InputError(
            Problem(f"{cannot}: line {flaw.line}: {flaw.message}", _REBUILD, str(path))
            for flaw in found
        )
    try:
        return fmpy.read_model_description(path, validate=False)
    except Exception as error:
        raise refusal(path, f"{cannot}: {fmpy_message(error)}", _REBUILD) from error


def fmpy_message(error: Exception) -> str:
    """Text of an error of FMPy's: its words, or where it has none, its kind and text."""
    own = type(error) is Exception or isinstance(error, ValidationError)
    text = str(error) if own else f"FMPy stops with {type(error).__name__}: {error}"
    return text.split("\n")[0]


_REBUILD = "export the FMU again; `m4e-fmi validate` on the file reports details"


def _check_kind(path: Path, raw: FmpyDescription, names: set[str], tool: str) -> None:
    if raw.coSimulation is None:
        kind = "scheduled-execution" if raw.scheduledExecution is not None else "model-exchange"
        message = f"is a {kind} FMU: it has no solver"
        raise refusal(path, message, "export it for co-simulation")
    if tool:
        message = f"needs {tool} while it runs (CoSimulation_Tool), which the master cannot start"
        raise refusal(path, message, "export it stand-alone (CoSimulation_StandAlone)")
    for v in raw.modelVariables:
        timed = v.intervalVariability not in (None, "triggered")
        if v.type == "Clock" and (v.causality == "input" or timed):
            message = f"needs a master with clocks: {v.name!r} is one that it would have to tick"
            raise refusal(path, message, "export it without clocked partitions")
    binary = raw.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
    platform = fmpy.platform_tuple if raw.fmiVersion.startswith("3.") else fmpy.platform
    if f"binaries/{platform}/{binary}" not in names:
        libraries = (name[9:] for name in sorted(names) if name.startswith("binaries/"))
        there = [name for name in libraries if name.endswith((".so", ".dll", ".dylib"))]
        message = f"has no binary for this platform, {platform}/{binary}"
        remedy = f"it has: {', '.join(there[:5]) or 'none'}; export it for {platform}"
        if any(name.startswith(f"{platform}/") for name in there):
            remedy += ", with a library of the name that its modelIdentifier says"
        raise refusal(path, message, remedy)


def _resize(path: Path, raw: FmpyDescription, structure: Mapping[str, int]) -> None:
    """Give arrays the shapes that follow from values of structural parameters."""
    count = 0
    for variable in raw.modelVariables:
        sizes = [
            d.start if d.variable is None else structure.get(d.variable.name, int(d.variable.start))
            for d in variable.dimensions
        ]
        variable.shape = tuple(sizes)
        count += math.prod(sizes)
    if count > MOST_ELEMENTS:
        message = f"its arrays have {count} elements together; {MOST_ELEMENTS} are taken at most"
        raise refusal(path, message, "make its structural parameters smaller")


def _translated(path: Path, raw: FmpyDescription, types: Mapping[int, str]) -> Description:
    """The description in FMI 2.0's words; `types` are FMI 3.0's, by value reference."""
    units = {unit.name: unit for unit in raw.unitDefinitions}
    variables = {v.name: _variable(v, units, types) for v in raw.modelVariables}
    inputs = frozenset(n for n, v in variables.items() if v.causality == "input")
    known = frozenset(n for n, v in variables.items() if v.causality in KNOWN)

    def declared(unknowns: list[FmpyUnknown]) -> dict[str, frozenset[str]]:
        return {
            unknown.variable.name: frozenset(d.name for d in unknown.dependencies)
            for unknown in unknowns
            if unknown.dependencies is not None
        }

    now = {name: needs & inputs for name, needs in declared(raw.outputs).items()}
    initial = declared(raw.initialUnknowns)
    outputs = [name for name, v in variables.items() if v.causality == "output"]
    tool = raw.generationTool or ""
    keys = ("startTime", "stopTime", "stepSize")
    times = [getattr(raw.defaultExperiment, key, None) for key in keys]  # FMPy leaves them texts
    start, stop, step = (float(time) if time else None for time in times)
    internal = float(raw.coSimulation.fixedInternalStepSize or 0.0)
    # native FMUs of ours leave out long lists of all, and no others
    whole = tool.startswith(OWN_TOOL) and raw.modelExchange is not None
    undeclared = frozenset(name for name in outputs if name not in now and not whole)
    now |= dict.fromkeys([name for name in outputs if name not in now], inputs)
    for name, variable in variables.items():
        if variable.causality in ("output", "calculatedParameter") and name not in initial:
            initial[name] = frozenset() if variable.initial == "exact" else known
    return Description(
        path=path,
        identifier=raw.coSimulation.modelIdentifier,
        guid=raw.guid or "",
        version=raw.fmiVersion[:3],
        variables=variables,
        dependencies=now,
        initial_dependencies=initial,
        undeclared=undeclared,
        output_derivatives=_derivatives(variables, "output"),
        input_derivatives=_derivatives(variables, "input"),
        start_time=start or 0.0,
        stop_time=stop,
        step_size=step,
        internal_step=internal if 0.0 < internal < math.inf else None,
        constant_step=not raw.coSimulation.canHandleVariableCommunicationStepSize,
        saves_state=bool(raw.coSimulation.canGetAndSetFMUstate),
        serializes_state=bool(raw.coSimulation.canSerializeFMUstate),
        input_order=MOST_DERIVATIVES if raw.coSimulation.canInterpolateInputs else 0,
        directional_derivatives=bool(raw.coSimulation.providesDirectionalDerivative),
        has_events=bool(raw.coSimulation.hasEventMode),
        once_per_process=bool(raw.coSimulation.canBeInstantiatedOnlyOncePerProcess),
        tool=tool,
    )


def _derivatives(variables: dict[str, Variable], causality: str) -> dict[str, str]:
    """Name of a variable → name of its time derivative, among variables of one causality."""
    of_causality = {n: v for n, v in variables.items() if v.causality == causality}
    return {
        v.derivative_of: name
        for name, v in of_causality.items()
        if v.derivative_of is not None and v.derivative_of in of_causality
    }


def _variable(
    raw: ModelVariable, units: Mapping[str | None, RawUnit], types: Mapping[int, str]
) -> Variable:
    unit, nominal = unit_of(raw), abs(declared_number(raw, "nominal", 1.0))
    dimension, offset = _dimension(unit, units.get(unit))
    return Variable(
        name=raw.name,
        value_reference=raw.valueReference,
        type=raw.type,
        causality=raw.causality,
        variability=raw.variability,
        initial=raw.initial,
        unit=unit,
        dimension=dimension,
        offset=offset,
        description=raw.description or "",
        derivative_of=raw.derivative.name if raw.derivative is not None else None,
        items={i.name: int(i.value) for i in getattr(raw.declaredType, "items", None) or ()},
        nominal=nominal if 0.0 < nominal < math.inf else 1.0,
        fmi_type=types.get(owner(raw), raw.type),
        start=raw.start,
        minimum=declared_number(raw, "min", -math.inf),
        maximum=declared_number(raw, "max", math.inf),
    )


def declared_number(raw: ModelVariable, name: str, default: float) -> float:
    """The attribute of a Real called `name`, as `min`, of the variable or its type, in its unit."""
    text = getattr(raw, name) or getattr(raw.declaredType, name, None)
    try:
        return float(text) if text is not None else default
    except ValueError:
        return default


def _dimension(text: str, definition: RawUnit | None) -> tuple[Unit | None, float]:
    """The unit as the FMU defines it; as its text reads, where the FMU only names it."""
    if not text:
        return None, 0.0
    if definition is not None and definition.baseUnit is not None:
        base = definition.baseUnit
        exponents = tuple(int(getattr(base, name) or 0) for name in BASE_UNITS)
        return Unit(text, exponents, float(base.factor)), float(base.offset)
    try:
        return parse_unit(text), 0.0
    except ValueError:
        return None, 0.0
