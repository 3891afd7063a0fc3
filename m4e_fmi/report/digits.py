"""Numbers and prefixes of units (kN, MN) as tables and plots show them: four significant digits."""

from __future__ import annotations

import math

DIGITS = 4
_PREFIXES = {1e9: "G", 1e6: "M", 1e3: "k", 1.0: "", 1e-3: "m"}
_LEAST_FIXED = 1e-4
"""Below this a number is written with a power of ten."""


def scale_of(largest: float) -> tuple[float, str]:
    """Factor of SI values and prefix of their unit, where `largest` is shown.

    1 and no prefix for 0, and for what is smaller than a thousandth.
    """
    for factor, prefix in _PREFIXES.items():
        if largest >= factor:
            return 1 / factor, prefix
    return 1.0, ""


def quantity(value: float, unit: str) -> str:
    """An SI value in `unit` or a multiple of it, as "1.235 kW" and "400.0 mW"."""
    scale, prefix = scale_of(abs(value))
    (text,) = aligned(scale * value)
    return f"{text} {prefix}{unit}"


def percent(share: float) -> str:
    """A share of 1 [1] with its sign, as "-0.0148 %"; what is rounded to 0 has none."""
    rounded = round(100.0 * share, 4) + 0.0  # no -0.0
    return f"{rounded:+.4f} %" if rounded else "0.0000 %"


def aligned(*values: float) -> list[str]:
    """Values with equally many decimals, so that the largest has four significant digits."""
    largest = max(map(abs, values))
    if not math.isfinite(largest) or 0.0 < largest < _LEAST_FIXED:
        return [f"{value:.{DIGITS - 1}e}" for value in values]
    whole = math.floor(math.log10(largest)) + 1 if largest else 1
    decimals = max(0, DIGITS - whole)
    return [f"{round(value, decimals) + 0.0:.{decimals}f}" for value in values]  # no -0.0
