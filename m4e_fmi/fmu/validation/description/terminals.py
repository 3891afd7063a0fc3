"""Terminals of an FMI 3.0 FMU: their file can be read, and their variables are there."""

from __future__ import annotations

from collections.abc import Iterator

from m4e_fmi.errors import InputError
from m4e_fmi.files.xml_text import check_size, xml_root
from m4e_fmi.fmu.export.model_description import TERMINALS
from m4e_fmi.fmu.importer.elements import array_name
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.fmu_under_test import FmuUnderTest

BASIS = "FMI 3.0.2, section 2.4.9"


def check_terminals(subject: FmuUnderTest) -> Iterator[Finding]:
    """Findings about terminals and icons."""
    path = subject.folder / TERMINALS
    if not (subject.fmi_3 and path.is_file()):
        return
    try:
        check_size(path.stat().st_size, TERMINALS)
        root = xml_root(path.read_bytes(), TERMINALS)
    except InputError as error:
        message = f"{TERMINALS} {error.problems[0].message}"
        yield Finding("terminals.invalid", "error", message, BASIS)
        return
    names = {v.name for v in subject.raw.modelVariables} | set(
        map(array_name, subject.raw.modelVariables)
    )
    absent = [
        f"{member.get('variableName')} (line {member.sourceline})"
        for member in root.iterfind(".//TerminalMemberVariable")
        if member.get("variableName") not in names
    ]
    if absent:
        message = f"{TERMINALS} names variables that are not there: {some(absent)}"
        yield Finding("terminals.variables", "error", message, BASIS)
