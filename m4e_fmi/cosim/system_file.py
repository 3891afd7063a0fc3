"""Reading `system.yaml`: all that is wrong with it is told at once, in place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StringConstraints

from m4e_fmi.cosim.connection import parse_connection, unknown_component
from m4e_fmi.cosim.origins import ParameterSet
from m4e_fmi.cosim.system import (
    Component,
    FmuFile,
    Kind,
    ModelFile,
    Simulation,
    SimulationSection,
    System,
    kind_module,
    kinds,
    simulation_problems,
    step_problems,
)
from m4e_fmi.document import Document, Location, Number, Section
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.file_kinds import SYSTEM, check_keys

_NAME = re.compile(r"[A-Za-z_]\w*$")

BusName = Annotated[str, StringConstraints(pattern=_NAME.pattern)]
SignalName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_]\w*(\.[A-Za-z_]\w*)*$")]


class _SystemSection(Section):
    name: str
    description: str = ""
    components: dict[str, dict[str, Any]]
    connections: tuple[str, ...] = ()
    inputs: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    outputs: dict[str, str] = Field(default_factory=dict)
    buses: dict[BusName, dict[SignalName, str]] = Field(default_factory=dict)
    simulation: SimulationSection


class _ComponentSection(Section):
    """What every component may have."""

    start: dict[str, bool | int | float | str] = Field(default_factory=dict)
    step_size: Number | str | None = None
    dependencies: dict[str, tuple[str, ...]] = Field(default_factory=dict)


class _FileSection(_ComponentSection):
    model: str | None = None
    fmu: str | None = None


COMMON = tuple(_ComponentSection.model_fields)


def read_system(document: Document) -> System:
    """The system that a document describes; InputError with all problems found in it."""
    check_keys(document.path, document.data, SYSTEM)
    problems: list[Problem] = []
    section: _SystemSection | None = None
    try:
        section = document.validate(_SystemSection)
    except InputError as error:
        problems += error.problems
    components = _read_components(document, problems)
    simulation = _read_simulation(document, problems)
    problems += _connection_problems(document)
    if simulation is not None:
        found = step_problems(components, simulation)
        problems += [document.problem(*problem) for problem in found]
    if problems or section is None or simulation is None:
        raise InputError(dict.fromkeys(problems))
    return System(
        name=section.name,
        components=tuple(components),
        connections=tuple(" ".join(text.split()) for text in section.connections),
        simulation=simulation,
        description=section.description,
        inputs=section.inputs,
        outputs=section.outputs,
        buses=section.buses,
        folder=document.path.parent,
        document=document,
    )


class _ParameterSection(Section):
    name: str = ""
    values: dict[str, bool | int | float | str]


def read_parameters(path: str | Path) -> ParameterSet:
    """Start values ``component.variable`` from a file: YAML with `values`, or SSP's `.ssv`.

    InputError with all problems of the file; `System.changed` takes what is read.
    """
    path = Path(path)
    if path.suffix.lower() == ".ssv":
        from m4e_fmi.cosim.ssp import read_parameter_set

        return ParameterSet(read_parameter_set(path), path, None)
    document = Document.load(path)
    return ParameterSet(document.validate(_ParameterSection).values, path, document)


def _read_simulation(document: Document, problems: list[Problem]) -> Simulation | None:
    """The simulation, as far as its keys are right: those that are not are told with the rest."""
    written = document.data.get("simulation")
    if not isinstance(written, dict):
        return None
    unknown = tuple(key for key in written if key not in SimulationSection.model_fields)
    try:
        section = document.validate(SimulationSection, at=("simulation",), drop=unknown)
    except InputError:
        return None
    found = simulation_problems(section)
    problems += [
        document.problem(("simulation", key), message, remedy) for key, message, remedy in found
    ]
    return None if found else Simulation(**section.model_dump())


def _connection_problems(document: Document) -> Iterator[Problem]:
    """Texts that are no connections, and components that are not there; the FMUs tell the rest."""
    names = [str(name) for key in ("components", "buses") for name in _mapping(document, key)]
    written = document.data.get("connections")
    for index, text in enumerate(written if isinstance(written, list) else ()):
        if not isinstance(text, str):
            continue
        at: Location = ("connections", index)
        try:
            connection = parse_connection(" ".join(text.split()))
        except ValueError as error:
            yield document.problem(at, *error.args)
            continue
        for end in (connection.left, connection.right):
            if names and (unknown := unknown_component(end, names)):
                yield document.problem(at, *unknown)


def _mapping(document: Document, key: str) -> dict[str, Any]:
    """What is written under a key at the top; nothing if that is no mapping."""
    written = document.data.get(key)
    return written if isinstance(written, dict) else {}


def _read_components(document: Document, problems: list[Problem]) -> list[Component]:
    components = []
    for name, keys in _mapping(document, "components").items():
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
        others = tuple(key for key in keys if key not in COMMON)
        own = document.validate(_ComponentSection, at=at, drop=others)
        kind = _read_kind(document, at, keys["kind"])
        return _component(name, kind, own)
    section = document.validate(_FileSection, at=at)
    path = document.path.parent / str(section.model or section.fmu)
    if not path.is_file():
        near = [p.name for p in path.parent.glob("*")] if path.parent.is_dir() else []
        message = f"no such file: {path}"
        raise InputError([document.problem((*at, given[0]), message, suggestion(path.name, near))])
    source = ModelFile(path) if given[0] == "model" else FmuFile(path)
    return _component(name, source, section)


def _component(
    name: str, source: FmuFile | ModelFile | Kind, section: _ComponentSection
) -> Component:
    return Component(
        name,
        source,
        section.start,
        step_size=section.step_size,
        dependencies=section.dependencies,
    )


def _read_kind(document: Document, at: Location, kind: Any) -> Kind:
    known = kinds()
    if not isinstance(kind, str) or kind not in known:
        remedy = suggestion(str(kind), known, "kinds")
        message = f"unknown kind {str(kind)!r}: no installed package brings it (docs/adapters.md)"
        raise InputError([document.problem((*at, "kind"), message, remedy)])
    try:
        module = kind_module(kind)
    except ImportError as error:
        message = f"kind {kind!r} is installed but cannot be imported: {error}"
        remedy = "install what is missing; `m4e-fmi doctor` tells what that is"
        raise InputError([document.problem((*at, "kind"), message, remedy)]) from error
    return Kind(kind, document.validate(module.Config, at=at, drop=("kind", *COMMON)))
