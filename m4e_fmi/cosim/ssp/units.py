"""Unit definitions: name → base units, read and written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from lxml import etree

from m4e_fmi.cosim.ssp.package import SSC, Element
from m4e_fmi.units import BASE_UNITS, Unit, parse_unit


@dataclass(frozen=True)
class Definition:
    """A unit and what it adds after the factor (temperatures)."""

    unit: Unit
    offset: float = 0.0


def read_units(root: Element) -> dict[str, Definition]:
    """Units that a file defines, by name."""
    found = {}
    for element in root.iter(f"{SSC}Unit"):
        base = element.find(f"{SSC}BaseUnit")
        exponents = tuple(int(base.get(name, 0)) for name in BASE_UNITS)
        unit = Unit(element.get("name"), exponents, float(base.get("factor", 1)))
        found[unit.text] = Definition(unit, float(base.get("offset", 0)))
    return found


def unit_named(name: str, *known: Mapping[str, Definition]) -> Definition:
    """The first definition of `name`, or what it says itself; ValueError if it says nothing."""
    for definitions in known:
        if name in definitions:
            return definitions[name]
    return Definition(parse_unit(name))


def write_units(parent: Element, definitions: Mapping[str, Definition]) -> None:
    """Append the element `Units` to `parent`, in its own namespace, if there are any."""
    if not definitions:
        return
    units = etree.SubElement(parent, f"{{{etree.QName(parent).namespace}}}Units")
    for name, definition in sorted(definitions.items()):
        element = etree.SubElement(units, f"{SSC}Unit", name=name)
        base = etree.SubElement(element, f"{SSC}BaseUnit")
        for symbol, exponent in zip(BASE_UNITS, definition.unit.exponents, strict=True):
            if exponent:
                base.set(symbol, str(exponent))
        if definition.unit.factor != 1.0:
            base.set("factor", repr(definition.unit.factor))
        if definition.offset:
            base.set("offset", repr(definition.offset))
