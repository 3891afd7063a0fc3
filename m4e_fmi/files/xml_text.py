"""XML of others: checked by a parser that refuses what no file here needs, then read.

DOCTYPE and entities, which can stand for more than memory holds or name other files, are seen by
the parser, whatever the encoding; so are depth and number of elements.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.parsers import expat

from lxml import etree

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.limits import DEEPEST_XML, LARGEST_XML, MB, MOST_ELEMENTS

Element = Any
"""An lxml element."""
_NAMES = ("name", "modelName", "modelIdentifier", "unit", "displayUnit", "quantity", "declaredType")
"""Attributes of FMI and SSP that are names."""


class _RefusedError(Exception):
    """A message and its remedy; the line is the parser's."""

    def __init__(self, message: str, remedy: str) -> None:
        self.message, self.remedy = message, remedy


def check_xml(content: bytes, file: str) -> None:
    """InputError for XML that is not to be read: DOCTYPE, entities, limits, unusual encodings.

    Whether it is well-formed is left to its reader; `file` is named in messages.
    """
    check_size(len(content), file)
    parser = expat.ParserCreate()
    depth = count = 0

    def start(*_: object) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1
        if depth > DEEPEST_XML:
            raise _RefusedError(f"is nested more than {DEEPEST_XML} levels deep", "")
        if count > MOST_ELEMENTS:
            raise _RefusedError(f"has more than {MOST_ELEMENTS:,} elements", "")

    def end(*_: object) -> None:
        nonlocal depth
        depth -= 1

    def refuse(*_: object) -> None:
        remedy = "do not use this file unless you know why it has one"
        raise _RefusedError("has a DOCTYPE, which neither FMI nor SSP uses", remedy)

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = refuse
    try:
        parser.Parse(content, True)
    except _RefusedError as error:
        problem = Problem(error.message, error.remedy, file, parser.CurrentLineNumber)
        raise InputError([problem]) from None
    except (expat.ExpatError, LookupError, ValueError):
        if _is_read(content):  # by a parser that knows more encodings, in which it was not checked
            message = "is XML in an encoding that is not read here"
            raise InputError.single(message, "save it as UTF-8", file) from None


def broken_names(root: Element) -> Iterator[tuple[int, str]]:
    """Line and message for each name in which a line ends: it could be taken for words of ours."""
    for element in root.iter(etree.Element):
        for key in _NAMES:
            name = element.get(key, "")
            if name and name.splitlines() != [name]:
                yield element.sourceline, f"the {key} {name!r} has an end of line in it"


def check_size(size: int, file: str) -> None:
    """InputError if XML of that many bytes is not read."""
    if size > LARGEST_XML:
        message = f"has {size / MB:.0f} MB; XML files of up to {LARGEST_XML // MB} MB are read"
        raise InputError.single(message, "export fewer variables", file)


def xml_root(content: bytes, file: str) -> Element:
    """Root element of XML text; InputError if it is not well-formed, or as of `check_xml`."""
    check_xml(content, file)
    try:
        return etree.fromstring(content, _parser(), base_url=file)
    except etree.XMLSyntaxError as error:
        problem = Problem(f"is not well-formed XML: {error.msg}", "", file, error.lineno or 0)
        raise InputError([problem]) from None


def _is_read(content: bytes) -> bool:
    try:
        etree.fromstring(content, _parser())
    except (etree.XMLSyntaxError, ValueError, LookupError):
        return False
    return True


def _parser() -> Any:
    return etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True,
        remove_pis=True, huge_tree=False,
    )  # fmt: skip
