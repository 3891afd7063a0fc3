"""The FMU of every component: found, or built where what it is made from has changed."""

from __future__ import annotations

import hashlib
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.code_hash import code_hash
from m4e_fmi.cosim.system import Component, FmuFile, Kind, ModelFile, System, kind_module, kinds
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.file_names import file_stem, file_stems
from m4e_fmi.files_read import depends_on, files_read
from m4e_fmi.fmu.build_record import BuildRecord, read_record, write_record
from m4e_fmi.fmu.reading import Description
from m4e_fmi.writing import remove_leftovers

Tell = Callable[[str], None]

NATIVE = True
"""Whether programs become native FMUs where nobody says how; Python code never does."""

_WARNING = "warning"
"""How lines of progress begin that matter to everyone who uses what is built."""


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
) -> dict[str, ReadyFmu]:
    """As `fmu_files`."""
    folder = Path(build_directory) / file_stem(system.name)
    stems = file_stems(component.name for component in system.components)
    remove_leftovers(folder)
    tell = tell or _silent
    if native is None:
        native = NATIVE and _library_is_there(tell)
    files: dict[str, ReadyFmu] = {}
    problems = list(_checked(system, folder, stems, native=native))
    if problems:
        raise InputError(dict.fromkeys(problems))
    for component in system.components:
        name, source = component.name, component.source
        fmu = folder / f"{stems[name]}.fmu"
        try:
            files[name] = (
                ReadyFmu(_found(source, folder))
                if isinstance(source, FmuFile)
                else _built(system, name, source, fmu, native=native, tell=tell)
            )
        except InputError as error:
            problems += [system.located(name, problem) for problem in error.problems]
    if problems:
        raise InputError(dict.fromkeys(problems))
    return files


def _checked(
    system: System, folder: Path, stems: Mapping[str, str], *, native: bool
) -> Iterator[Problem]:
    """What kinds find wrong with the configurations of FMUs to be built, before any is built."""
    for component in system.components:
        name, source = component.name, component.source
        if not isinstance(source, Kind):
            continue
        check = getattr(kind_module(source.name), "check", None)
        made_from = _made_from(system, name, source, native=native)
        if check is None or _current(folder / f"{stems[name]}.fmu", made_from):
            continue
        try:
            check(source.config, folder=system.folder)
        except InputError as error:
            yield from (system.located(name, problem) for problem in error.problems)


def waiting(system: System, build_directory: str | Path = "build") -> tuple[str, ...]:
    """Components whose FMU is to be built, by a kind that takes long for it.

    InputError with all that their kinds find wrong with their configurations.
    """
    folder = Path(build_directory) / file_stem(system.name)
    stems = file_stems(component.name for component in system.components)
    native = NATIVE and _library_is_there(_silent)
    problems = list(_checked(system, folder, stems, native=native))
    if problems:
        raise InputError(dict.fromkeys(problems))
    return tuple(
        c.name
        for c in system.components
        if isinstance(c.source, Kind)
        and getattr(kind_module(c.source.name), "TAKES_LONG", False)
        and not _current(
            folder / f"{stems[c.name]}.fmu", _made_from(system, c.name, c.source, native=native)
        )
    )


def _current(fmu: Path, made_from: str) -> BuildRecord | None:
    """The record of an FMU that need not be built again."""
    record = read_record(fmu)
    return record if record is not None and record.is_current(made_from) else None


def with_units(component: Component, description: Description) -> Description:
    """What the component's FMU says, with the units that the system adds."""
    variables = dict(description.variables)
    for name, unit in component.units.items():
        if name in variables and variables[name].dimension is None:
            variables[name] = replace(variables[name], unit=unit.text, dimension=unit)
    return replace(description, variables=variables)


def _found(source: FmuFile, folder: Path) -> Path:
    """The FMU itself; if it is packed, its copy in `folder`."""
    if not source.member:
        return source.path
    from m4e_fmi.cosim.ssp import unpack_member

    return unpack_member(source.path, source.member, folder)


def _library_is_there(tell: Tell) -> bool:
    from m4e_fmi.fmu.native import shell_binaries
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


def _built(
    system: System, name: str, source: ModelFile | Kind, fmu: Path, *, native: bool, tell: Tell
) -> ReadyFmu:
    """The FMU of a component, at the path `fmu`."""
    made_from = _made_from(system, name, source, native=native)
    record = _current(fmu, made_from)
    if record is not None:
        for warning in record.warnings:
            tell(f"{name}: {warning}")
        return ReadyFmu(fmu, record.fmu)
    from m4e_fmi.fmu import Options
    from m4e_fmi.fmu.archive import write_archive
    from m4e_fmi.fmu.build import fmu_files as fmu_archive
    from m4e_fmi.program import Program

    tell(f"{name}: building {fmu}")
    warnings: list[str] = []

    def progress(text: str) -> None:
        tell(f"{name}: {text}")
        if text.startswith(_WARNING):
            warnings.append(text)

    with files_read() as files:
        _note_named(system, source)
        made = _made(system, name, source, progress)
        options = Options(native=native and isinstance(made, Program))
        content = write_archive(fmu_archive(made, options), fmu)
    record = BuildRecord(fmu=content, made_from=made_from, files=files, warnings=tuple(warnings))
    write_record(fmu, record)
    return ReadyFmu(fmu, content)


def _note_named(system: System, source: ModelFile | Kind) -> None:
    """Note the files that the configuration of a kind names, however the kind reads them."""
    if isinstance(source, ModelFile):
        return
    for text in _texts(source.config.model_dump(serialize_as_any=True)):
        try:
            path = system.folder / text
            if path.is_file():
                depends_on(path)
        except (OSError, ValueError):  # a text that no file can be called by
            continue


def _texts(value: Any) -> Iterator[str | Path]:
    """All texts and paths in plain data."""
    if isinstance(value, str | Path):
        yield value
    elif isinstance(value, Mapping):
        for member in value.values():
            yield from _texts(member)
    elif isinstance(value, list | tuple | set | frozenset):
        for member in value:
            yield from _texts(member)


def _made(system: System, name: str, source: ModelFile | Kind, progress: Tell) -> Any:
    """The Program or PythonSource of a component."""
    if isinstance(source, ModelFile):
        from m4e_fmi.model import load_model
        from m4e_fmi.multibody import model_program

        model = load_model(source.path)
        for warning in model.warnings:
            progress(f"{_WARNING}: {warning}")
        return model_program(model)
    module = kind_module(source.name)
    return module.make(source.config, name=name, folder=system.folder, progress=progress)


def _made_from(system: System, name: str, source: ModelFile | Kind, *, native: bool) -> str:
    """Hash of what the FMU of a component is made from, but for the content of files."""
    said: dict[str, Any] = {"name": name, "native": native, "machine": sysconfig.get_platform()}
    package = ""
    if isinstance(source, ModelFile):
        said["model"] = str(source.path.absolute())
    else:
        module = kinds()[source.name].value
        said |= {"kind": module, "folder": str(system.folder.absolute())}
        said |= {"config": source.config.model_dump(serialize_as_any=True)}
        package = module.partition(":")[0].partition(".")[0]
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):  # arrays with all their digits
        text = repr((said, code_hash(package)))
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()
