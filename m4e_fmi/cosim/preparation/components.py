"""The FMU of every component: found, or built if its sources have changed.

Inputs are checked before anything is built. Existing FMUs are read. Programs that are quick to make
are made in memory: a `Draft`, which is then written as an FMU. The `outline` of a kind that takes
long finds its problems, and returns a program with the variables that its FMU will have. When all
of these are right, connections, start values and the scenario are checked against them.
"""

from __future__ import annotations

import hashlib
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from m4e_fmi.code_hash import code_hash, imports_hash
from m4e_fmi.cosim.scenario.plan import scenario_problems
from m4e_fmi.cosim.ssp.package import unpack_member
from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, ModelFile, kind_of, kinds
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.file_names import file_stem, file_stems
from m4e_fmi.files.files_read import Files, depends_on, files_read
from m4e_fmi.files.writing import remove_leftovers
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.export.build_record import BuildRecord, read_record, way_to, write_record
from m4e_fmi.fmu.export.description import expected_description
from m4e_fmi.fmu.importer.reading import resized

if TYPE_CHECKING:
    from m4e_fmi.fmu import PythonSource
    from m4e_fmi.program import Program


Tell = Callable[[str], object]
WARNING = "warning"
"""How lines of progress begin that matter to everyone who uses what is built."""
NATIVE = True
"""True if programs become native FMUs by default; Python code never does."""


def silent(_: str) -> None:
    """Takes a line of progress that nobody asked for."""


@dataclass(frozen=True)
class Draft:
    """The source of an FMU, and the `files` that were read for it.

    `lines` are messages of progress that were not shown yet.
    """

    made: Program | PythonSource
    files: Files
    lines: tuple[str, ...] = ()


def takes_long(source: FmuFile | ModelFile | Kind) -> bool:
    """True for kinds that may take minutes to make."""
    return isinstance(source, Kind) and kind_of(source.name).takes_long


def drafted(system: System, component: Component, tell: Tell | None = None) -> Draft:
    """The draft of a component that is no FMU; `tell` gets lines of progress, else they are kept.

    InputError and RunError as from reading the model, or from `build` of the kind.
    """
    source, lines = component.source, list[str]()
    tell = tell or lines.append
    assert not isinstance(source, FmuFile)
    with files_read() as files:
        if isinstance(source, Kind):
            for path in named_files(system, source):  # however the kind reads them
                depends_on(path)
            build = kind_of(source.name).build
            made = build(source.config, name=component.name, folder=system.folder, progress=tell)
        else:
            from m4e_fmi.model import load_model
            from m4e_fmi.multibody import model_program

            model = load_model(source.path)
            for warning in model.warnings:
                tell(f"{WARNING}: {warning}")
            made = model_program(model)
    return Draft(made, files, tuple(lines))


def named_files(system: System, source: Kind) -> Iterator[Path]:
    """The files that are there and that the configuration of a kind names."""
    for text in _texts(source.config.model_dump(serialize_as_any=True)):
        try:
            path = system.folder / text
            if path.is_file():
                yield path
        except (OSError, ValueError):  # a text that no file can be called by
            continue


def _texts(value: Any) -> Iterator[str | Path]:
    """All texts and paths in plain data."""
    if isinstance(value, str | Path):
        yield value
    elif isinstance(value, Mapping):
        for member in value.values():
            yield from _texts(member)
    elif isinstance(value, (list, tuple, set, frozenset)):
        for member in value:
            yield from _texts(member)


def checked_inputs(system: System, *, ready: Mapping[str, Path] | None = None) -> dict[str, Draft]:
    """Drafts of those components that are quick to make.

    `ready` are the FMUs of components that need not be built. InputError with all problems of the
    components; if there are none, with those of connections, start values and the scenario.
    """
    check_components(system)
    problems: list[Problem] = []
    drafts: dict[str, Draft] = {}
    descriptions: dict[str, Description] = {}
    known: list[Component] = []
    for component in system.components:
        try:
            found = _looked_at(system, component, (ready or {}).get(component.name), drafts)
        except InputError as error:
            is_file = isinstance(component.source, FmuFile)
            problems += (
                p if is_file else system.located(component.name, p) for p in error.problems
            )
        except RunError:
            continue  # the build tells it
        else:
            if found is not None:
                descriptions[component.name] = component.described(found)
                known.append(_without_memory(component, found))
    InputError.raise_for(dict.fromkeys(problems))
    if len(known) == len(system.components):
        system = replace(system, components=tuple(known))
        wiring = connect(system, descriptions)
        InputError.raise_for(scenario_problems(system, descriptions, wiring))
    return drafts


