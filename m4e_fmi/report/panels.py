"""Panels of figures, and lines of summaries: which variables of a result they show, and numbers as
they show them, with four significant digits and prefixes of units (kN, MN)."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from m4e_fmi.report.drawing.style import BODY_COLOURS
from m4e_fmi.results.results_file import Series

DIGITS = 4
_PREFIXES = {1e9: "G", 1e6: "M", 1e3: "k", 1.0: "", 1e-3: "m"}
ROUNDED = 1.0 - 0.5e-4
"""Share of a factor from which a value with DIGITS is the factor."""
_LEAST_FIXED = 1e-4
"""Below this a number is written with a power of ten."""


def scale_of(largest: float) -> tuple[float, str]:
    """Factor of SI values and prefix of their unit, where `largest` is shown.

    1 and no prefix for 0, and for what is smaller than a thousandth.
    """
    for factor, prefix in _PREFIXES.items():
        if largest >= factor * ROUNDED:
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


MOST_LINES = len(BODY_COLOURS)
ROUNDING = 1e-12  # of the largest range in a panel: what moves by rounding only


@dataclass(frozen=True)
class Panel:
    """Series shown together: `unit` is what the axis shows, SI values times `scale`.

    `left_out` is how many others belong here and are not shown. What is not Real is drawn in
    `steps`; `items` are names of its values.
    """

    title: str
    unit: str
    scale: float
    series: dict[str, Series] = field(default_factory=dict)
    from_start: bool = False
    left_out: int = 0
    steps: bool = False
    items: Mapping[str, int] = field(default_factory=dict)

    @property
    def curves(self) -> dict[str, np.ndarray]:
        """Curves by the names of the series, (n_times,), in the panel's unit, angles unwrapped."""
        found = {name: _unwrapped(one) for name, one in self.series.items()}
        return {
            name: self.scale * (values - (values[:1] if self.from_start else 0.0))
            for name, values in found.items()
        }


@dataclass(frozen=True)
class _Rule:
    title: str
    pattern: str
    si_unit: str
    unit: str
    scale: float
    from_start: bool = False


_WATER = re.compile(r"wave\.elevation$|fairlead_tension$")
_OF_MODELS = re.compile(r"(?:^|\.)(?:joint|body|point|load|energy|inputs)\.")
_JOINT = r"joint\.\w+\.q\w*$"
_ATTITUDE = re.compile(r"\.(?:phi|theta|psi)$")
_EFFORT = r"\.effort\w*$|(?:^|\.)load\.\w+\.moment$"
# `inputs.power` of a model lifts and lowers its weight, which hides what a take-off takes
_RULES = (
    _Rule("wave elevation", r"wave\.elevation$", "m", "m", 1.0),
    _Rule("motion from start", r"body\.\w+\.[xyz]$", "m", "m", 1.0, from_start=True),
    _Rule("rotation", r"body\.\w+\.(phi|theta|psi)$", "rad", "deg", 180 / math.pi),
    _Rule("line tension", r"fairlead_tension$", "N", "N", 1.0),
    _Rule("power", r"(?<!\binputs\.)power$", "W", "W", 1.0),
)


_MECHANISM = (
    _Rule("joint angles", _JOINT, "rad", "deg", 180 / math.pi),
    _Rule("joint positions", _JOINT, "m", "m", 1.0),
    _Rule("efforts", _EFFORT, "N.m", "N.m", 1.0),
    _Rule("efforts", _EFFORT, "N", "N", 1.0),
    _RULES[-1],
)


def panels(series: dict[str, Series]) -> list[Panel]:
    """The panels for `series` (full name → series): the usual ones, else one per unit.

    Of mechanisms, which have joints and no water: angles, positions and efforts of joints, and what
    is of other components.
    """
    names = [one.name for one in series.values()]
    wet = any(map(_WATER.search, names))
    dry = not wet and any(re.search(_JOINT, name) for name in names)
    usual = []
    for rule in _MECHANISM if dry else _RULES:
        found = {
            name: one
            for name, one in series.items()
            if one.recorded.is_real
            and one.unit == rule.si_unit
            and re.search(rule.pattern, one.name)
        }
        if found:
            usual.append(Panel(rule.title, rule.unit, rule.scale, found, rule.from_start))
    if dry:
        rest = {name: one for name, one in series.items() if not _OF_MODELS.search(one.name)}
        return [*map(_scaled, usual), *by_unit(rest)]
    return [*map(_scaled, usual)] if len(usual) > 1 else by_unit(series)


def by_unit(series: dict[str, Series]) -> list[Panel]:
    """One panel for each unit, with all `series` (full name → series) of that unit.

    One more for each type that is not Real, and each enumeration; texts are in none.
    """
    reals = {name: one for name, one in series.items() if one.recorded.is_real}
    found = [
        Panel("", unit, 1.0, {name: one for name, one in reals.items() if one.unit == unit})
        for unit in dict.fromkeys(one.unit for one in reals.values())
    ]
    others: dict[tuple[str, *tuple[tuple[str, int], ...]], dict[str, Series]] = {}
    for name, one in series.items():
        kind = one.recorded
        if not (kind.is_real or kind.is_text):
            others.setdefault((kind.type, *kind.named.items()), {})[name] = one
    return [*map(_scaled, found)] + [
        Panel(key[0], "", 1.0, members, steps=True, items=dict(key[1:]))
        for key, members in others.items()
    ]


def _scaled(panel: Panel) -> Panel:
    """The panel of a force or power in a multiple of its unit that fits its values, as kW."""
    if panel.unit not in ("N", "W"):
        return panel
    series = panel.series.values()
    factor, prefix = scale_of(max(float(np.abs(s.values).max(initial=0.0)) for s in series))
    return replace(panel, unit=f"{prefix}{panel.unit}", scale=factor)


def moving(shown: list[Panel]) -> list[Panel]:
    """The panels with the series that change by more than rounding; as they are if none does."""
    changing = [replace(panel, series=_changing(panel)) for panel in shown]
    return [panel for panel in changing if panel.series] or shown


def fitting(panel: Panel) -> Panel:
    """The panel with at most MOST_LINES series: those that vary most."""
    if len(panel.series) <= MOST_LINES:
        return panel
    ranges = {name: _height(curve) for name, curve in panel.curves.items()}
    kept = sorted(ranges, key=lambda name: -ranges[name])[:MOST_LINES]
    series = {name: one for name, one in panel.series.items() if name in kept}
    return replace(panel, series=series, left_out=len(panel.series) - len(series))


def _changing(panel: Panel) -> dict[str, Series]:
    """The series of a panel that change, but for rounding of what would not."""
    ranges = {name: _height(curve) for name, curve in panel.curves.items()}
    least = ROUNDING * max(filter(math.isfinite, ranges.values()), default=0.0)
    return {name: one for name, one in panel.series.items() if not ranges[name] <= least}


def _unwrapped(one: Series) -> np.ndarray:
    """The values as numbers (n_times,); of an attitude within ±π [rad] without its jumps by 2π."""
    values = one.values.astype(float)
    known = np.isfinite(values)
    if _ATTITUDE.search(one.name) and np.abs(values[known]).max(initial=0.0) <= math.pi:
        values[known] = np.unwrap(values[known])
    return values


def _height(curve: np.ndarray) -> float:
    """From the lowest to the highest value."""
    return float(np.ptp(curve)) if len(curve) else 0.0
