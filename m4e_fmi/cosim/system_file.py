"""Reading `system.yaml`: all problems are reported together, each at its place."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StringConstraints

from m4e_fmi.cosim.system.component import (
    Component,
    FmuFile,
    Kind,
    ModelFile,
    kind_module,
    kinds,
    step_problems,
)
from m4e_fmi.cosim.system.connection_text import parse_connection, unknown_component
from m4e_fmi.cosim.system.origins import ParameterSet
from m4e_fmi.cosim.system.processes import (
    EnvironmentSection,
    Limits,
    LimitsSection,
    Processes,
    ProcessSection,
)
from m4e_fmi.cosim.system.scenario_section import Action
from m4e_fmi.cosim.system.simulation import (
    Simulation,
    SimulationSection,
)
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, is_file, missing_file, suggestion
from m4e_fmi.files.document import Document, Location, Section, SectionType
from m4e_fmi.files.file_kinds import SYSTEM, check_keys

_NAME = re.compile(r"^[A-Za-z_]\w*$")

BusName = Annotated[str, StringConstraints(pattern=_NAME.pattern)]
SignalName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_]\w*(\.[A-Za-z_]\w*)*$")]


class _PortsSection(Section):
    """The system's own variables, and buses."""

    inputs: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    outputs: dict[str, str] = Field(default_factory=dict)
    buses: dict[BusName, dict[SignalName, str]] = Field(default_factory=dict)


ActionName = Annotated[str, StringConstraints(pattern=_NAME.pattern)]


class _SystemSection(_PortsSection):
    name: str
    description: str = ""
    components: dict[str, dict[str, Any]]
    connections: tuple[str, ...] = ()
    scenario: dict[ActionName, Action] = Field(default_factory=dict)
    simulation: SimulationSection
    limits: LimitsSection = LimitsSection()
    environment: EnvironmentSection = EnvironmentSection()


_OTHERS = tuple(_SystemSection.model_fields.keys() - _PortsSection.model_fields.keys())


class _ComponentSection(ProcessSection):
    """The keys that every component may have."""

    start: dict[str, bool | int | float | str] = Field(default_factory=dict)
    step_size: float | str | None = None
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
    components, wrong = _read_components(document, problems)
    simulation = _read_simulation(document, problems)
    problems += _connection_problems(document)
    if simulation is not None:
        found = step_problems(components, simulation)
        problems += [document.problem(p.keys, p.message, p.remedy) for p in found]
    if problems or section is None or simulation is None:
        problems += _further_problems(document, components, wrong)
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
        scenario=section.scenario,
        folder=document.path.parent,
        processes=Processes(Limits.of(section.limits), section.environment.keep),
        document=document,
    )


def _right_actions(document: Document) -> dict[str, Action]:
    """The actions without problems of their own."""
    found: dict[str, Action] = {}
    for name, keys in _mapping(document, "scenario").items():
        if isinstance(keys, dict):
            with suppress(InputError):
                found[str(name)] = document.validate(Action, at=("scenario", name))
    return found


def _further_problems(
    document: Document, components: list[Component], wrong: Mapping[str, Component | None]
) -> list[Problem]:
    """Problems of files, models and connections, beside those of the system's file itself.

    A system without problems is checked so before its FMUs are built only.
    """
    from m4e_fmi.cosim.input_checks.inputs import checked_inputs

    section = document.valid_part(_PortsSection, drop=_OTHERS) or _PortsSection()
    unread = dict.fromkeys(map(str, _mapping(document, "buses").keys() - section.buses.keys()))
    names = [*(c.name for c in components), *wrong, *section.buses, *unread]
    system = System(
        name=str(document.data.get("name")),
        components=tuple(replace(component, step_size=None) for component in components),
        connections=tuple(_connection_text(text, names) for text in _texts(document)),
        simulation=Simulation(1.0, 1.0),  # not checked here
        inputs=section.inputs,
        outputs=section.outputs,
        buses=section.buses,
        scenario=_right_actions(document),
        folder=document.path.parent,
        document=document,
    )
    return checked_inputs(system, wrong={**wrong, **unread})[0]


class _ParameterSection(Section):
    name: str = ""
    values: dict[str, bool | int | float | str]


def read_parameters(path: str | Path) -> ParameterSet:
    """Start values ``component.variable`` from a file: YAML with `values`, or SSP's `.ssv`.

    They are an argument of `System.changed`. InputError with all problems of the file.
    """
    path = Path(path)
    if path.suffix.lower() == ".ssv":
        from m4e_fmi.cosim.ssp import read_parameter_set

        return ParameterSet(read_parameter_set(path), path, None)
    document = Document.load(path)
    return ParameterSet(document.validate(_ParameterSection).values, path, document)


def _read_simulation(document: Document, problems: list[Problem]) -> Simulation | None:
    """The simulation, None if any of its settings is wrong; adds to `problems`."""
    written = document.data.get("simulation")
    if not isinstance(written, dict):
        return None
    unknown = tuple(key for key in written if key not in SimulationSection.model_fields)
    try:
        section = document.validate(SimulationSection, at=("simulation",), drop=unknown)
    except InputError:  # told of the document as a whole
        return None
    try:
        return Simulation(**section.model_dump())
    except InputError as error:
        problems += [
            document.problem(("simulation", *p.keys), p.message, p.remedy) for p in error.problems
        ]
        return None


