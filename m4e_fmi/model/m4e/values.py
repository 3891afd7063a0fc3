"""Entries of the paper's lists: rows, numbers, NaN, sums; and findings with their places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any, TypeAlias

from m4e_fmi.files.document import Location
from m4e_fmi.model.expression import Expression, ExpressionError
from m4e_fmi.model.findings import ModelFinding
from m4e_fmi.model.quantity import as_expression

Data: TypeAlias = Any
"""An entry of the lists: a number, a text, an expression of SymPy, a list of such."""

NAN = object()
"""Stands for an entry that is NaN: not given."""


class Lists:
    """The lists as plain Python, the findings so far, and where the lists say each element."""

    def __init__(self, lists: Mapping[str, Data]) -> None:
        self.lists = lists
        self.findings: list[ModelFinding] = []
        self.places: dict[Location, Location] = {}

    def say(self, at: Location, message: str, remedy: str = "") -> None:
        """Note a finding at a place of the lists."""
        self.findings.append(ModelFinding(at, message, remedy))

    def place_of(self, location: Location) -> Location:
        """Where in the lists something at `location` of the model was said."""
        for length in range(len(location), 0, -1):
            if location[:length] in self.places:
                return (*self.places[location[:length]], *location[length:])
        return location

    def list_of(self, key: str, remedy: str) -> list[Data]:
        """The list named `key`; empty, with a finding, if there is none."""
        value = self.lists.get(key)
        if key not in self.lists:
            self.say((key,), f"missing list {key!r}", remedy)
        elif not isinstance(value, list):
            self.say((key,), f"expected a list, got {value!r}", remedy)
        return value if isinstance(value, list) else []


def plain(value: Data) -> Data:
    """Arrays and tuples as lists, at any depth; the rest as it is."""
    if hasattr(value, "tolist") and not hasattr(value, "free_symbols"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    return value


def is_row(value: object, length: int) -> bool:
    """True for a list of `length` entries."""
    return isinstance(value, list) and len(value) == length


def first_of(value: Data) -> Data:
    """The entry of a row of one, as columns of numbers have them."""
    return value[0] if is_row(value, 1) else value


def is_number(value: object) -> bool:
    """True for a real number, numpy's included; False for a boolean."""
    return not isinstance(value, bool) and isinstance(value, Real)


def is_whole(value: object) -> bool:
    """True for an integer, numpy's included; False for a boolean."""
    return not isinstance(value, bool) and isinstance(value, Integral)


def is_nan(value: object) -> bool:
    """True for NaN and for None: entries that are not given."""
    return value is None or str(value) == "nan" or (is_number(value) and value != value)


def added(a: Sequence[Data], b: Sequence[Data]) -> tuple[Data, ...]:
    """The sum of two rows, entry by entry."""
    return tuple(plus(x, y) for x, y in zip(a, b, strict=True))


def plus(a: Data, b: Data) -> Data:
    """a + b: a number if both are numbers, else an Expression."""
    if is_number(a) and is_number(b):
        return a + b
    if is_number(a) and a == 0:
        return b
    try:
        return Expression("add", (as_expression(a), as_expression(b)))
    except ExpressionError:  # reported where the value itself is checked
        return b
