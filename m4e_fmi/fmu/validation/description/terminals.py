"""Terminals of an FMI 3.0 FMU: their file can be read, and their variables are there."""

from __future__ import annotations

from collections.abc import Iterator

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  it has no types

from m4e_fmi.fmu.export.description.terminals import TERMINALS
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
        root = etree.fromstring(path.read_bytes())
    except etree.XMLSyntaxError as error:
        yield Finding(
            "terminals.invalid", "error", f"{TERMINALS} is not valid XML: {error.msg}", BASIS
        )
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
