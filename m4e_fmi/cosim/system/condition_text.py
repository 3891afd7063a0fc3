"""Grammar of a condition: ``component.variable > 2 m``."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass

from m4e_fmi.errors import InputError

COMPARISONS: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
    ">": operator.gt,
    "<": operator.lt,
}
_TEXT = re.compile(
    r"\s*(?P<name>[^<>=!\s]+)\s*(?P<sign>>=|<=|==|!=|>|<)\s*(?P<value>[^<>=!]+?)\s*$"
)


@dataclass(frozen=True)
class ConditionText:
    """A condition's text in parts: the variable ``component.name``, a comparison, a value."""

    name: str
    sign: str
    value: str


def parse_condition(text: str) -> ConditionText:
    """The parts of a condition; InputError for any other text."""
    found = _TEXT.fullmatch(text)
    if not found or "." not in found["name"]:
        raise InputError.single(
            f"{text!r} is not a condition",
            "write one comparison of a variable with a value, as 'buoy.z > 2 m' "
            f"({', '.join(COMPARISONS)})",
        )
    return ConditionText(found["name"], found["sign"], found["value"])
