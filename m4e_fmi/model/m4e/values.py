"""Entries of the paper's lists: rows, numbers, NaN, sums; and findings with their places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any

from m4e_fmi.files.document import Location
from m4e_fmi.model.expression import Expression, ExpressionError
from m4e_fmi.model.findings import Finding
from m4e_fmi.model.quantity import as_expression

NAN = object()
"""Stands for an entry that is NaN: not given."""


class Lists:
    """The lists as plain Python, the findings so far, and where the lists say each element."""

    def __init__(self, lists: Mapping[str, Any]) -> None:
        self.lists = lists
        self.findings: list[Finding] = []
        self.places: dict[Location, Location] = {}

    def say(self, at: Location, message: str, remedy: str = "") -> None:
        self.findings.append(Finding(at, message, remedy))

    def place_of(self, location: Location) -> Location:
        """Where in the lists something at `location` of the model was said."""
        for length in range(len(location), 0, -1):
            if location[:length] in self.places:
                return (*self.places[location[:length]], *location[length:])
        return location

    def list_of(self, key: str, remedy: str) -> list[Any]:
        """The list named `key`; empty, with a finding, if there is none."""
        value = self.lists.get(key)
        if key not in self.lists:
            self.say((key,), f"missing list {key!r}", remedy)
        elif not isinstance(value, list):
            self.say((key,), f"expected a list, got {value!r}", remedy)
        return value if isinstance(value, list) else []


def plain(value: Any) -> Any:
    """Arrays and tuples as lists, at any depth; the rest as it is."""
    if hasattr(value, "tolist") and not hasattr(value, "free_symbols"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    return value


def is_row(value: Any, length: int) -> bool:
    return isinstance(value, list) and len(value) == length


def first_of(value: Any) -> Any:
    """The entry of a row of one, as columns of numbers have them."""
    return value[0] if is_row(value, 1) else value


def is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def is_whole(value: Any) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_nan(value: Any) -> bool:
    return value is None or str(value) == "nan" or (is_number(value) and value != value)


def added(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(plus(x, y) for x, y in zip(a, b, strict=True))


def plus(a: Any, b: Any) -> Any:
    if is_number(a) and is_number(b):
        return a + b
    return b if is_number(a) and a == 0 else _combined("add", a, b)


def times(a: Any, b: Any) -> Any:
    return a * b if is_number(a) and is_number(b) else _combined("mul", a, b)


def _combined(kind: str, a: Any, b: Any) -> Any:
    try:
        return Expression(kind, (as_expression(a), as_expression(b)))
    except ExpressionError:  # reported where the value itself is checked
        return b
