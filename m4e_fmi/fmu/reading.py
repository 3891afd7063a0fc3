"""What an FMU file says of itself, read and checked before anything of it is unpacked or run."""

from __future__ import annotations

import math
import re
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import fmpy

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.units import BASE_UNITS, Unit, parse_unit

MODEL_DESCRIPTION = "modelDescription.xml"
MAX_UNPACKED = 2**31
"""Bytes that an FMU may unpack to."""
MAX_RATIO = 200
"""Unpacked over packed size above which an archive of more than SMALL bytes is taken for a bomb."""
SMALL = 10_000_000

KNOWN = ("input", "parameter")


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    `dimension` is the unit with its base-unit exponents and factor, None where the FMU gives no
    unit; `offset` is what the unit adds after the factor (0 for all but temperatures). `items` are
    the values of an enumeration by their names. `nominal` is the order of magnitude of a Real in
    its unit, 1 where the FMU says nothing.
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


@dataclass(frozen=True)
class Description:
    """An FMI 2.0 co-simulation FMU: its file, identity, variables and declared dependencies.

    `dependencies[y]` are the inputs that output y depends on at a communication point,
    `initial_dependencies[y]` the inputs and parameters that the initial value of output or
    calculated parameter y depends on. Where an FMU declares nothing (`undeclared`), FMI says that
    everything may matter, and that is what stands here. `output_derivatives` and
    `input_derivatives` lead from a variable to the one declared as its time derivative.
    `step_size` is the default experiment's [s], `internal_step` that by which the FMU goes inside,
    if it tells one (fixedInternalStepSize, FMI 3.0).

    What the FMU can do: `saves_state` (fmi2GetFMUstate, fmi2SetFMUstate), `interpolates_inputs`
    (fmi2SetRealInputDerivatives), `directional_derivatives` (fmi2GetDirectionalDerivative). What it
    cannot: make steps of different sizes (`constant_step`), be instantiated more than once in a
    process (`once_per_process`).
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
    step_size: float | None = None
    internal_step: float | None = None
    constant_step: bool = False
    saves_state: bool = False
    interpolates_inputs: bool = False
    directional_derivatives: bool = False
    once_per_process: bool = False

    def of_causality(self, *causalities: str) -> list[Variable]:
        return [v for v in self.variables.values() if v.causality in causalities]


def read_description(path: str | Path) -> Description:
    """The description of the FMU at `path`, after all checks that need no unpacking.

    Checked: a readable ZIP archive; its unpacked size and ratio; no name twice, none that leads
    out of the folder; a model description without DOCTYPE; FMI 2.0 for co-simulation; a binary for
    this platform. InputError names the file and the remedy.
    """
    path = Path(path)
    names, text = check_archive(path)
    version = re.search(rb'fmiVersion\s*=\s*["\']([^"\']*)', text)
    if version and version[1] != b"2.0":
        message = f"is an FMI {version[1].decode(errors='replace')} FMU; the master runs FMI 2.0"
        raise _bad(path, message, "export it as an FMI 2.0 co-simulation FMU")
    try:
        raw = fmpy.read_model_description(path, validate=False)
    except Exception as error:
        why = str(error).split("\n")[0]
        raise _bad(path, f"{MODEL_DESCRIPTION} cannot be understood: {why}", _REBUILD) from error
    _check_kind(path, raw, names)
    return _translated(path, raw)


_REBUILD = "export the FMU again; `fmpy validate` on the file tells more"


def _bad(path: Path, message: str, remedy: str) -> InputError:
    return InputError([Problem(message, remedy, str(path))])


def check_archive(path: Path) -> tuple[set[str], bytes]:
    """Names in the FMU at `path`, and its model description (bytes of the XML file).

    InputError if it is no readable archive with a model description, or should not be unpacked.
    """
    if not path.is_file():
        near = [p.name for p in path.parent.glob("*.fmu")] if path.parent.is_dir() else []
        raise _bad(path, "no such file", suggestion(path.name, near, "FMUs here"))
    try:
        with zipfile.ZipFile(path) as archive:
            infos = archive.infolist()
            check_entries(path, infos)
            if MODEL_DESCRIPTION not in archive.namelist():
                message = f"not an FMU: there is no {MODEL_DESCRIPTION} at the top of the archive"
                raise _bad(path, message, "pack the content of the folder, not the folder itself")
            text = archive.read(MODEL_DESCRIPTION)
            if b"<!DOCTYPE" in text:
                message = f"{MODEL_DESCRIPTION} has a DOCTYPE, which FMI does not use"
                raise _bad(path, message, "do not use this file unless you know why it has one")
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError) as error:
        remedy = "copy or export the file again: it is truncated, or was never an FMU"
        raise _bad(path, f"not a readable ZIP archive: {error}", remedy) from error
    return {info.filename for info in infos}, text


def check_entries(path: Path, infos: list[zipfile.ZipInfo]) -> None:
    """InputError if an archive should not be unpacked: see `read_description`."""
    distrust = "do not use this file: no tool that exports FMUs writes such an archive"
    seen: set[str] = set()
    for info in infos:
        name = info.filename
        if name in seen:
            raise _bad(path, f"the archive holds {name!r} twice", distrust)
        seen.add(name)
        if "\\" in name or ":" in name or name.startswith("/") or ".." in name.split("/"):
            raise _bad(path, f"the archive holds {name!r}, which leads out of its folder", distrust)
    unpacked = sum(info.file_size for info in infos)
    packed = max(1, sum(info.compress_size for info in infos))
    if unpacked > MAX_UNPACKED or (unpacked > SMALL and unpacked / packed > MAX_RATIO):
        size = f"{unpacked / 1e6:.0f} MB from {packed / 1e6:.2f} MB"
        raise _bad(path, f"the archive would unpack to {size}", distrust)


def _check_kind(path: Path, raw: Any, names: set[str]) -> None:
    if raw.coSimulation is None:
        message = "is a model-exchange FMU: it has no solver of its own"
        raise _bad(path, message, "export it for co-simulation")
    binary = raw.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
    if f"binaries/{fmpy.platform}/{binary}" not in names:
        there = sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and n[9:]})
        message = f"has no binary for this platform, {fmpy.platform}/{binary}"
        remedy = f"it has: {', '.join(there) or 'none'}; export it for {fmpy.platform}"
        raise _bad(path, message, remedy)


def _translated(path: Path, raw: Any) -> Description:
    units = {unit.name: unit for unit in raw.unitDefinitions}
    variables = {v.name: _variable(v, units) for v in raw.modelVariables}
    inputs = frozenset(n for n, v in variables.items() if v.causality == "input")
    known = frozenset(n for n, v in variables.items() if v.causality in KNOWN)
    undeclared: set[str] = set()

    def declared(unknowns: list[Any], all_known: frozenset[str]) -> dict[str, frozenset[str]]:
        found = {}
        for unknown in unknowns:
            if unknown.dependencies is None:
                undeclared.add(unknown.variable.name)
                found[unknown.variable.name] = all_known
            else:
                found[unknown.variable.name] = frozenset(d.name for d in unknown.dependencies)
        return found

    now = {name: needs & inputs for name, needs in declared(raw.outputs, inputs).items()}
    initial = declared(raw.initialUnknowns, known)
    for name, variable in variables.items():
        if variable.causality not in ("output", "calculatedParameter"):
            continue
        if variable.causality == "output" and name not in now:
            undeclared.add(name)
            now[name] = inputs
        if name not in initial:
            exact = variable.initial == "exact"
            initial[name] = frozenset() if exact else known
            if not exact:
                undeclared.add(name)
    return Description(
        path=path,
        identifier=raw.coSimulation.modelIdentifier,
        guid=raw.guid or "",
        variables=variables,
        dependencies=now,
        initial_dependencies=initial,
        undeclared=frozenset(undeclared),
        output_derivatives=_derivatives(variables, "output"),
        input_derivatives=_derivatives(variables, "input"),
        step_size=_step_size(raw.defaultExperiment),
        internal_step=_internal_step(raw.coSimulation),
        constant_step=not raw.coSimulation.canHandleVariableCommunicationStepSize,
        saves_state=bool(raw.coSimulation.canGetAndSetFMUstate),
        interpolates_inputs=bool(raw.coSimulation.canInterpolateInputs),
        directional_derivatives=bool(raw.coSimulation.providesDirectionalDerivative),
        once_per_process=bool(raw.coSimulation.canBeInstantiatedOnlyOncePerProcess),
    )


def _step_size(experiment: Any) -> float | None:
    text = experiment.stepSize if experiment is not None else None
    return float(text) if text else None  # FMPy leaves it a text


def _internal_step(kind: Any) -> float | None:
    step = float(kind.fixedInternalStepSize or 0.0)
    return step if 0.0 < step < math.inf else None


def _derivatives(variables: dict[str, Variable], causality: str) -> dict[str, str]:
    """Name of a variable → name of its time derivative, among variables of one causality."""
    of_causality = {n: v for n, v in variables.items() if v.causality == causality}
    return {
        v.derivative_of: name
        for name, v in of_causality.items()
        if v.derivative_of is not None and v.derivative_of in of_causality
    }


def _variable(raw: Any, units: dict[str, Any]) -> Variable:
    unit = raw.unit or (raw.declaredType.unit if raw.declaredType is not None else None) or ""
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
        items=_items(raw.declaredType),
        nominal=_nominal(raw),
    )


def _nominal(raw: Any) -> float:
    """The size of the nominal value, of the variable or its type; 1 where there is none above 0."""
    text = raw.nominal or (raw.declaredType.nominal if raw.declaredType is not None else None)
    try:
        size = abs(float(text or 1.0))
    except ValueError:
        return 1.0
    return size if 0.0 < size < math.inf else 1.0


def _items(declared: Any) -> dict[str, int]:
    """Values of an enumeration type by name; empty for any other type."""
    items = declared.items if declared is not None else None
    return {item.name: int(item.value) for item in items or ()}


def _dimension(text: str, definition: Any) -> tuple[Unit | None, float]:
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
