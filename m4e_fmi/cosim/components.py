"""The FMU of every component: found, or built where what it is made from has changed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from m4e_fmi.cosim.system import Component, FmuFile, Kind, ModelFile, System, kind_module, kinds
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.file_names import file_stem, file_stems
from m4e_fmi.fmu.reading import Description
from m4e_fmi.writing import cannot_write, written

Tell = Callable[[str], None]

NATIVE = True
"""Whether programs become native FMUs where nobody says how; Python code never does."""

_MODEL_CODE = ("model", "multibody", "program", "fmu", "runtime")
_KIND_CODE = ("m4e_adapters", "m4e_fmus")
_SOURCES = {".py", ".c", ".h"}


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

    Beside each built ``name.fmu`` a file ``name.stamp`` holds the hash of what it was made from
    (the model file or configuration, the files it names, and the code that builds); while it
    agrees, the FMU is used as it is. `tell` is called with one line per step of a build.
    """
    folder = Path(build_directory) / file_stem(system.name)
    stems = file_stems(component.name for component in system.components)
    tell = tell or _silent
    if native is None:
        native = NATIVE and _library_is_there(tell)
    files: dict[str, Path] = {}
    problems: list[Problem] = []
    for component in system.components:
        source = component.source
        try:
            files[component.name] = (
                _found(source, folder)
                if isinstance(source, FmuFile)
                else _built(system, component, source, folder / stems[component.name], native, tell)
            )
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(dict.fromkeys(problems))
    return files


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
    system: System,
    component: Component,
    source: ModelFile | Kind,
    path: Path,
    native: bool,
    tell: Tell,
) -> Path:
    """The FMU of a component at `path`, which has no suffix yet."""
    fmu, stamp = (path.with_name(f"{path.name}.{suffix}") for suffix in ("fmu", "stamp"))
    wanted = _stamp(system, component.name, source, native=native)
    if fmu.is_file() and stamp.is_file() and stamp.read_text(encoding="ascii") == wanted:
        return fmu
    from m4e_fmi.fmu import build_fmu
    from m4e_fmi.program import Program

    tell(f"{component.name}: building {fmu}")
    made = _made(system, component.name, source, tell)
    try:
        stamp.unlink(missing_ok=True)  # of the FMU that goes now
    except OSError as error:
        raise cannot_write(fmu, error) from error
    build_fmu(made, fmu, native=native and isinstance(made, Program))
    with written(stamp) as part:
        part.write_text(wanted, encoding="ascii")
    return fmu


def _made(system: System, name: str, source: ModelFile | Kind, tell: Tell) -> Any:
    """The Program or PythonSource of a component."""
    if isinstance(source, ModelFile):
        from m4e_fmi.multibody import model_program

        return model_program(source.path)
    module = kind_module(source.name)
    return module.make(
        source.config,
        name=name,
        folder=system.folder,
        progress=lambda text: tell(f"{name}: {text}"),
    )


def _stamp(system: System, name: str, source: ModelFile | Kind, *, native: bool) -> str:
    code = [_package_hash(f"m4e_fmi.{part}") for part in _MODEL_CODE]
    digest = hashlib.sha256("\n".join([name, str(native), *code]).encode())
    if isinstance(source, ModelFile):
        digest.update(source.path.read_bytes())
        return digest.hexdigest()
    own = kinds()[source.name].value.partition(".")[0]  # all of it: a kind may use any of its files
    for package in dict.fromkeys((own, *_KIND_CODE)):
        digest.update(_package_hash(package).encode())
    digest.update(source.config.model_dump_json().encode())
    for text in _texts(source.config.model_dump()):
        path = system.folder / text
        if len(text) < 1024 and path.is_file():
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _texts(value: Any) -> Iterator[str]:
    """All texts in a configuration; those that are file names count with the file's content."""
    if isinstance(value, str | Path):
        yield str(value)
    elif isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _texts(item)


@cache
def _package_hash(name: str) -> str:
    """Hash of all Python and C sources of a package, or of a module."""
    spec = find_spec(name)
    digest = hashlib.sha256(name.encode())
    if spec is None:
        return digest.hexdigest()
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    files = [f for folder in folders for f in folder.rglob("*") if f.suffix in _SOURCES]
    for file in sorted(files or [Path(spec.origin or "")]):
        if file.is_file():
            digest.update(file.read_bytes())
    return digest.hexdigest()