def expected_descriptions(system: System) -> dict[str, Description]:
    """Descriptions of the FMUs that the components of a correct system are or will be.

    Those of kinds that take long lack the results of the computation.
    """
    found = {c.name: _looked_at(system, c, None, {}) for c in system.components}
    components = {c.name: c for c in system.components}
    return {name: components[name].described(one) for name, one in found.items() if one}


def check_components(system: System) -> None:
    """InputError for a system that has none."""
    if not system.components:
        message, remedy = "the system has no component", "name an FMU, a model or a kind"
        raise InputError([system.problem(("components",), message, remedy)])


def _looked_at(
    system: System, component: Component, ready: Path | None, drafts: dict[str, Draft]
) -> Description | None:
    """The description of a component's FMU, made or not; None if that is not known yet."""
    name, source = component.name, component.source
    if ready is not None:
        return resized(read_description(ready), component.start)
    if isinstance(source, FmuFile):
        return None if source.member else resized(read_description(source.path), component.start)
    made: Any = None
    if not takes_long(source):
        drafts[name] = drafted(system, component)
        made = drafts[name].made
    elif isinstance(source, Kind):
        made = kind_of(source.name).outline(source.config, folder=system.folder)
    return None if made is None else expected_description(made, Path(f"{name}.fmu"))


def _without_memory(component: Component, description: Description) -> Component:
    """The component without start values that only the finished FMU of its kind can judge.

    These are elements of arrays, as the states of a fitted memory, whose number is found by the
    computation that takes long.
    """
    if not takes_long(component.source):
        return component
    known = description.variables
    start = {n: value for n, value in component.start.items() if n in known or "[" not in n}
    return replace(component, start=start)


def fmu_files(
    system: System,
    build_directory: str | Path = "build",
    *,
    native: bool | None = None,
    tell: Tell | None = None,
) -> dict[str, Path]:
    """The FMU file of every component by name, built in `build_directory`/system where needed.

    With `native`, models and all other programs become native FMUs, else Python ones; None leaves
    it to `NATIVE` and to whether this machine has a library for them. Python code, as that of the
    mooring, is a Python FMU either way.

    Beside each built ``name.fmu``, ``name.build.json`` records what it was made from: the files
    that were read for it, by their content, its configuration, and the code that builds it. While
    that agrees, the FMU is used as it is. `tell` is called with one line per step of a build, and
    with the warnings of earlier ones. Processes may build the same at one time: each FMU appears
    whole or not at all. InputError with all problems; RunError if a file cannot be written.
    """
    ready = ready_fmus(system, build_directory, native=native, tell=tell)
    return {name: fmu.path for name, fmu in ready.items()}


@dataclass(frozen=True)
class ReadyFmu:
    """The FMU of a component; `content` is the SHA-256 of one that was built, "" of others."""

    path: Path
    content: str = ""


def ready_fmus(
    system: System,
    build_directory: str | Path = "build",
    *,
    native: bool | None = None,
    tell: Tell | None = None,
    drafts: Mapping[str, Draft] | None = None,
) -> dict[str, ReadyFmu]:
    """As `fmu_files`. `drafts` are those that `waiting` has made when it checked the inputs."""
    tell = tell or silent
    folder, places = _places(system, build_directory, native, tell)
    remove_leftovers(folder)
    if drafts is None:
        drafts = _checked(system, places)
    files: dict[str, ReadyFmu] = {}
    problems: list[Problem] = []
    for component in system.components:
        name, source = component.name, component.source
        try:
            if not isinstance(source, FmuFile):
                files[name] = _built(system, component, places[name], drafts.get(name), tell)
            elif source.member:
                files[name] = ReadyFmu(unpack_member(source.path, source.member, folder))
            else:
                files[name] = ReadyFmu(source.path)
        except InputError as error:
            problems += [system.located(name, problem) for problem in error.problems]
    InputError.raise_for(dict.fromkeys(problems))
    return files


def waiting(
    system: System, build_directory: str | Path = "build"
) -> tuple[tuple[str, ...], dict[str, Draft]]:
    """Components whose FMU is to be built, by a kind that takes long for it; drafts of the others.

    InputError with all problems of the system's inputs, if any FMU is to be built.
    """
    _, places = _places(system, build_directory)
    drafts = _checked(system, places)
    long = {c.name for c in system.components if takes_long(c.source)}
    return tuple(n for n, place in places.items() if n in long and not place.record), drafts


