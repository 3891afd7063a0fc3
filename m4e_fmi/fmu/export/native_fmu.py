"""The files of a native FMU: the shell's shared library beside the program in its binary form."""

from __future__ import annotations

from decimal import Decimal
from pathlib import PurePath

from m4e_fmi.fmu.export.archive import content_guid, model_identifier
from m4e_fmi.fmu.export.description.arrays import Grouped, grouped
from m4e_fmi.fmu.export.description.description import ModelDescription
from m4e_fmi.fmu.export.description.model_description import XML, model_description_xml, with_guid
from m4e_fmi.fmu.export.description.model_description_3 import (
    BUILD,
    build_description_xml,
    model_description_3_xml,
)
from m4e_fmi.fmu.export.description.terminals import TERMINALS, terminals_xml
from m4e_fmi.fmu.export.layout_files import layout_files
from m4e_fmi.fmu.export.licenses import license_files
from m4e_fmi.fmu.export.native import shell_binaries, shell_sources
from m4e_fmi.fmu.export.options import Options
from m4e_fmi.fmu.export.program_files import PROGRAM, TANGENT, model_file, tangent_file
from m4e_fmi.program import Program
from m4e_fmi.runtime.declarations import METHODS

SETTINGS = "resources/fmu.txt"


def native_fmu_files(
    program: Program, description: ModelDescription, options: Options
) -> dict[str, bytes]:
    """Every file of the native FMU of `program`: name in the archive → content."""
    identifier = model_identifier(description.name)
    files = {
        f"resources/{PROGRAM}": model_file(program, options.method, options.rename),
        f"resources/{TANGENT}": tangent_file(program),
    }
    binaries = shell_binaries(identifier, fmi=options.fmi)
    files |= binaries | license_files(pythonfmu=False, binaries=binaries)
    files |= options.documentation
    code = shell_sources() if options.sources else {}
    files |= code
    numbers = (_without_point(v) for v in (description.tolerance, description.step_size))
    settings = f"{METHODS[options.method]} {' '.join(numbers)}\n"
    files[SETTINGS] = settings.encode()
    listed = [PurePath(name).name for name in code if name.endswith(".c")]
    if options.fmi == "3":
        variables = grouped(description)
        if listed:
            files[BUILD] = build_description_xml(identifier, listed)
        files |= _files_of_version_3(description, variables)
        xml = model_description_3_xml(description, variables, model_identifier=identifier)
    else:
        xml = model_description_xml(
            description,
            model_identifier=identifier,
            guid="",
            native=True,
            sources=listed,
        )
    guid = content_guid(files, xml)
    files[SETTINGS] = f"{guid} {settings}".encode()
    files[XML] = with_guid(xml, guid)
    return files


def _files_of_version_3(
    description: ModelDescription, variables: tuple[Grouped, ...]
) -> dict[str, bytes]:
    lists = layout_files(description, variables)
    files = {f"resources/{name}": content for name, content in lists.items()}
    terminals = terminals_xml(variables)
    return files if terminals is None else {**files, TERMINALS: terminals}


def _without_point(value: float) -> str:
    """`value` as "25e-2": C reads it in every locale, whose decimal point may be a comma."""
    _, digits, exponent = Decimal(repr(value)).as_tuple()
    return f"{''.join(map(str, digits))}e{exponent}"
