"""Reading `system.yaml`: all problems are reported together, each at its place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints

from m4e_fmi.cosim.ssp.parameters import read_parameter_set
from m4e_fmi.cosim.ssp.read import STEPS, STOP_TIME, read_ssp
from m4e_fmi.cosim.system.component import (
    Component,
    FmuFile,
    Kind,
    ModelFile,
    Processes,
    ProcessLimits,
    kind_of,
    kinds,
)
from m4e_fmi.cosim.system.connection_text import parse_connection, unknown_component
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.system.system import Action, ParameterSet, System
from m4e_fmi.errors import InputError, Problem, is_file, missing_file, suggestion
from m4e_fmi.files.document import Document, Location, Section
from m4e_fmi.files.file_kinds import FMU_SUFFIX, SSP_SUFFIX, SYSTEM, as_path, check_keys
from m4e_fmi.fmu.importer.reading import read_description

_NAME = re.compile(r"^[A-Za-z_]\w*$")

ActionName = Annotated[str, StringConstraints(pattern=_NAME.pattern)]


class _EnvironmentSection(Section):
    """`keep`: variables of the environment that FMUs get in processes of their own."""

    keep: tuple[str, ...] = ()


class _SystemSection(Section):
    """A system; `inputs` and `outputs` are its own variables."""

    inputs: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    outputs: dict[str, str] = Field(default_factory=dict)
    name: str
    description: str = ""
    components: dict[str, dict[str, Any]]
    connections: tuple[str, ...] = ()
    scenario: dict[ActionName, Action] = Field(default_factory=dict)
    simulation: Simulation
    limits: ProcessLimits = ProcessLimits()
    environment: _EnvironmentSection = _EnvironmentSection()


class _ComponentSection(Section):
    """The keys that every component may have."""

    process: Literal["own", "here"] | None = None
    start: dict[str, bool | int | float | str] = Field(default_factory=dict)
    step_size: float | str | None = None
    dependencies: dict[str, tuple[str, ...]] = Field(default_factory=dict)


class _FileSection(_ComponentSection):
    model: str | None = None
    fmu: str | None = None


COMMON = tuple(_ComponentSection.model_fields)


def load_system(path: str | Path) -> System:
    """The system in a YAML file or an SSP package, or of one FMU, which is its only component.

    InputError with all problems found in it.
    """
    suffix = as_path(path).suffix.lower()
    if suffix == SSP_SUFFIX:
        return read_ssp(path)
    if suffix == FMU_SUFFIX:
        return _system_of_fmu(Path(path))
    return read_system(Document.load(path))


def _system_of_fmu(path: Path) -> System:
    """The system whose only component is an FMU, with the times of its default experiment."""
    fmu = read_description(path)
    notes, start, stop = [], fmu.start_time, fmu.stop_time
    if stop is None:
        stop = start + STOP_TIME
        notes.append(f"names no stop time: {stop:g} s is taken (--stop-time)")
    step = fmu.step_size or fmu.internal_step
    if step is None:
        step = (stop - start) / STEPS
        notes.append(f"names no step: {step:g} s is taken (--step-size)")
    return System(
        path.stem,
        (Component(fmu.identifier, FmuFile(path.absolute())),),
        (),
        Simulation(stop, step, start_time=start),
        notes=tuple(notes),
    )


def read_system(document: Document) -> System:
    """The system that a document describes; InputError with all problems of the document."""
    check_keys(document.path, document.data, SYSTEM)
    problems: list[Problem] = []
    section: _SystemSection | None = None
    try:
        section = document.validate(_SystemSection)
    except InputError as error:
        problems += error.problems
    components = list(_read_components(document, problems))
    problems += _connection_problems(document)
    if problems or section is None:
        raise InputError(dict.fromkeys(problems))
    return System(
        name=section.name,
        components=tuple(components),
        connections=tuple(" ".join(text.split()) for text in section.connections),
        simulation=section.simulation,
        description=section.description,
        inputs=section.inputs,
        outputs=section.outputs,
        scenario=section.scenario,
        folder=document.path.parent,
        processes=Processes(section.limits, section.environment.keep),
        document=document,
    )


class _ParameterSection(Section):
    name: str = ""
    values: dict[str, bool | int | float | str]


def read_parameters(path: str | Path) -> ParameterSet:
    """Start values ``component.variable`` from a file: YAML with `values`, or SSP's `.ssv`.

    They are an argument of `System.changed`. InputError with all problems of the file.
    """
    path = Path(path)
    if path.suffix.lower() == ".ssv":
        return ParameterSet(read_parameter_set(path), path, None)
    document = Document.load(path)
    return ParameterSet(document.validate(_ParameterSection).values, path, document)


def _connection_problems(document: Document) -> Iterator[Problem]:
    """Texts that are not connections, and unknown components; the rest needs the FMUs."""
    names = list(map(str, _components(document)))
    written: object = document.data.get("connections")
    texts: list[object] = written if isinstance(written, list) else []
    for index, text in enumerate(texts):
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


def _components(document: Document) -> dict[str, object]:
    """The mapping under `components`; empty if it is not a mapping."""
    written = document.data.get("components")
    return written if isinstance(written, dict) else {}


def _read_components(document: Document, problems: list[Problem]) -> Iterator[Component]:
    """The components that are right; adds to `problems`."""
    for key, keys in _components(document).items():
        if isinstance(keys, dict):
            try:
                yield read_component(document, key)
            except InputError as error:
                problems += error.problems


def read_component(document: Document, key: str) -> Component:
    """One component of a system's document; InputError with all its problems."""
    at, keys = ("components", key), document.data["components"][key]
    name = str(key)  # YAML takes `true` and `1` for other things than texts
    problems: list[Problem] = []
    if not _NAME.fullmatch(name):
        remedy = "use letters, digits and _, not starting with a digit"
        problems.append(document.problem(at, f"component name {name!r}", remedy))
    given = [key for key in ("model", "kind", "fmu") if key in keys]
    if len(given) != 1:
        what = f"has {' and '.join(given)}" if given else "has none of 'model', 'kind' and 'fmu'"
        remedy = "give one: 'model: x.model.yaml', 'kind: name' or 'fmu: x.fmu'"
        problems.append(document.problem(at, f"component {name!r} {what}", remedy))
        raise InputError(problems)
    own = tuple(key for key in keys if key not in COMMON) if given == ["kind"] else ()
    section, source = None, None
    try:
        section = document.validate(_FileSection, at=at, drop=own)
    except InputError as error:
        problems += error.problems
    try:
        source = _source(document, at, given[0])
    except InputError as error:
        problems += error.problems
    if section is None or source is None or problems:
        raise InputError(problems)
    try:
        return Component(
            name,
            source,
            section.start,
            step_size=section.step_size,
            dependencies=section.dependencies,
            process=section.process,
        )
    except InputError as error:
        raise InputError(
            document.problem(at, p.message, p.remedy) for p in error.problems
        ) from None


def _source(document: Document, at: Location, key: str) -> FmuFile | ModelFile | Kind | None:
    """The source of the component at `at`, under its `key`; InputError with all its problems.

    None for a file whose name is not text, which is a problem of the component's section.
    """
    written = document.data[at[0]][at[1]][key]
    if key == "kind":
        known = kinds()
        if not isinstance(written, str) or written not in known:
            text = str(written)
            message = f"unknown kind {text!r}: no installed package brings it (docs/adapters.md)"
            remedy = suggestion(text, known, "kinds")
            raise InputError([document.problem((*at, "kind"), message, remedy)])
        try:
            config = kind_of(written).config
        except ImportError as error:
            message = f"kind {written!r} is installed but cannot be used: {error}"
            remedy = "install what is missing; `m4e-fmi doctor` lists it"
            raise InputError([document.problem((*at, "kind"), message, remedy)]) from error
        return Kind(written, document.validate(config, at=at, drop=("kind", *COMMON)))
    if not isinstance(written, str):
        return None
    path = document.path.parent / written
    if not is_file(path):
        raise InputError([document.problem((*at, key), *missing_file(path))])
    return ModelFile(path) if key == "model" else FmuFile(path)
