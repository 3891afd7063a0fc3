"""Unreadable parts of a model description: invalid numbers and references.

The XML schema checks numbers, too, but an FMU is read, stepped and shown without it. Sources:
FMI Specification 2.0.4, section 2.2; 3.0.2, section 2.4.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import starmap
from typing import Any

from lxml import etree

from m4e_fmi.files.xml_text import broken_names

Element = Any
"""An lxml element."""

KINDS = ("ModelExchange", "CoSimulation", "ScheduledExecution")
_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
_REALS = ("min", "max", "nominal", "factor", "offset", "startTime", "stopTime", "tolerance")
_REFERENCES = range(2**32)
_NUMBERS: dict[str, Callable[[str], object]] = {
    **dict.fromkeys((*_REALS, "stepSize", "fixedInternalStepSize"), float),
    **dict.fromkeys(("index", "derivative", "maxOutputDerivativeOrder"), int),
    **dict.fromkeys(("kg", "m", "s", "A", "K", "mol", "cd", "rad"), int),
    "numberOfEventIndicators": int,
    "valueReference": lambda text: _REFERENCES.index(int(text)),
}
"""Attribute → how it is read, wherever FMI has it."""
_OF_FMI = (
    "descendant-or-self::*[not(ancestor-or-self::VendorAnnotations)]"
    "[not(ancestor-or-self::Annotations)]"
)
"""Elements of FMI: the content of annotations is anyone's."""


@dataclass(frozen=True)
class Flaw:
    """One thing that is wrong, and its line in the file.

    `known` if validation by FMPy and the XML schema tells it, too.
    """

    line: int
    message: str
    known: bool = False


def flaws(text: bytes) -> list[Flaw]:
    """Everything in the XML `text` for which it cannot be understood."""
    try:
        root = etree.fromstring(text)
    except etree.XMLSyntaxError as error:
        return [Flaw(error.lineno or 1, f"no XML: {error.msg.split(', line')[0]}")]
    if root.tag != "fmiModelDescription":
        return [Flaw(root.sourceline, f"the root element is {root.tag}, not fmiModelDescription")]
    version = root.get("fmiVersion") or ""
    if not version:
        return [Flaw(root.sourceline, "fmiModelDescription has no fmiVersion")]
    found = [*_missing(root, version), *_numbers(root), *starmap(Flaw, broken_names(root))]
    return found or list(_references(root, version))


def undefined_units(text: bytes) -> list[Flaw]:
    """The units that variables and types in the XML `text` have, but UnitDefinitions has not."""
    root = etree.fromstring(text)
    units = {unit.get("name") for unit in root.iterfind("UnitDefinitions/Unit")}
    lines: dict[str, int] = {}
    for part in root.xpath("(TypeDefinitions | ModelVariables)//*[@unit]"):
        if part.get("unit") not in units:
            lines.setdefault(part.get("unit"), part.sourceline)
    return [Flaw(line, f"the unit {unit} is not defined") for unit, line in lines.items()]


def _missing(root: Element, version: str) -> Iterator[Flaw]:
    if version != "1.0" and not any(root.find(kind) is not None for kind in KINDS):
        yield Flaw(root.sourceline, f"it is for none of {', '.join(KINDS)}")
    if root.find("ModelVariables") is None:
        yield Flaw(root.sourceline, "there is no ModelVariables", known=True)
    for variable in root.xpath("ModelVariables/*[not(@valueReference)]"):
        message = f"{_name(variable)} has no valueReference"
        yield Flaw(variable.sourceline, message, known=True)
    for variable in root.xpath(f"ModelVariables/ScalarVariable[not({' | '.join(_TYPES)})]"):
        message = f"{_name(variable)} has none of the types {', '.join(_TYPES)}"
        yield Flaw(variable.sourceline, message, known=True)


def _numbers(root: Element) -> Iterator[Flaw]:
    for element in root.xpath(_OF_FMI):
        for name, value in element.attrib.items():
            read = _of_start(element) if name == "start" else _NUMBERS.get(name)
            if read is not None and not _readable(read, value):
                what = "value reference" if name == "valueReference" else "number"
                message = f'{_name(element)}: {name}="{value}" is no {what}'
                yield Flaw(element.sourceline, message, known=True)


def _of_start(element: Element) -> Callable[[str], object] | None:
    """How the start value of an element is read; None where it is no number."""
    tag = element.tag
    if tag == "Real" or tag.startswith("Float"):
        one = float
    elif tag in ("Integer", "Enumeration", "Dimension") or tag.startswith(("Int", "UInt")):
        one = int
    else:
        return None
    if element.getparent().tag != "ModelVariables" or element.find("Dimension") is None:
        return one
    return lambda text: [one(part) for part in text.split()]


def _readable(read: Callable[[str], object], text: str) -> bool:
    try:
        read(text)
    except ValueError:
        return False
    return True


def _references(root: Element, version: str) -> Iterator[Flaw]:
    """References to variables that are not there."""
    variables = root.findall("ModelVariables/*")
    if version == "2.0":
        known = set(range(1, len(variables) + 1))
        what, places = "index", [(v, "derivative") for v in root.iterfind("ModelVariables/*/Real")]
    elif version.startswith("3."):
        known = {int(v.get("valueReference")) for v in variables}
        what = "valueReference"
        places = [(v, name) for v in variables for name in ("derivative", "clocks")]
        places += [(d, what) for v in variables for d in v.iterfind("Dimension")]
    else:
        return
    unknowns = root.findall("ModelStructure/*/Unknown" if version == "2.0" else "ModelStructure/*")
    places += [(u, name) for u in unknowns for name in (what, "dependencies")]
    for element, name in places:
        for reference in (element.get(name) or "").split():
            if not _readable(int, reference) or int(reference) not in known:
                message = f"{_name(element)}: {name} has {reference}, the {what} of no variable"
                yield Flaw(element.sourceline, message, known=name == "derivative")


def _name(element: Element) -> str:
    """Name of the element for messages: its own, or that of the variable it is in."""
    parent = element.getparent()
    return element.get("name") or (parent.get("name") if parent is not None else "") or element.tag