def _connection_problems(document: Document) -> Iterator[Problem]:
    """Texts that are not connections, and unknown components; the rest needs the FMUs."""
    names = [str(name) for key in ("components", "buses") for name in _mapping(document, key)]
    for index, text in enumerate(_texts(document)):
        if not isinstance(text, str):
            continue
        at: Location = ("connections", index)
        try:
            connection = parse_connection(" ".join(text.split()))
        except InputError as error:
            yield document.problem(at, error.problems[0].message, error.problems[0].remedy)
            continue
        for end in (connection.left, connection.right):
            if names and (unknown := unknown_component(end, names)):
                yield document.problem(at, unknown.message, unknown.remedy)


def _texts(document: Document) -> list[object]:
    """The entries under `connections`; none if that is not a list."""
    written = document.data.get("connections")
    return written if isinstance(written, list) else []


def _mapping(document: Document, key: str) -> dict[str, object]:
    """The mapping under a key at the top; empty if it is not a mapping."""
    written = document.data.get(key)
    return written if isinstance(written, dict) else {}


def _connection_text(written: object, names: Collection[str]) -> str:
    """A connection as the system has it; empty for one that is wrong by its text alone."""
    text = " ".join(written.split()) if isinstance(written, str) else ""
    try:
        connection = parse_connection(text)
    except InputError:
        return ""
    ends = (connection.left, connection.right)
    return "" if any(unknown_component(end, names) for end in ends) else text


def _read_components(
    document: Document, problems: list[Problem]
) -> tuple[list[Component], dict[str, Component | None]]:
    """The components that are right; the others by name, with their valid parts."""
    components: list[Component] = []
    wrong: dict[str, Component | None] = {}
    for key, keys in _mapping(document, "components").items():
        name = str(key)  # YAML takes `true` and `1` for other things than texts
        if not isinstance(keys, dict):
            wrong[name] = None
            continue
        found: list[Problem] = []
        component = _read_component(document, ("components", key), keys, found)
        if found:
            problems += found
            wrong[name] = component
        elif component is not None:
            components.append(component)
    return components, wrong


def _read_component(
    document: Document, at: Location, keys: dict[str, object], problems: list[Problem]
) -> Component | None:
    """The component at `at` with its valid parts; adds to `problems`."""
    name = str(at[-1])
    if not _NAME.fullmatch(name):
        remedy = "use letters, digits and _, not starting with a digit"
        problems.append(document.problem(at, f"component name {name!r}", remedy))
    given = [key for key in ("model", "kind", "fmu") if key in keys]
    if len(given) != 1:
        what = f"has {' and '.join(given)}" if given else "has none of 'model', 'kind' and 'fmu'"
        remedy = "give one: 'model: x.model.yaml', 'kind: name' or 'fmu: x.fmu'"
        problems.append(document.problem(at, f"component {name!r} {what}", remedy))
        return None
    if given[0] == "kind":
        others = tuple(key for key in keys if key not in COMMON)
        own = _part(document, _ComponentSection, at, others, problems)
        kind = _read_kind(document, at, keys["kind"], problems)
        return kind and _component(name, kind, own or _ComponentSection())
    section = _part(document, _FileSection, at, (), problems)
    written = keys[given[0]]
    if not isinstance(written, str):
        return None
    path = document.path.parent / written
    if not is_file(path):
        problems.append(document.problem((*at, given[0]), *missing_file(path)))
        return None
    source = ModelFile(path) if given[0] == "model" else FmuFile(path)
    return _component(name, source, section or _FileSection())


def read_component(document: Document, name: str) -> Component:
    """One component of a system's document; InputError with all its problems."""
    problems: list[Problem] = []
    keys = document.data["components"][name]
    component = _read_component(document, ("components", name), keys, problems)
    if problems or component is None:
        raise InputError(problems)
    return component


def _part(
    document: Document,
    section: type[SectionType],
    at: Location,
    drop: tuple[str, ...],
    problems: list[Problem],
) -> SectionType | None:
    """The valid parts of the document at `at`; adds to `problems`."""
    try:
        return document.validate(section, at=at, drop=drop)
    except InputError as error:
        problems += error.problems
    return document.valid_part(section, at=at, drop=drop)


def _component(
    name: str, source: FmuFile | ModelFile | Kind, section: _ComponentSection
) -> Component:
    return Component(
        name,
        source,
        section.start,
        step_size=section.step_size,
        dependencies=section.dependencies,
        process=section.process,
        limits=Limits.of(section.limits),
    )


def _read_kind(
    document: Document, at: Location, kind: object, problems: list[Problem]
) -> Kind | None:
    """The kind with the valid parts of its configuration; adds to `problems`."""
    known = kinds()
    if not isinstance(kind, str) or kind not in known:
        remedy = suggestion(str(kind), known, "kinds")
        message = f"unknown kind {str(kind)!r}: no installed package brings it (docs/adapters.md)"
        problems.append(document.problem((*at, "kind"), message, remedy))
        return None
    try:
        module = kind_module(kind)
    except ImportError as error:
        message = f"kind {kind!r} is installed but cannot be imported: {error}"
        remedy = "install what is missing; `m4e-fmi doctor` lists it"
        problems.append(document.problem((*at, "kind"), message, remedy))
        return None
    config = _part(document, module.Config, at, ("kind", *COMMON), problems)
    return None if config is None else Kind(kind, config)
