"""The files of an FMU with PythonFMU's binaries around a hardened slave.

Each FMU's Python files lie in one package, and its main script in one file, whose names end in a
hash of their content: two FMUs in one process never share a module by accident.

One defect of the binaries is mended. The Linux binary of 0.7.0 releases its static Python state
twice when it is unloaded: once by the destructor of the static, once more in an unload handler that
runs after it. The second release decrements a word of memory that is free by then, perhaps somebody
else's; processes end with "corrupted double-linked list". The handler's jump becomes a return: the
destructor suffices.
"""

from __future__ import annotations

import ast
import hashlib
import json
import math
import sys
from importlib.metadata import PackageNotFoundError, distribution
from itertools import count
from pathlib import Path

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.files_read import read_bytes
from m4e_fmi.fmu.export.archive import content_hash, model_identifier
from m4e_fmi.fmu.export.description import ModelDescription, PythonSource
from m4e_fmi.fmu.export.native_fmu import PROGRAM, model_file
from m4e_fmi.fmu.export.selection import GROUPS
from m4e_fmi.program import Program
from m4e_fmi.runtime import declarations
from m4e_fmi.runtime.library import library_path
from m4e_fmi.runtime.platforms import PLATFORMS, packaged

EMBEDDED = Path(__file__).parent / "embedded"
BINARIES = {"linux64": "libpythonfmu-export.so", "win64": "pythonfmu-export.dll"}
"""FMI's name of a platform → PythonFMU's binary for it."""
LIBRARIES = {"linux64": ("linux", "x86_64-linux"), "win64": ("win32", "x86_64-windows")}
"""FMI's name of a platform → `sys.platform`, and the platform of the runtime library for it."""
_DEFECTIVE = "4be156a552c16f30eb4395805c59855d8d4086056d0f165442565f6c5fbac0c9"
"""SHA-256 of the Linux binary of 0.7.0."""
_JUMP, _RETURN = 0x16F34, b"\xc3"
"""Place of `jmp finalizePythonInterpreter` of its unload handler, which becomes `ret`."""

_MAIN_SCRIPT = """from {package}.{module} import {base}


class Slave({base}):
    def do_step(self, current_time, step_size):
        return super().do_step(current_time, step_size)
"""


def python_slave(program: Program, description: ModelDescription, method: str) -> PythonSource:
    """The Python slave that runs `program`; the variables of `description` follow it in order."""
    references = count()
    layout = {group: [next(references) for _ in getattr(program, group)] for group in GROUPS}
    settings = {
        "method": method,
        "tolerance": description.tolerance,
        "step_size": description.step_size,
    }
    data = {
        "layout.json": json.dumps({**layout, **settings}).encode(),
        PROGRAM: model_file(program, method),
    }
    return PythonSource(
        description=description,
        slave="program_slave:ProgramSlave",
        modules={
            "program_slave.py": EMBEDDED / "program_slave.py",
            "declarations.py": Path(declarations.__file__),
        },
        data=data | runtime_files(),
    )


def runtime_files() -> dict[str, bytes]:
    """The runtime's library for every platform that there is one for, as slaves load it."""
    found = {}
    for system, name in LIBRARIES.values():
        own = system == sys.platform
        path = library_path() if own else packaged("runtime", PLATFORMS[name])
        if path is not None:
            found[f"runtime.{system}"] = path.read_bytes()
    return found


def python_members(source: PythonSource) -> dict[str, bytes]:
    """Members of the FMU of a slave beside its description: name in the archive → content."""
    identifier = model_identifier(source.description.name)
    _check_modules(source)
    contents = _package_files(source)
    package = f"m4e_{content_hash(contents)}"
    module, base = source.slave.split(":")
    script = _MAIN_SCRIPT.format(package=package, module=module, base=base).encode()
    stem = f"{identifier}_{content_hash({'script': script})}"
    files = {f"resources/{package}/{name}": content for name, content in contents.items()}
    files |= {f"resources/{stem}.py": script, "resources/slavemodule.txt": stem.encode()}
    for file in _pythonfmu_folder().glob("*.py"):
        files[f"resources/pythonfmu/{file.name}"] = file.read_bytes()
    for platform in BINARIES:
        system, _ = LIBRARIES[platform]
        needed = any(name.startswith("runtime.") for name in source.data)
        if needed and f"runtime.{system}" not in source.data:
            continue  # nothing could run it there
        path = binary_path(platform)
        files[f"binaries/{platform}/{identifier}{path.suffix}"] = _mended(path.read_bytes())
    return files


def _check_modules(source: PythonSource) -> None:
    """Find now what an importer would only report as "failed to instantiate"."""
    module, _, name = source.slave.partition(":")
    if f"{module}.py" not in source.modules or not name:
        known = ", ".join(source.modules)
        raise ValueError(f"slave {source.slave!r} is not 'module:Class' of one of: {known}")
    for path in source.modules.values():
        try:
            ast.parse(path.read_bytes())
        except SyntaxError as error:
            message, place = (
                f"not valid Python: {error.msg}",
                (error.lineno or 0, error.offset or 0),
            )
            problem = Problem(message, "", str(path), *place, (error.text or "").rstrip("\n"))
            raise InputError([problem]) from None


def _package_files(source: PythonSource) -> dict[str, bytes]:
    """The files that are specific to a slave, as one package; its variables as the base reads
    them."""
    modules = {"slave_base.py": EMBEDDED / "slave_base.py", **source.modules}
    listed: dict[str, list[dict[str, str | float | bool]]] = {"reals": [], "strings": []}
    for variable in source.description.variables:
        group, default = ("reals", 0.0) if variable.type == "Real" else ("strings", "")
        start = default if variable.start is None else variable.start
        always = variable.causality == "input" or variable.variability == "tunable"
        settable = always and variable.causality != "calculatedParameter"
        entry = {"name": variable.name, "start": start, "settable": settable}
        for key in ("minimum", "maximum"):
            if math.isfinite(limit := getattr(variable, key)):
                entry[key] = limit
        listed[group].append(entry)
    return {
        "__init__.py": b"",
        **{name: read_bytes(path) for name, path in modules.items()},
        **source.data,
        "description.json": json.dumps(listed).encode(),
    }


def binary_path(platform: str) -> Path:
    """PythonFMU's binary for an FMI platform name such as "linux64"; InputError if there is no
    PythonFMU."""
    return _pythonfmu_folder() / "resources" / "binaries" / platform / BINARIES[platform]


def _pythonfmu_folder() -> Path:
    # not the importable module: once an FMU has run in this process, that is the FMU's own copy
    try:
        return Path(str(distribution("pythonfmu").locate_file("pythonfmu")))
    except PackageNotFoundError:
        remedy = "pip install pythonfmu==0.7.0"
        raise InputError.single("pythonfmu is not installed", remedy) from None


def _mended(content: bytes) -> bytes:
    if hashlib.sha256(content).hexdigest() != _DEFECTIVE:
        return content
    return content[:_JUMP] + _RETURN + content[_JUMP + 1 :]
