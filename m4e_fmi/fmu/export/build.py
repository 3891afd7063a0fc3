"""Building FMUs: native ones, and those with PythonFMU's binaries around a hardened slave.

What a program says of itself is the same either way; `native_fmu` and `python_fmu` know the files.
The archive is written here, not by PythonFMU's builder, so no user code runs at build time and the
same source gives the same bytes.
"""

from __future__ import annotations

import re
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.fmu.export.archive import (
    content_hash,
    license_files,
    model_identifier,
    write_archive,
)
from m4e_fmi.fmu.export.build_record import BuildRecord, write_record
from m4e_fmi.fmu.export.description import (
    ModelDescription,
    Options,
    PythonSource,
    asked,
    described,
    shown,
)
from m4e_fmi.fmu.export.model_description import (
    BUILD,
    NATIVE_2,
    NATIVE_3,
    PYTHON,
    XML,
    build_description_xml,
    model_description_xml,
)
from m4e_fmi.fmu.export.native_fmu import SETTINGS, native_members
from m4e_fmi.fmu.export.python_fmu import python_members, python_slave
from m4e_fmi.program import Program

GUID_NAMESPACE = uuid.UUID("5c1f3a52-6a0e-5c1c-9a0b-6d34655f666d")
OF_PROGRAMS = ("native", "fmi", "method", "outputs")
"""Options that say something of a program, and nothing of Python code."""


def build_fmu(
    source: Program | PythonSource,
    path: str | Path,
    *,
    native: bool = False,
    fmi: str | int = "2",
    method: str = "dop853",
    tolerance: float | None = None,
    stop_time: float | None = None,
    step_size: float | None = None,
    outputs: Sequence[str] | None = None,
    documentation: Mapping[str, bytes] | None = None,
    sources: bool = False,
) -> Path:
    """Write the FMU of `source` to `path` (replaced as a whole) and return the path.

    Beside it, ``name.build.json`` records that this FMU was built here: see `build_record`.

    A `native` FMU needs no Python where it runs, and serves co-simulation and model exchange; `fmi`
    is the version of the standard, "2" or, for native ones, "3".
    `method` integrates a program in co-simulation: dop853, rk45 or rodas (stiff), to `tolerance`
    (default 1e-8) where the importer gives none, or rk4, which does not control its error: it
    divides each communication step into the fewest equal steps that are not longer than
    `step_size`. `stop_time` and `step_size` [s] are those of the default experiment (10 and 0.01).
    `outputs` are shell patterns of the outputs and states to be seen; what computes the others only
    is left out; default all. `documentation` has more files: name in the archive, below
    ``documentation/`` or ``model.png`` (FMI 3.0: ``terminalsAndIcons/icon.png``), → content.
    `sources` adds the C sources of a native FMU's library, for importers that compile.

    Variables and value references of a program are the same for both kinds, and so are results, to
    the bit. The same source gives the same bytes. InputError if an option is not one, if the name
    cannot be a model identifier, the step size is longer than the experiment, a pattern matches
    nothing, a Python module has a syntax error, or something
    else than a program should be what only programs can be; RunError if there is no library for
    native FMUs; ValueError if the description contradicts itself.
    """
    if isinstance(outputs, str):
        message = f"outputs: expected a list of patterns, got the text {outputs!r}"
        raise InputError.single(message, f"write outputs=[{outputs!r}]")
    options = Options(
        native=native,
        fmi=str(fmi),
        method=method,
        tolerance=tolerance,
        stop_time=stop_time,
        step_size=step_size,
        outputs=None if outputs is None else tuple(outputs),
        documentation=dict(documentation or {}),
        sources=sources,
    )
    path = Path(path)
    write_record(path, BuildRecord(fmu=write_archive(fmu_files(source, options), path)))
    return path


def fmu_files(source: Program | PythonSource, options: Options) -> dict[str, bytes]:
    """Every file of the FMU: name in the archive → content."""
    if isinstance(source, Program):
        program = shown(source, options)
        description = described(program, options)
        if options.native:
            members = native_members(program, description, options)
        else:
            members = python_members(python_slave(program, description, options.method))
        return _with_description(members, description, options)
    if not isinstance(source, PythonSource):
        message = f"expected a Program or a PythonSource, got {type(source).__name__}"
        raise InputError.single(message, "model_program makes that of a model, or of a model file")
    for name in OF_PROGRAMS:
        if getattr(options, name) != getattr(Options(), name):
            what = "be a native FMU" if name == "native" else f"have the option {name!r}"
            message = f"{source.description.name} is Python code: it cannot {what}"
            raise InputError.single(message, f"build it without {name}")
    description = asked(source.description, options)
    members = python_members(replace(source, description=description))
    return _with_description(members, description, options)


def _with_description(
    files: dict[str, bytes], description: ModelDescription, options: Options
) -> dict[str, bytes]:
    """Members of an FMU with its description, licenses and documentation, and what follows."""
    files |= license_files(files, native=options.native) | dict(options.documentation)
    identifier = model_identifier(description.name)
    sources = [Path(name).name for name in files if re.fullmatch(r"sources/.*\.c", name)]
    form = NATIVE_2 if options.native else PYTHON
    if options.fmi == "3":
        form = NATIVE_3
        if sources:
            files[BUILD] = build_description_xml(identifier, sources)
    xml = model_description_xml(description, form, model_identifier=identifier, sources=sources)
    guid = f"{{{uuid.uuid5(GUID_NAMESPACE, content_hash({**files, 'xml': xml}, length=64))}}}"
    if options.native:
        files[SETTINGS] = f"{guid} ".encode() + files[SETTINGS]
    named = rf'\1="{guid}"'.encode()
    files[XML] = re.sub(rb'(guid|instantiationToken)=""', named, xml, count=1)
    return files
