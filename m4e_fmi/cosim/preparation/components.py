"""The FMU of every component: found, or built where what it is made from has changed."""

from __future__ import annotations

import hashlib
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.code_hash import code_hash, imports_hash
from m4e_fmi.cosim.preparation.inputs import (
    WARNING,
    Draft,
    checked_inputs,
    drafted,
    named_files,
    takes_long,
)
from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, ModelFile, kinds
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.file_names import file_stem, file_stems
from m4e_fmi.files.files_read import files_read
from m4e_fmi.files.writing import remove_leftovers
from m4e_fmi.fmu.export.build_record import BuildRecord, read_record, way_to, write_record

Tell = Callable[[str], None]

NATIVE = True
"""True if programs become native FMUs by default; Python code never does."""


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
    folder, fmus = _places(system, build_directory)
    remove_leftovers(folder)
    tell = _once(tell or _silent)
    if native is None:
        native = NATIVE and _library_is_there(tell)
    if drafts is None:
        drafts = _checked(system, fmus, native=native)
    files: dict[str, ReadyFmu] = {}
    problems: list[Problem] = []
    for component in system.components:
        name, source = component.name, component.source
        try:
            files[name] = (
                ReadyFmu(_found(source, folder))
                if isinstance(source, FmuFile)
                else _built(
                    system, component, fmus[name], drafts.get(name), native=native, tell=tell
                )
            )
        except InputError as error:
            problems += [system.located(name, problem) for problem in error.problems]
    if problems:
        raise InputError(dict.fromkeys(problems))
    return files


def _checked(system: System, fmus: Mapping[str, Path], *, native: bool) -> dict[str, Draft]:
    """Drafts of the FMUs that are to be built and quick to make.

    InputError with all problems of the system's inputs, if any FMU is to be built.
    """
    outdated = set(_outdated(system, fmus, native=native))
    if not outdated:
        return {}
    made = (c.name for c in system.components if not isinstance(c.source, FmuFile))
    return checked_inputs(system, ready={name: fmus[name] for name in made if name not in outdated})


def waiting(
    system: System, build_directory: str | Path = "build"
) -> tuple[tuple[str, ...], dict[str, Draft]]:
    """Components whose FMU is to be built, by a kind that takes long for it; drafts of the others.

    InputError with all problems of the system's inputs, if any FMU is to be built.
    """
    _, fmus = _places(system, build_directory)
    native = NATIVE and _library_is_there(_silent)
    drafts = _checked(system, fmus, native=native)
    long = {c.name for c in system.components if takes_long(c.source)}
    return tuple(n for n in _outdated(system, fmus, native=native) if n in long), drafts


def missing_fmus(system: System, build_directory: str | Path = "build") -> tuple[str, ...]:
    """Components whose FMU would be built: it is not there, or made from something else."""
    _, fmus = _places(system, build_directory)
    native = NATIVE and _library_is_there(_silent)
    return tuple(_outdated(system, fmus, native=native))


def _places(system: System, build_directory: str | Path) -> tuple[Path, dict[str, Path]]:
    """The folder of a system's FMUs, and the place of the FMU of each component."""
    folder = Path(build_directory) / file_stem(system.name)
    stems = file_stems(component.name for component in system.components)
    return folder, {name: folder / f"{stem}.fmu" for name, stem in stems.items()}


def _outdated(system: System, fmus: Mapping[str, Path], *, native: bool) -> Iterator[str]:
    """Components whose FMU is not what would be built now."""
    for component in system.components:
        name, source = component.name, component.source
        if not isinstance(source, FmuFile) and not _current(
            fmus[name], _made_from(system, name, source, fmus[name], native=native)
        ):
            yield name


def _current(fmu: Path, made_from: str) -> BuildRecord | None:
    """The record of an FMU that need not be built again."""
    record = read_record(fmu)
    return record if record is not None and record.is_current(made_from) else None


def _found(source: FmuFile, folder: Path) -> Path:
    """The FMU itself; if it is packed, its copy in `folder`."""
    if not source.member:
        return source.path
    from m4e_fmi.cosim.ssp import unpack_member

    return unpack_member(source.path, source.member, folder)


def _library_is_there(tell: Tell) -> bool:
    from m4e_fmi.fmu.export.native_fmu import shell_binaries
    from m4e_fmi.runtime.platforms import this_platform

    why = "there is none for this machine"
    try:
        if any(this_platform().fmi2 in name for name in shell_binaries("any")):
            return True
    except RunError as error:
        why = error.message
    tell(f"Python FMUs instead of native ones: {why}")
    return False


def _silent(_: str) -> None:
    pass


def _once(tell: Tell) -> Tell:
    """The same, but for warnings that another component has given, and that name no part of it.

    What they name stands in quotes.
    """
    given: set[str] = set()

    def tell_new(line: str) -> None:
        text = line.partition(": ")[2]
        if text.startswith(WARNING) and "'" not in text:
            if text in given:
                return
            given.add(text)
        tell(line)

    return tell_new


def _built(
    system: System,
    component: Component,
    fmu: Path,
    draft: Draft | None,
    *,
    native: bool,
    tell: Tell,
) -> ReadyFmu:
    """The FMU of a component, at the path `fmu`; of its `draft`, if that is made already."""
    name, source = component.name, component.source
    assert not isinstance(source, FmuFile)
    made_from = _made_from(system, name, source, fmu, native=native)
    record = _current(fmu, made_from)
    if record is not None:
        for warning in record.warnings:
            tell(f"{name}: {warning}")
        return ReadyFmu(fmu, record.fmu)
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
        options = Options(native=native and isinstance(draft.made, Program))
        content = write_archive(fmu_archive(draft.made, options), fmu)
    record = BuildRecord(
        fmu=content, made_from=made_from, files=files | draft.files, warnings=tuple(warnings)
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
        said |= {"imports": _imports(system, source)}
        package = module.partition(":")[0].partition(".")[0]
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):  # arrays with all their digits
        text = repr((said, code_hash(package)))
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()


def _imports(system: System, source: Kind) -> str:
    """Hash of what the Python files that a component names import, but for each other.

    Such a file is run when the FMU is made, whether it travels in it or not.
    """
    code = [path for path in named_files(system, source) if path.suffix == ".py"]
    return imports_hash(map(_content, code), {path.stem for path in code})


def _content(path: Path) -> bytes:
    """The content of a file; empty if it cannot be read, which its kind reports."""
    try:
        return path.read_bytes()
    except OSError:
        return b""
