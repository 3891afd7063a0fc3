"""Parts that the descriptions of FMI 2.0 and 3.0 share: texts, units, types, quantities."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from m4e_fmi.fmu.export.description.description import FmuVariable, ModelDescription
from m4e_fmi.fmu.export.description.quantities import QUANTITIES, display_factor, quantities_of
from m4e_fmi.units import BASE_UNITS, parse_unit

LOG_CATEGORIES = {
    "logStatusWarning": "Messages with status warning.",
    "logStatusDiscard": "Messages with status discard.",
    "logStatusError": "Messages with status error.",
    "logStatusFatal": "Messages with status fatal.",
    "logAll": "All messages.",
}
DECLARATION = "<?xml version='1.0' encoding='UTF-8'?>"


def xml_bytes(root: Element) -> bytes:
    """The document of `root`, indented, in UTF-8."""
    indent(root)
    text = tostring(root, encoding="unicode")  # encoded at once, which takes half the time
    return f"{DECLARATION}\n{text}\n".encode()


def legal(text: str) -> str:
    """`text` with the characters that XML 1.0 cannot hold replaced."""
    return re.sub("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", text)


def add_experiment(root: Element, description: ModelDescription) -> None:
    """Add the categories of messages and the default experiment."""
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(description.stop_time),
        tolerance=repr(description.tolerance),
        stepSize=repr(description.step_size),
    )


def add_units(root: Element, variables: Sequence[FmuVariable]) -> None:
    """Add the units of `variables`, with what their values may be shown in."""
    displays: dict[str, set[str]] = {}
    for variable in variables:
        if variable.type == "Real":
            displays.setdefault(variable.unit, set())
            if variable.display_unit:
                displays[variable.unit].add(variable.display_unit)
    if not displays:
        return
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted(displays):
        unit = parse_unit(name)
        element = SubElement(definitions, "Unit", name=name)
        powers = {
            base: str(power)
            for base, power in zip(BASE_UNITS, unit.exponents, strict=True)
            if power
        }
        if unit.factor != 1.0:
            powers["factor"] = repr(unit.factor)
        SubElement(element, "BaseUnit", powers)
        offered = QUANTITIES[name].displays if name in QUANTITIES else ()
        for display in sorted({*displays[name], *offered}):
            factor = display_factor(name, display)
            SubElement(element, "DisplayUnit", name=display, factor=repr(factor))


def add_types(root: Element, variables: Sequence[FmuVariable], tag: str) -> None:
    """Add the quantities of `variables` as types: `SimpleType` of FMI 2.0, `Float64Type` of 3.0."""
    quantities = quantities_of([v.unit for v in variables if v.type == "Real"])
    if not quantities:
        return
    definitions = SubElement(root, "TypeDefinitions")
    for quantity in quantities:
        element = SubElement(definitions, tag, name=quantity.type_name)
        if tag == "SimpleType":
            element = SubElement(element, "Real")
        element.set("quantity", quantity.name)
        element.set("unit", quantity.unit)
        if quantity.shown:
            element.set("displayUnit", quantity.shown)


def add_quantity(element: Element, variable: FmuVariable) -> None:
    """Add type, units, limits and nominal value of a Real.

    The unit stands here, too, for importers that do not look at types.
    """
    quantity = QUANTITIES.get(variable.unit)
    if quantity:
        element.set("declaredType", quantity.type_name)
    element.set("unit", variable.unit)
    display = variable.display_unit or (quantity.shown if quantity else None)
    if display:
        element.set("displayUnit", display)
    for key, value, default in (
        ("min", variable.minimum, -math.inf),
        ("max", variable.maximum, math.inf),
        ("nominal", variable.nominal, 1.0),
    ):
        if value != default:
            element.set(key, repr(value))
