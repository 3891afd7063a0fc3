"""Which variable may take the value of which, by their types; and within which bounds.

====================  =============================================================
from                  to
====================  =============================================================
Real                  Real
Integer               Integer, Real; Enumeration, if the number is that of an item
Boolean               Boolean; Integer, Real (0 or 1)
Enumeration           Enumeration of the same items, Integer
String                String
====================  =============================================================

Integers are of any width: a value that the input's type does not hold ends the run. Factor and
offset need a Real input.
"""

from __future__ import annotations

import re

from m4e_fmi.fmu.importer.reading import Variable

REAL = "Real"
_TO = {
    "Real": ("Real",),
    "Integer": ("Integer", "Real", "Enumeration"),
    "Boolean": ("Boolean", "Integer", "Real"),
    "Enumeration": ("Enumeration", "Integer"),
    "String": ("String",),
    "Binary": (),
}
_SIZED = re.compile(r"(U?)Int(\d+)")
_CELL = -(2**63), 2**63 - 1
"""The smallest and the largest int64."""
TYPES = tuple(kind for kind in _TO if _TO[kind])
"""The types that can be connected, and recorded."""
DISCRETE = tuple(kind for kind in TYPES if kind != REAL)


def misfit(give: Variable, take: Variable, *, plain: bool) -> tuple[str, str] | None:
    """Why `take` cannot have the value of `give`, and what to do; None if it can.

    A `plain` connection has neither factor nor offset.
    """
    what = f"is {_type_text(give)}, {_type_text(take)} is expected"
    if take.type not in _TO[give.type]:
        others = " or ".join(_TO[give.type])
        remedy = f"a value of type {give.type} may lead to {others} only"
        if give.type == "Binary":
            remedy = "values of type Binary are not exchanged"
        elif give.type == REAL:
            remedy += "; let an FMU round it or compare it"
        return what, remedy
    if take.type == "Enumeration":
        return _misfit_of_items(give, take, what)
    if take.type != REAL and not plain:
        return (
            f"has a factor or an offset, and leads to {_type_text(take)}",
            "they need a Real input",
        )
    return None


def _misfit_of_items(give: Variable, take: Variable, what: str) -> tuple[str, str] | None:
    if give.type == "Enumeration" and dict(give.items) != dict(take.items):
        return what, "connect an enumeration of the same items, or an Integer input"
    numbers = sorted(take.items.values())
    if give.type == "Integer" and numbers != list(range(numbers[0], numbers[-1] + 1)):
        return what, f"its items are not numbered one after the other: {numbers}"
    return None


def _type_text(variable: Variable) -> str:
    if variable.items:
        items = ", ".join(f"{name} {number}" for name, number in variable.items.items())
        return f"Enumeration ({items})"
    return variable.type


def bounds(give: Variable, take: Variable) -> tuple[int, int]:
    """The smallest and the largest int64 with a value of `give` that `take` can have.

    Values of UInt64 lie in int64 by their bits, so that large ones are negative.
    """
    if give.type == "Boolean" or take.type in (REAL, "String", "Boolean"):
        return _CELL
    both = is_large(give), is_large(take)
    if both == (True, True):
        return _CELL
    low, high = range_of_type(take)
    return max(low, 0 if True in both else low), min(high, _CELL[1])


def is_large(variable: Variable) -> bool:
    """True if values may be above those of int64."""
    return variable.fmi_type == "UInt64"


def range_of_type(variable: Variable) -> tuple[int, int]:
    """The smallest and the largest whole number of a type (32 bits in FMI 2.0), or of its items."""
    if variable.items:
        return min(variable.items.values()), max(variable.items.values())
    sized = _SIZED.fullmatch(variable.fmi_type)
    unsigned, bits = (bool(sized[1]), int(sized[2])) if sized else (False, 32)
    if variable.type == "Enumeration":
        return _CELL
    return (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
