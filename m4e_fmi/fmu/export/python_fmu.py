"""The files of an FMU with PythonFMU's binaries around a hardened slave.

Each FMU's Python files lie in one package, and its main script in one file, whose names end in a
hash of their content: two FMUs in one process never share a module by accident.
"""

from __future__ import annotations

import ast
import json
import math

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.files_read import read_bytes
from m4e_fmi.fmu.export.archive import content_guid, content_hash, model_identifier
from m4e_fmi.fmu.export.binaries import binaries, pythonfmu_folder
from m4e_fmi.fmu.export.description.description import ModelDescription, PythonSource
from m4e_fmi.fmu.export.description.model_description import XML, model_description_xml, with_guid
from m4e_fmi.fmu.export.from_program import EMBEDDED
from m4e_fmi.fmu.export.licenses import license_files
from m4e_fmi.fmu.export.options import Options

_MAIN_SCRIPT = """from {package}.{module} import {base}


class Slave({base}):
    def do_step(self, current_time, step_size):
        return super().do_step(current_time, step_size)
"""


def python_fmu_files(source: PythonSource, options: Options) -> dict[str, bytes]:
    """Every file of the FMU: name in the archive → content."""
    description = source.description
    identifier = model_identifier(description.name)
    _check_modules(source)
    contents = _package_files(source, description)
    package = f"m4e_{content_hash(contents)}"
    module, base = source.slave.split(":")
    script = _MAIN_SCRIPT.format(package=package, module=module, base=base)
    resources = {f"{package}/{name}": content for name, content in contents.items()}
    stem = f"{identifier}_{content_hash({'script': script.encode()})}"
    resources[f"{stem}.py"] = script.encode()
    resources["slavemodule.txt"] = stem.encode()
    resources |= _pythonfmu_files()
    files = {f"resources/{name}": content for name, content in resources.items()}
    files |= binaries(identifier) | license_files(pythonfmu=True, binaries=())
    files |= options.documentation
    xml = model_description_xml(description, model_identifier=identifier, guid="")
    files[XML] = with_guid(xml, content_guid(files, xml))
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


def _package_files(source: PythonSource, description: ModelDescription) -> dict[str, bytes]:
    modules = {"slave_base.py": EMBEDDED / "slave_base.py", **source.modules}
    listed: dict[str, list[dict[str, str | float | bool]]] = {"reals": [], "strings": []}
    for variable in description.variables:
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


def _pythonfmu_files() -> dict[str, bytes]:
    folder = pythonfmu_folder()
    return {f"pythonfmu/{file.name}": file.read_bytes() for file in folder.glob("*.py")}
