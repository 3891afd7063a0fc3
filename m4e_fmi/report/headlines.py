"""Headline figures of results: the few numbers that a person asks for first.

Of a system in water mean power, capture width, line tension, offset and stroke; of a mechanism
energy, range of motion and period; of anything else the ranges of what moves.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.report.animation.scene import Water
from m4e_fmi.report.animation.scene_text import scene_of_text
from m4e_fmi.report.panels import aligned, fitting, moving, panels, quantity, scale_of
from m4e_fmi.results.results_file import Results, Series
from m4e_fmi.results.series import SCENE
from m4e_fmi.shown import first_of
from m4e_fmi.statistics.cycles import zero_crossing_period
from m4e_fmi.statistics.record import UndefinedError
from m4e_fmi.units import BASE_UNITS, parse_unit

MOST = 3
"""Variables of one kind that are named."""
_COORDINATE = re.compile(r"(?:.+\.)?joint\.(\w+)\.q\w*")
_EXCURSIONS = (
    ("largest offset", "m", 1.0, ("surge", "sway")),
    ("largest tilt", "deg", 180.0 / math.pi, ("pitch", "roll")),
)
"""From the reference pose: name, unit, its number in SI, motions."""
_PLACE = re.compile(r"(?:.+\.)?body\.\w+\.(?:[xyz]|phi|theta|psi)")
PREFIXED = ("m", "N", "N.m", "W", "J")
"""Units that are shown with prefixes."""


@dataclass(frozen=True)
class Headline:
    """A figure: its `name`, its `value` with unit, and in `detail` of what, and when."""

    name: str
    value: str
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.name} {self.value}" + (f" ({self.detail})" if self.detail else "")


def headlines(results: Results) -> list[Headline]:
    """The figures of `results`, the most wanted first; none of results without rows."""
    if not len(results.time):
        return []
    components = results.components
    named = next(iter(components.values())) if len(components) == 1 else results.series
    series = {name: one for name, one in named.items() if one.recorded.is_real}
    water, time = _water(results), results.time
    absorbers = _absorbers(series, water)
    found = [*_powers(absorbers, time, water), *_tensions(series, time)]
    if found:
        strokes = [*_strokes(series, absorbers)] or (_motions(series, time) if absorbers else [])
        return [*found, *_excursions(series), *strokes]
    return [*_energy(series), *_motions(series, time)] or _ranges(series)


def _water(results: Results) -> Water | None:
    """The water of the results' scene; None without one, or if it is damaged."""
    try:
        return scene_of_text(results.attributes[SCENE]).water
    except (KeyError, InputError):
        return None


def _absorbers(series: Mapping[str, Series], water: Water | None) -> dict[str, np.ndarray]:
    """Powers (n,) [W] that are absorbed, by owner.

    Those of components; without them, in waves, of a model's dampers on a line or a joint.
    """
    owners = {
        name.removesuffix(".power"): one
        for name, one in series.items()
        if name.endswith(".power") and watts(one.unit)
    }
    found = {n: watts(one.unit) * one.values for n, one in owners.items() if one.name == "power"}
    if found or not (water and water.trains):
        return found
    rates = ("distance_rate", "twist_rate")
    return {
        owner: -one.values
        for owner, one in owners.items()
        if np.mean(one.values) < 0.0 and any(f"{owner}.{rate}" in series for rate in rates)
    }


def _powers(
    absorbers: Mapping[str, np.ndarray], time: np.ndarray, water: Water | None
) -> Iterator[Headline]:
    """Mean and energy of the power that is absorbed, and the capture width."""
    span = float(time[-1] - time[0])
    whole = float(sum(np.trapezoid(one, time) for one in absorbers.values()))
    if not absorbers or not span:
        return
    detail = f"{first_of(absorbers, MOST)}, {quantity(whole, 'J')} over {span:g} s"
    if water and (ramp := max((train.ramp for train in water.trains), default=0.0)):
        detail += f" with a ramp of {ramp:g} s"
    yield Headline("mean power", quantity(whole / span, "W"), detail)
    if water and (incident := water.energy_flux(time)):
        detail = f"in waves of {quantity(incident, 'W')}/m"
        yield Headline("capture width", f"{whole / span / incident:.3g} m", detail)