@dataclass(frozen=True)
class _Place:
    """Where the FMU of a component is built (`native` or not), and a hash of what it is made from.

    `record` is that of the FMU which is there, None if it is to be built.
    """

    fmu: Path
    native: bool
    made_from: str
    record: BuildRecord | None


def _places(
    system: System,
    build_directory: str | Path,
    native: bool | None = None,
    tell: Tell = silent,
) -> tuple[Path, dict[str, _Place]]:
    """The folder of a system's FMUs, and the places of those that are built."""
    if native is None:
        native = NATIVE and _library_is_there(tell)
    folder = Path(build_directory) / file_stem(system.name)
    stems = file_stems(component.name for component in system.components)
    places: dict[str, _Place] = {}
    for component in system.components:
        name, source = component.name, component.source
        if not isinstance(source, FmuFile):
            fmu = folder / f"{stems[name]}.fmu"
            made_from = _made_from(system, name, source, fmu, native=native)
            record = read_record(fmu)
            is_current = record is not None and record.is_current(made_from)
            places[name] = _Place(fmu, native, made_from, record if is_current else None)
    return folder, places


def _checked(system: System, places: Mapping[str, _Place]) -> dict[str, Draft]:
    """Drafts of the FMUs that are to be built and quick to make.

    InputError with all problems of the system's inputs, if any FMU is to be built.
    """
    ready = {name: place.fmu for name, place in places.items() if place.record}
    return checked_inputs(system, ready=ready) if len(ready) < len(places) else {}


def _library_is_there(tell: Tell) -> bool:
    from m4e_fmi.fmu.export.native_fmu import shell_binaries
    from m4e_fmi.runtime.platforms import this_platform

    why = "there is none for this machine"
    try:
        if any(this_platform().fmi2 in name for name in shell_binaries("any")):
            return True
    except RunError as error:
        why = error.message
    tell(f"note: Python FMUs instead of native ones: {why}")
    return False


def _built(
    system: System, component: Component, place: _Place, draft: Draft | None, tell: Tell
) -> ReadyFmu:
    """The FMU of a component, at its `place`; of its `draft`, if that is made already."""
    name, fmu = component.name, place.fmu
    if place.record:
        for warning in place.record.warnings:
            tell(f"{name}: {warning}")
        return ReadyFmu(fmu, place.record.fmu)
    from m4e_fmi.fmu import Options
    from m4e_fmi.fmu.export.archive import write_archive
    from m4e_fmi.fmu.export.build import fmu_files as fmu_archive
    from m4e_fmi.program import Program

    tell(f"{name}: building {fmu}")
    warnings: list[str] = []

    def progress(text: str) -> None:
        tell(f"{name}: {text}")
        if text.startswith(WARNING):
            warnings.append(text)

    draft = draft or drafted(system, component, progress)
    for line in draft.lines:
        progress(line)
    with files_read() as files:
        options = Options(native=place.native and isinstance(draft.made, Program))
        content = write_archive(fmu_archive(draft.made, options), fmu)
    record = BuildRecord(
        fmu=content, made_from=place.made_from, files=files | draft.files, warnings=tuple(warnings)
    )
    write_record(fmu, record)
    return ReadyFmu(fmu, content)


def _made_from(
    system: System, name: str, source: ModelFile | Kind, fmu: Path, *, native: bool
) -> str:
    """Hash of what the FMU of a component is made from, but for the content of files."""
    said: dict[str, Any] = {"name": name, "native": native, "machine": sysconfig.get_platform()}
    package = ""
    if isinstance(source, ModelFile):
        said["model"] = way_to(source.path, fmu)
    else:
        module = kinds()[source.name].value
        said |= {"kind": module, "folder": way_to(system.folder, fmu)}
        said |= {"config": source.config.model_dump(serialize_as_any=True)}
        # of Python files that it names: they are run when the FMU is made
        code = [path for path in named_files(system, source) if path.suffix == ".py"]
        said |= {"imports": imports_hash(map(_content, code), {path.stem for path in code})}
        package = module.partition(":")[0].partition(".")[0]
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):  # arrays with all their digits
        text = repr((said, code_hash(package)))
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()


def _content(path: Path) -> bytes:
    """The content of a file; empty if it cannot be read, which its kind reports."""
    try:
        return path.read_bytes()
    except OSError:
        return b""
