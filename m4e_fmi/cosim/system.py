"""What is coupled and how: components, connections, simulation; from a file or from Python."""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import Field

from m4e_fmi.document import Document, Location, Section
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.units import Quantity

ALGORITHMS = ("corrector", "gauss_seidel", "implicit", "jacobi")
ADAPTIVE = ("corrector",)
"""Those that can choose their steps by a coupling tolerance."""
SOLVES_LOOPS = ("implicit",)
"""Those that solve algebraic loops."""
KIND_GROUP = "m4e_fmi.fmus"
SECOND = 1_000_000_000
"""Nanoseconds, in which the master counts time."""

Start = Mapping[str, float | int | bool | str | Quantity]
_NAME = re.compile(r"[A-Za-z_]\w*$")


@dataclass(frozen=True)
class FmuFile:
    """A component that is there already as an FMU."""

    path: Path


@dataclass(frozen=True)
class ModelFile:
    """A component to be built from a multibody model (`*.model.yaml`)."""

    path: Path


@dataclass(frozen=True)
class Kind:
    """A component to be built by the entry point `name` of the group `m4e_fmi.fmus`.

    `config` is an instance of that entry point's `Config`.
    """

    name: str
    config: Section


@dataclass(frozen=True)
class Component:
    """One FMU of the system.

    `start` holds start values by variable name: in the FMU's unit, or with one of their own (a
    Quantity, or a text as ``"5 mm"``).
    """

    name: str
    source: FmuFile | ModelFile | Kind
    start: Start = field(default_factory=dict)


@dataclass(frozen=True)
class Simulation:
    """How long and how: all times in seconds.

    `step_size` is the time between communication points; `output_interval`, a multiple of it, the
    time between rows of the results (None: every point). `tolerance` (relative) is handed to the
    FMUs that integrate with error control; None leaves them their own. `coupling_tolerance`
    (relative) makes the steps adaptive, none larger than `step_size`: None keeps them fixed.
    """

    stop_time: float
    step_size: float
    algorithm: str = ALGORITHMS[0]
    output_interval: float | None = None
    start_time: float = 0.0
    tolerance: float | None = None
    coupling_tolerance: float | None = None

    def __post_init__(self) -> None:
        problems = [Problem(message, remedy) for _, message, remedy in _simulation_problems(self)]
        if problems:
            raise InputError(problems)


@dataclass(frozen=True)
class System:
    """Components, the connections between them, and the simulation.

    A connection is text: ``a.group <-> b.group`` connects connectors, ``a.variable -> b.variable``
    one variable or all elements of an array, ``a.variable * 2.5 + 1 -> b.variable`` with a factor
    and an offset. `folder` is what relative file names in the
    components' configurations refer to; `document` the file it came from, None from Python.
    """

    name: str
    components: tuple[Component, ...]
    connections: tuple[str, ...]
    simulation: Simulation
    description: str = ""
    folder: Path = field(default_factory=Path)
    document: Document | None = field(default=None, repr=False, compare=False)

    @classmethod
    def load(cls, path: str | Path) -> System:
        """The system that a YAML file describes; InputError with all problems found in it."""
        return _read(Document.load(path))

    def changed(self, *, start: Start | None = None, **simulation: Any) -> System:
        """The same system with other start values and simulation settings.

        `start` maps ``component.variable`` to a value; settings that are None stay as they are.
        InputError for a component that is not there or settings that do not fit.
        """
        components = {component.name: component for component in self.components}
        for name, value in (start or {}).items():
            component, _, variable = name.partition(".")
            if component not in components or not variable:
                remedy = suggestion(component, components, "components")
                message = f"start value {name!r}: expected COMPONENT.VARIABLE"
                raise InputError([Problem(message, remedy)])
            old = components[component]
            components[component] = replace(old, start={**old.start, variable: value})
        given = {key: value for key, value in simulation.items() if value is not None}
        return replace(
            self,
            components=tuple(components.values()),
            simulation=replace(self.simulation, **given),
        )

    def problem(self, location: Location, message: str, remedy: str = "") -> Problem:
        """A problem with the part of the system at `location`, placed in its file if it has one."""
        if self.document is not None:
            return self.document.problem(location, message, remedy)
        return Problem(f"{self.name}: {message}", remedy)


def kinds() -> dict[str, Any]:
    """Entry points of the kinds of FMU that are installed, by name."""
    return {point.name: point for point in entry_points(group=KIND_GROUP)}


def kind_module(name: str) -> ModuleType:
    """The module behind a kind: it offers `Config` and `make`."""
    return importlib.import_module(kinds()[name].value)


class _SimulationSection(Section):
    stop_time: float
    step_size: float
    algorithm: str = ALGORITHMS[0]
    output_interval: float | None = None
    start_time: float = 0.0
    tolerance: float | None = None
    coupling_tolerance: float | None = None


class _SystemSection(Section):
    name: str
    description: str = ""
    components: dict[str, dict[str, Any]]
    connections: tuple[str, ...] = ()
    simulation: _SimulationSection


class _FileSection(Section):
    model: str | None = None
    fmu: str | None = None
    start: dict[str, bool | int | float | str] = Field(default_factory=dict)


class _StartSection(Section):
    start: dict[str, bool | int | float | str] = Field(default_factory=dict)


