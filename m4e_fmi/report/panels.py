"""Which variables of a result belong in one panel of a figure, or one line of a summary."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from m4e_fmi.results import Series

MOST_LINES = 6


@dataclass(frozen=True)
class Panel:
    """Series shown together: `unit` is what the axis shows, SI values times `scale`."""

    title: str
    unit: str
    scale: float
    series: dict[str, Series] = field(default_factory=dict)
    from_start: bool = False


@dataclass(frozen=True)
class _Rule:
    title: str
    pattern: str
    si_unit: str
    unit: str
    scale: float
    from_start: bool = False


_RULES = (
    _Rule("wave elevation", r"wave\.elevation$", "m", "m", 1.0),
    _Rule("motion from start", r"body\.\w+\.[xz]$", "m", "m", 1.0, from_start=True),
    _Rule("rotation", r"body\.\w+\.theta$", "rad", "deg", 180 / math.pi),
    _Rule("line tension", r"fairlead_tension$", "N", "kN", 1e-3),
    _Rule("power", r"power$", "W", "kW", 1e-3),
)


def panels(series: dict[str, Series]) -> list[Panel]:
    """The panels for `series` (full name → series): the usual ones, else one per unit."""
    usual = [panel for rule in _RULES if (panel := _matching(rule, series)).series]
    return usual if len(usual) > 1 else _by_unit(series)


def moving(shown: list[Panel]) -> list[Panel]:
    """The panels with the series that change; as they are if nothing changes."""
    changing = [
        replace(panel, series={name: s for name, s in panel.series.items() if _changes(s)})
        for panel in shown
    ]
    return [panel for panel in changing if panel.series] or shown


def _changes(series: Series) -> bool:
    return bool((series.values != series.values[:1]).any())


def _matching(rule: _Rule, series: dict[str, Series]) -> Panel:
    found = {
        name: one
        for name, one in series.items()
        if one.unit == rule.si_unit and re.search(rule.pattern, one.name)
    }
    return Panel(rule.title, rule.unit, rule.scale, _first(found.items()), rule.from_start)


def _by_unit(series: dict[str, Series]) -> list[Panel]:
    units = dict.fromkeys(one.unit for one in series.values())
    return [
        Panel("", unit, 1.0, _first((n, one) for n, one in series.items() if one.unit == unit))
        for unit in units
    ][:MOST_LINES]


def _first(items: Iterable[tuple[str, Series]]) -> dict[str, Series]:
    return dict(list(items)[:MOST_LINES])
