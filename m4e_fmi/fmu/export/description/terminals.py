"""Terminals of an FMI 3.0 FMU: its connectors, for importers that connect whole groups.

A connector is what has names that begin alike: `body.buoy.position`, `body.buoy.force`. Members of
two terminals belong together if their names are equal, and either may have more: rule "bus".
Source: FMI Specification 3.0.2, section 2.4.9.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from m4e_fmi.fmu.export.description.arrays import Grouped
from m4e_fmi.fmu.export.description.xml_parts import xml_bytes

TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"


def terminals_xml(variables: Sequence[Grouped]) -> bytes | None:
    """The XML text (UTF-8) with a terminal for each group with inputs and outputs; None if none."""
    groups: dict[str, dict[str, Grouped]] = {}
    for variable in variables:
        prefix, dot, last = variable.name.rpartition(".")
        if dot and variable.first.causality in ("input", "output"):
            groups.setdefault(prefix, {})[last] = variable
    chosen = {
        name: members
        for name, members in groups.items()
        if len({v.first.causality for v in members.values()}) == 2
    }
    if not chosen:
        return None
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = SubElement(root, "Terminals")
    for name, members in chosen.items():
        terminal = SubElement(terminals, "Terminal", name=name, matchingRule="bus")
        for last, variable in members.items():
            SubElement(
                terminal,
                "TerminalMemberVariable",
                variableName=variable.name,
                memberName=last,
                variableKind="signal",
            )
    return xml_bytes(root)
