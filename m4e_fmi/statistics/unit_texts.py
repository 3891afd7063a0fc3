"""Units of statistics, from the text of the unit of the values."""

from __future__ import annotations

import re

from m4e_fmi.units import SPELLINGS

_PIECE = re.compile(r"([A-Za-zµ°%Ω]+)\^?(-?\d+)?")
_PLAIN = ("", "1")


def same(unit: str) -> str:
    """The unit of the values."""
    return unit


def none(unit: str) -> str:  # noqa: ARG001
    """That of numbers without dimension."""
    return "1"


def seconds(unit: str) -> str:  # noqa: ARG001
    """That of times."""
    return "s"


def squared(unit: str) -> str:
    """The square of a unit, as ``m2/s2`` of ``m/s``."""
    if unit in _PLAIN:
        return "1"
    return _PIECE.sub(lambda one: f"{one[1]}{2 * int(one[2] or 1)}", unit.translate(SPELLINGS))


def squared_times_frequency(power: int, unit: str) -> str:
    """The square of a unit times (rad/s) to a power from 1 on: that of spectral moments."""
    top, _, bottom = squared(unit).partition("/")
    of = "" if power == 1 else str(power)
    upper = [*([] if top in _PLAIN else [top]), f"rad{of}"]
    lower = [*([bottom.strip("()")] if bottom else []), f"s{of}"]
    return f"{'.'.join(upper)}/{lower[0] if len(lower) == 1 else '(' + '.'.join(lower) + ')'}"