def _tensions(series: Mapping[str, Series], time: np.ndarray) -> Iterator[Headline]:
    """The largest tension of a line."""
    lines = {n: one for n, one in series.items() if one.name.endswith("fairlead_tension")}
    if not lines:
        return
    name = max(lines, key=lambda n: float(np.max(lines[n].values)))
    values = lines[name].values
    at = int(np.argmax(values))
    line = name.removesuffix(".fairlead_tension")
    yield Headline(
        "largest line tension", quantity(float(values[at]), "N"), f"{line}, at {time[at]:.4g} s"
    )


def _excursions(series: Mapping[str, Series]) -> Iterator[Headline]:
    """The largest horizontal way and the largest tilt of bodies in water."""
    for name, unit, scale, (first, second) in _EXCURSIONS:
        sizes = {}
        for at, one in series.items():
            if one.name.endswith(f".{first}"):
                body = at.removesuffix(f".{first}")
                beside = series[f"{body}.{second}"].values if f"{body}.{second}" in series else 0.0
                sizes[body] = scale * float(np.max(np.hypot(one.values, beside)))
        if sizes:
            body = max(sizes, key=lambda n: sizes[n])
            yield Headline(name, f"{aligned(sizes[body])[0]} {unit}", body)


def _strokes(series: Mapping[str, Series], absorbers: Iterable[str]) -> Iterator[Headline]:
    """The stroke of what absorbs power, or its angle: the largest of several."""
    names = (f"{owner}.{way}" for owner in absorbers for way in ("extension", "distance", "twist"))
    found = [name for name in names if name in series]
    if found:
        name = max(found, key=lambda n: float(np.ptp(series[n].values)))
        yield replace(_range(name, series[name]), name="stroke", detail=name.rpartition(".")[0])


def _energy(series: Mapping[str, Series]) -> list[Headline]:
    """Kinetic and potential energy of each model, at the end and at the start."""
    found = []
    for name, one in series.items():
        if name.endswith("energy.total"):
            start, end = (quantity(float(x), "J") for x in one.values[[0, -1]])
            owner = name.removesuffix(".energy.total")
            text = f"energy of {owner}" if owner != name else "energy"
            found.append(Headline(text, end, f"at the end; {start} at the start"))
    return found[:MOST]


def _motions(series: Mapping[str, Series], time: np.ndarray) -> list[Headline]:
    """Ranges of the coordinates that move most, and the period of the first of them."""
    found = {n: one for n, one in series.items() if _COORDINATE.fullmatch(one.name)}
    found = found or {n: one for n, one in series.items() if _PLACE.fullmatch(one.name)}
    first = sorted(found, key=lambda n: -float(np.ptp(found[n].values)))[:MOST]
    ranges = [_range(name, one) for name, one in found.items() if name in first]
    with suppress(UndefinedError, IndexError):
        period = zero_crossing_period(time, found[first[0]].values)
        ranges.append(Headline("mean period", f"{period:.4g} s", first[0]))
    return ranges


def _ranges(series: dict[str, Series]) -> list[Headline]:
    """Ranges of the first variables that move."""
    shown = map(fitting, moving(panels(series)))
    return [_range(name, one) for panel in shown for name, one in panel.series.items()][:MOST]


def _range(name: str, one: Series) -> Headline:
    """The smallest and the largest value, angles in degrees, others in multiples of their units."""
    low, high = float(np.min(one.values)), float(np.max(one.values))
    scale, prefix = scale_of(max(abs(low), abs(high)))
    unit = f"{prefix}{one.unit}"
    if one.unit == "rad":
        scale, unit = 180.0 / math.pi, "deg"
    elif one.unit not in PREFIXED:
        scale, unit = 1.0, one.unit
    shown = " to ".join(aligned(scale * low, scale * high))
    return Headline(name, shown if unit == "1" else f"{shown} {unit}".rstrip())


@cache
def watts(unit: str) -> float:
    """Watts of a unit of power; 0 for any other unit."""
    try:
        found, watt = parse_unit(unit), parse_unit("W")
    except ValueError:
        return 0.0
    angles = BASE_UNITS.index("rad")
    ours, theirs = (u.exponents[:angles] + u.exponents[angles + 1 :] for u in (found, watt))
    return found.factor if ours == theirs else 0.0
