"""Headline figures of results: the few numbers that a person asks for first.

Of a system in water mean power, capture width, line tension, safety factor, offset and stroke; of a
mechanism energy, range of motion and period; of anything else the ranges of what moves.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
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
    ("largest offset", "m", ("surge", "sway")),
    ("largest tilt", "deg", ("pitch", "roll")),
)
"""From the reference pose: name, unit, motions."""
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
    reals = {name: one for name, one in named.items() if one.recorded.is_real}
    series = {name: one for name, one in reals.items() if np.isfinite(one.values).all()}
    water, time = _water(results), results.time
    absorbers = _absorbers(series, water)
    found = [*_powers(absorbers, time, water), *_tensions(series, time)]
    if found:
        strokes = [*_strokes(series, absorbers)] or (_motions(series, time) if absorbers else [])
        found += [*_excursions(series), *strokes]
    else:
        found = [*_energy(series), *_motions(series, time)] or _ranges(series)
    unknown = first_of((name for name in reals if name not in series), MOST)
    return [*found, Headline("not finite", unknown)] if unknown else found


def _water(results: Results) -> Water | None:
    """The water of the results' scene; None without one, or if it is damaged."""
    try:
        return scene_of_text(results.attributes[SCENE]).water
    except (KeyError, InputError):
        return None


def _absorbers(series: Mapping[str, Series], water: Water | None) -> dict[str, np.ndarray]:
    """Powers (n,) [W] by owner: those of components, which count what they absorb.

    Without them, in waves, those that a model's dampers on a line or a joint absorb.
    """
    owners = {
        name.removesuffix("power").rstrip("."): (one.name, power)
        for name, one in series.items()
        if name.rpartition(".")[2] == "power" and (power := _in(one, "W")) is not None
    }
    found = {owner: power for owner, (name, power) in owners.items() if name == "power"}
    if found or not (water and water.trains):
        return found
    rates = ("distance_rate", "twist_rate")
    return {
        owner: -power
        for owner, (_, power) in owners.items()
        if np.mean(power) < 0.0 and any(f"{owner}.{rate}" in series for rate in rates)
    }


def _powers(
    absorbers: Mapping[str, np.ndarray], time: np.ndarray, water: Water | None
) -> Iterator[Headline]:
    """Mean power: in waves of all take-offs together, with the capture width; else of each."""
    span = float(time[-1] - time[0])
    energies = {owner: float(np.trapezoid(one, time)) for owner, one in absorbers.items()}
    if not span:
        return
    if not (water and water.trains):
        for owner, energy in list(energies.items())[:MOST]:
            detail = f"{owner or 'power'}, {quantity(energy, 'J')} in {span:g} s"
            yield Headline("mean power", quantity(energy / span, "W"), detail)
    elif energies:
        whole = sum(energies.values())
        detail = f"{first_of(energies, MOST)}, {quantity(whole, 'J')} in {span:g} s"
        if ramp := max(train.ramp for train in water.trains):
            detail += f", ramp {ramp:g} s"
        yield Headline("mean power", quantity(whole / span, "W"), detail)
        if (incident := water.energy_flux(time)) and whole > 0.0:
            detail = f"of {quantity(incident, 'W')}/m"
            yield Headline("capture width", f"{whole / span / incident:.3g} m", detail)


def _tensions(series: Mapping[str, Series], time: np.ndarray) -> Iterator[Headline]:
    """The largest tension of a line, and the smallest safety factor: the line that breaks first."""
    lines = {
        name.removesuffix(".fairlead_tension"): tension
        for name, one in series.items()
        if one.name.endswith("fairlead_tension") and (tension := _in(one, "N")) is not None
    }
    if lines:
        line = max(lines, key=lambda n: float(np.max(lines[n])))
        at = int(np.argmax(lines[line]))
        value = quantity(float(lines[line][at]), "N")
        yield Headline("largest line tension", value, f"{line}, at {time[at]:.4g} s")
    factors = {n: one.values for n, one in series.items() if one.name.endswith(".safety_factor")}
    if factors:
        least = min(factors, key=lambda n: float(np.min(factors[n])))
        at, line = int(np.argmin(factors[least])), least.removesuffix(".safety_factor")
        value = f"{factors[least][at]:.3g}"
        yield Headline("smallest safety factor", value, f"{line}, at {time[at]:.4g} s")


def _excursions(series: Mapping[str, Series]) -> Iterator[Headline]:
    """The largest horizontal way and the largest tilt of bodies in water."""
    for name, unit, (first, second) in _EXCURSIONS:
        sizes = {}
        for at, one in series.items():
            body, _, motion = at.rpartition(".")
            if motion == first and (way := _in(one, unit)) is not None:
                other = series.get(f"{body}.{second}")
                beside = None if other is None else _in(other, unit)
                sizes[body] = float(np.max(np.hypot(way, 0.0 if beside is None else beside)))
        if sizes:
            body = max(sizes, key=lambda n: sizes[n])
            yield Headline(name, f"{aligned(sizes[body])[0]} {unit}", body)


def _strokes(series: Mapping[str, Series], absorbers: Iterable[str]) -> Iterator[Headline]:
    """The largest stroke of what absorbs power: how far its length changes."""
    strokes = {
        owner: float(np.ptp(length))
        for owner in absorbers
        for name in (f"{owner}.extension", f"{owner}.distance")
        if name in series and (length := _in(series[name], "m")) is not None
    }
    if strokes:
        owner = max(strokes, key=lambda n: strokes[n])
        yield Headline("stroke", quantity(strokes[owner], "m"), owner)


def _energy(series: Mapping[str, Series]) -> list[Headline]:
    """Kinetic and potential energy of each model, at the end and at the start."""
    found = []
    for name, one in series.items():
        if name.endswith("energy.total") and (energy := _in(one, "J")) is not None:
            start, end = (quantity(float(x), "J") for x in energy[[0, -1]])
            owner = name.removesuffix(".energy.total")
            text = f"energy of {owner}" if owner != name else "energy"
            found.append(Headline(text, end, f"at the end; {start} at the start"))
    return found[:MOST]


def _motions(series: Mapping[str, Series], time: np.ndarray) -> list[Headline]:
    """Ranges of the coordinates that move most, and the period of the first of them."""
    moved = {n: one for n, one in series.items() if np.min(one.values) < np.max(one.values)}
    found = {n: one for n, one in moved.items() if _COORDINATE.fullmatch(one.name)}
    found = found or {n: one for n, one in moved.items() if _PLACE.fullmatch(one.name)}
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


def _in(one: Series, unit: str) -> np.ndarray | None:
    """The values (n,) in `unit`; None if theirs is of another dimension. An angle counts as 1."""
    factor = _factor(one.unit, unit)
    return factor * one.values if factor else None


@cache
def _factor(unit: str, into: str) -> float:
    """The number of units `into` in one `unit`; 0 if it is of another dimension."""
    try:
        found, wanted = parse_unit(unit), parse_unit(into)
    except ValueError:
        return 0.0
    angles = BASE_UNITS.index("rad")
    ours, theirs = (u.exponents[:angles] + u.exponents[angles + 1 :] for u in (found, wanted))
    return found.factor / wanted.factor if ours == theirs else 0.0
