"""Building FMUs: native ones, and those with PythonFMU's binaries around a hardened slave.

A native FMU is the runtime's shared library beside the program in its binary form: see `native`.
Each Python FMU's files lie in one package, and its main script in one file, whose names end in a
hash of their content: two FMUs in one process never share a module by accident. The archive is
written here, not by PythonFMU's builder, so no user code runs at build time and the same source
gives the same bytes.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.binaries import binaries, pythonfmu_folder
from m4e_fmi.fmu.description import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.fmu.from_program import EMBEDDED, describe, python_slave, with_rates
from m4e_fmi.fmu.model_description import model_description_xml
from m4e_fmi.fmu.native import native_resources, shell_binaries, shell_sources
from m4e_fmi.program import Program
from m4e_fmi.runtime.declarations import METHODS

GUID_NAMESPACE = uuid.UUID("5c1f3a52-6a0e-5c1c-9a0b-6d34655f666d")
EARLIEST_ZIP_DATE = (1980, 1, 1, 0, 0, 0)
HASH_LENGTH = 12
LAST_ERROR = "last_error"
XML = "modelDescription.xml"
SETTINGS = "resources/fmu.txt"

_MAIN_SCRIPT = """from {package}.{module} import {base}


class Slave({base}):
    def do_step(self, current_time, step_size):
        return super().do_step(current_time, step_size)
"""


def build_fmu(
    source: Program | PythonSource,
    path: str | Path,
    *,
    native: bool = False,
    method: str = "dop853",
    sources: bool = False,
) -> Path:
    """Write the FMU of `source` to `path` (replaced as a whole) and return the path.

    A `native` FMU needs no Python where it runs, and serves co-simulation and model exchange;
    `method` integrates its co-simulation (dop853, rk45, rodas); `sources` adds the C sources of its
    library, for importers that compile. Variables and value references of
    a program are the same either way. The same source gives the same bytes. InputError if the
    name cannot be a model identifier, or a Python module has a syntax error, or something else
    than a program should be native; RunError if there is no library for native FMUs; ValueError if
    the description contradicts itself.
    """
    if sources and not native:
        raise InputError.single("an FMU with C sources is a native one", "build it with native")
    if isinstance(source, Program):
        source = with_rates(source)
        files = (
            native_fmu_files(source, method, sources=sources)
            if native
            else fmu_files(python_slave(source, describe(source)))
        )
    elif native:
        message = f"{source.description.name} is Python code: it cannot be a native FMU"
        raise InputError.single(message, "build it without native")
    else:
        files = fmu_files(source)
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_archive(files, path)
    return path


def fmu_files(source: PythonSource) -> dict[str, bytes]:
    """Every file of the FMU: name in the archive → content."""
    description = _with_last_error(source.description)
    identifier = model_identifier(description.name)
    _check_modules(source)
    contents = _package_files(source, description)
    package = f"m4e_{_digest(contents)}"
    module, base = source.slave.split(":")
    script = _MAIN_SCRIPT.format(package=package, module=module, base=base)
    resources = {f"{package}/{name}": content for name, content in contents.items()}
    stem = f"{identifier}_{_digest({'script': script.encode()})}"
    resources[f"{stem}.py"] = script.encode()
    resources["slavemodule.txt"] = stem.encode()
    resources |= _pythonfmu_files()
    files = {f"resources/{name}": content for name, content in resources.items()}
    files |= binaries(identifier)
    xml = model_description_xml(description, model_identifier=identifier, guid="")
    files[XML] = _with_guid(xml, _guid(files, xml))
    return files


def native_fmu_files(program: Program, method: str, *, sources: bool = False) -> dict[str, bytes]:
    """Every file of the native FMU of `program`: name in the archive → content."""
    if method not in METHODS:
        raise InputError.single(f"there is no method {method!r}", suggestion(method, METHODS))
    description = _with_last_error(describe(program))
    identifier = model_identifier(description.name)
    files = {
        f"resources/{name}": content for name, content in native_resources(program, method).items()
    }
    files |= shell_binaries(identifier)
    files[SETTINGS] = b"%d" % METHODS[method]
    code = shell_sources() if sources else {}
    files |= code
    xml = model_description_xml(
        description,
        model_identifier=identifier,
        guid="",
        native=True,
        sources=[Path(name).name for name in code if name.endswith(".c")],
    )
    guid = _guid(files, xml)
    files[SETTINGS] = b"%s %d\n" % (guid.encode(), METHODS[method])
    files[XML] = _with_guid(xml, guid)
    return files


def _guid(files: Mapping[str, bytes], xml: bytes) -> str:
    """A GUID made of the content of the FMU."""
    digest = _digest({**files, "xml": xml}, length=64)
    return f"{{{uuid.uuid5(GUID_NAMESPACE, digest)}}}"


def _with_guid(xml: bytes, guid: str) -> bytes:
    return xml.replace(b'guid=""', f'guid="{guid}"'.encode(), 1)  # the root's: it comes first


def model_identifier(name: str) -> str:
    """`name` as a C identifier; InputError if nothing of it is left."""
    identifier = re.sub(r"\W", "_", name, flags=re.ASCII)
    if not re.match(r"[A-Za-z]", identifier):
        message = f"{name!r} cannot name an FMU"
        raise InputError.single(message, "use letters, digits and _, a letter first")
    return identifier


def write_archive(files: Mapping[str, bytes], path: Path) -> None:
    """Write a ZIP whose bytes depend on `files` only; `path` appears complete or not at all."""
    temporary = path.with_name(f"{path.name}.{uuid.uuid4().hex}.part")
    try:
        with zipfile.ZipFile(temporary, "x") as archive:
            for name in sorted(files):
                info = zipfile.ZipInfo(name, EARLIEST_ZIP_DATE)
                info.compress_type = zipfile.ZIP_DEFLATED
                info.create_system = 3  # Unix, wherever it is written
                info.external_attr = 0o644 << 16
                archive.writestr(info, files[name], compresslevel=6)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


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


def _with_last_error(description: ModelDescription) -> ModelDescription:
    if any(v.name == LAST_ERROR for v in description.variables):
        message = f"{description.name}: every FMU has a variable {LAST_ERROR!r} of its own"
        raise InputError.single(message, "give yours another name")
    last_error = FmuVariable(
        name=LAST_ERROR,
        unit="",
        description="Text of the error that stopped this component; empty while all is well",
        variability="discrete",
        initial="calculated",
        type="String",
    )
    return replace(description, variables=(*description.variables, last_error))


def _package_files(source: PythonSource, description: ModelDescription) -> dict[str, bytes]:
    modules = {"slave_base.py": EMBEDDED / "slave_base.py", **source.modules}
    listed: dict[str, list] = {"reals": [], "strings": []}
    for variable in description.variables:
        group, default = ("reals", 0.0) if variable.type == "Real" else ("strings", "")
        start = default if variable.start is None else variable.start
        listed[group].append({"name": variable.name, "start": start})
    return {
        "__init__.py": b"",
        **{name: path.read_bytes() for name, path in modules.items()},
        **source.data,
        "description.json": json.dumps(listed).encode(),
    }


def _pythonfmu_files() -> dict[str, bytes]:
    folder = pythonfmu_folder()
    return {f"pythonfmu/{file.name}": file.read_bytes() for file in folder.glob("*.py")}


def _digest(files: Mapping[str, bytes], *, length: int = HASH_LENGTH) -> str:
    digest = hashlib.sha256()
    for name in sorted(files):
        for part in (name.encode(), files[name]):
            digest.update(len(part).to_bytes(8, "big"))
            digest.update(part)
    return digest.hexdigest()[:length]