def _read(document: Document) -> System:
    problems: list[Problem] = []
    section: _SystemSection | None = None
    try:
        section = document.validate(_SystemSection)
    except InputError as error:
        problems += error.problems
    components = _read_components(document, problems)
    simulation = _read_simulation(document, section, problems)
    if problems or section is None or simulation is None:
        raise InputError(dict.fromkeys(problems))
    return System(
        name=section.name,
        components=tuple(components),
        connections=tuple(" ".join(text.split()) for text in section.connections),
        simulation=simulation,
        description=section.description,
        folder=document.path.parent,
        document=document,
    )


def _read_simulation(
    document: Document, section: _SystemSection | None, problems: list[Problem]
) -> Simulation | None:
    if section is None:
        return None
    found = _simulation_problems(section.simulation)
    problems += [
        document.problem(("simulation", key), message, remedy) for key, message, remedy in found
    ]
    return None if found else Simulation(**section.simulation.model_dump())


def _simulation_problems(
    simulation: Simulation | _SimulationSection,
) -> list[tuple[str, str, str]]:
    """(key, message, remedy) for all that is wrong with times and algorithm."""
    found = []
    span = simulation.stop_time - simulation.start_time
    step = simulation.step_size
    if not (math.isfinite(span) and span > 0):
        text = f"stop_time {simulation.stop_time:g} s is not after the start"
        found.append(("stop_time", text, f"start_time is {simulation.start_time:g} s"))
    if not (math.isfinite(step) and step * SECOND >= 1):
        found.append(("step_size", f"step_size {step:g} s: expected 1e-9 s or more", ""))
    elif span > 0 and step > span:
        found.append(
            ("step_size", f"step_size {step:g} s is longer than the run of {span:g} s", "")
        )
    interval = simulation.output_interval
    if interval is not None and step * SECOND >= 1:
        count = round(interval * SECOND) / round(step * SECOND)
        if count < 1 or count != int(count):
            text = f"output_interval {interval:g} s is not a multiple of step_size {step:g} s"
            remedy = f"take {max(1, round(count)) * step:g} s, or leave it out"
            found.append(("output_interval", text, remedy))
    for key in ("tolerance", "coupling_tolerance"):
        tolerance = getattr(simulation, key)
        if tolerance is not None and not 0 < tolerance < 1:
            text = f"{key} {tolerance:g}: expected a number between 0 and 1"
            found.append((key, text, "1e-6 is usual"))
    if simulation.coupling_tolerance is not None and simulation.algorithm not in ADAPTIVE:
        text = f"{simulation.algorithm} does not estimate its error, which coupling_tolerance needs"
        found.append(("coupling_tolerance", text, f"choose algorithm: {' or '.join(ADAPTIVE)}"))
    if simulation.algorithm not in ALGORITHMS:
        text = f"unknown algorithm {simulation.algorithm!r}"
        found.append(("algorithm", text, suggestion(simulation.algorithm, ALGORITHMS)))
    return found


def _read_components(document: Document, problems: list[Problem]) -> list[Component]:
    written = document.data.get("components")
    components = []
    for name, keys in written.items() if isinstance(written, dict) else ():
        if not isinstance(keys, dict):
            continue
        try:
            components.append(_read_component(document, str(name), keys))
        except InputError as error:
            problems += error.problems
    return components


def _read_component(document: Document, name: str, keys: dict[str, Any]) -> Component:
    at: Location = ("components", name)
    if not _NAME.match(name):
        remedy = "use letters, digits and _, not starting with a digit"
        raise InputError([document.problem(at, f"component name {name!r}", remedy)])
    given = [key for key in ("model", "kind", "fmu") if key in keys]
    if len(given) != 1:
        what = f"has {' and '.join(given)}" if given else "has none of 'model', 'kind' and 'fmu'"
        remedy = "give one: 'model: x.model.yaml', 'kind: name' or 'fmu: x.fmu'"
        raise InputError([document.problem(at, f"component {name!r} {what}", remedy)])
    if given[0] == "kind":
        start: Start = {}
        if "start" in keys:
            others = tuple(key for key in keys if key != "start")
            start = document.validate(_StartSection, at=at, drop=others).start
        return Component(name, _read_kind(document, at, keys["kind"]), start)
    section = document.validate(_FileSection, at=at)
    path = document.path.parent / str(section.model or section.fmu)
    if not path.is_file():
        near = [p.name for p in path.parent.glob("*")] if path.parent.is_dir() else []
        message = f"no such file: {path}"
        raise InputError([document.problem((*at, given[0]), message, suggestion(path.name, near))])
    source = ModelFile(path) if given[0] == "model" else FmuFile(path)
    return Component(name, source, section.start)


def _read_kind(document: Document, at: Location, kind: Any) -> Kind:
    known = kinds()
    if kind not in known:
        remedy = suggestion(str(kind), known, "kinds")
        raise InputError([document.problem((*at, "kind"), f"unknown kind {str(kind)!r}", remedy)])
    try:
        module = kind_module(kind)
    except ImportError as error:
        message = f"kind {kind!r} is installed but cannot be imported: {error}"
        remedy = "install what is missing; `m4e-fmi doctor` tells what that is"
        raise InputError([document.problem((*at, "kind"), message, remedy)]) from error
    return Kind(kind, document.validate(module.Config, at=at, drop=("kind", "start")))
