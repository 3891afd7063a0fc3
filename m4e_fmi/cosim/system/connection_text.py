"""Grammar of a connection's text.

    a.group <-> b.group
    a.variable -> b.variable
    a.variable * 2.5 + 1 -> b.variable
    a.variable * 2.5 + 1 -> b.variable, units ignored
    a.variable -> b.variable, delayed

Factor and offset act on the value in the target's unit: it is converted first. Where units are
ignored, they act on the bare number. A delayed value is carried over one step late. Both may be
written behind a connection: ``, units ignored, delayed``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass

from m4e_fmi.errors import InputError, Problem, suggestion

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TEXT = re.compile(
    r"\s*(?P<left>\S.*?)"
    rf"(?:\s+\*\s+(?P<factor>{_NUMBER}))?"
    rf"(?:\s+(?P<sign>[+-])\s+(?P<offset>{_NUMBER}))?"
    r"\s*(?P<arrow><->|->)\s*(?P<right>\S.*?)"
    r"(?P<ignored>\s*,\s*units ignored)?(?P<delayed>\s*,\s*delayed)?\s*$"
)
_OPERATOR = re.compile(r"\s[*/+-]\s")


@dataclass(frozen=True)
class ConnectionText:
    """A connection's text in parts: target = `factor` · source + `offset`.

    `left` and `right` are ``component.name``; with `both_ways` they name groups, whose members
    are carried as they are. One that is `delayed` has the value of the previous step.
    """

    left: str
    right: str
    both_ways: bool = False
    factor: float = 1.0
    offset: float = 0.0
    units_ignored: bool = False
    delayed: bool = False

    def __str__(self) -> str:
        text = self.left
        if self.factor != 1.0:
            text += f" * {self.factor!r}"
        if self.offset != 0.0:
            text += f" {'-' if self.offset < 0 else '+'} {abs(self.offset)!r}"
        text += f" {'<->' if self.both_ways else '->'} {self.right}"
        text += ", units ignored" if self.units_ignored else ""
        return text + (", delayed" if self.delayed else "")


def unknown_component(end: str, known: Collection[str]) -> Problem | None:
    """The problem of an end, ``component.name``, whose component is not `known`."""
    component = end.partition(".")[0]
    if component in known:
        return None
    remedy = suggestion(component, known, "components")
    return Problem(f"unknown component {component!r}", remedy)


def parse_connection(text: str) -> ConnectionText:
    """The parts of a connection's text; InputError if it is not a connection."""
    if text.count("->") > 1:
        remedy = "write a connection for each pair"
        raise InputError.single(f"{text!r} has more than one arrow", remedy)
    match = _TEXT.match(text)
    if not match:
        remedy = "write 'a.group <-> b.group' or 'a.variable -> b.variable'"
        raise InputError.single(f"not a connection: {text!r}", remedy)
    factor, offset = float(match["factor"] or 1.0), float(match["offset"] or 0.0)
    if match["sign"] == "-":
        offset = -offset
    found = ConnectionText(
        match["left"],
        match["right"],
        both_ways=match["arrow"] == "<->",
        factor=factor,
        offset=offset,
        units_ignored=match["ignored"] is not None,
        delayed=match["delayed"] is not None,
    )
    _check(found)
    return found


def _check(found: ConnectionText) -> None:
    """InputError for parts that a connection cannot have."""
    factor, offset = found.factor, found.offset
    if _OPERATOR.search(found.left):
        message = f"{found.left!r} is more than a variable with factor and offset"
        remedy = "one number may follow '*', and after that one '+' or '-': 'a.y * 2.5 + 1 -> b.u'"
        raise InputError.single(message, remedy)
    if not (math.isfinite(factor) and math.isfinite(offset)) or factor == 0.0:
        message = f"factor {factor:g}, offset {offset:g}"
        raise InputError.single(message, "expected numbers, no factor 0")
    if found.both_ways and (factor, offset, found.units_ignored) != (1.0, 0.0, False):
        message = "a connector '<->' takes no factor, no offset and heeds units"
        remedy = "connect single variables with '->'; units are converted in both"
        raise InputError.single(message, remedy)
    if found.both_ways and found.delayed:
        remedy = "beside it, write 'a.g.y -> b.g.y, delayed' for each variable that is to be late"
        raise InputError.single("a connector '<->' is not delayed as a whole", remedy)
