"""One number of each design over all sea states or cases, with their probabilities."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.panels import aligned, scale_of
from m4e_fmi.statistics.confidence import confidence_interval
from m4e_fmi.study.given.grid import Axis, Grid
from m4e_fmi.study.given.study import Wanted

if TYPE_CHECKING:
    from xarray import Dataset

LARGEST = {
    "maximum",
    "range",
    "largest_magnitude",
    "most_probable_maximum",
    "expected_maximum",
    "maximum_quantile",
}
"""Statistics of which the largest of all states is meant, and no mean over them."""
YEAR = 8766.0 * 3600.0
"""Mean year of 365.25 days [s]."""
MEGAWATT_HOUR = 3.6e9
"""In joules."""
POWERS = {"W": 1.0, "kW": 1e3, "MW": 1e6}
"""Units of power, in watts."""
NOT_RUN = "–"
"""In cells of what is not run."""
SCALED = ("W", "N", "J", "Pa")
"""Units that get a prefix, alone or as the first of a product, as in N.m."""
NO_MEAN = {*LARGEST, "minimum", "damage_equivalent_load", "rms"}
"""Statistics of which the mean by probability does not tell that of all states."""


@dataclass(frozen=True)
class Averaged:
    """Values over the axes that are no repeats: `mean` over seeds and `half_width`, (…) each.

    Both are in the unit of the values. `missing` (…) counts [1] the failed seeds of a design, whose
    mean is over the others; designs that are not run have no mean and miss none.
    """

    axes: tuple[Axis, ...]
    mean: np.ndarray
    half_width: np.ndarray
    missing: np.ndarray

    def scaled(self, factor: float) -> Averaged:
        """The same in a unit that is 1/`factor` of theirs."""
        return Averaged(self.axes, factor * self.mean, factor * self.half_width, self.missing)

    @property
    def largest(self) -> float:
        """The largest magnitude of the means, in their unit; 0 without any."""
        return float(np.abs(self.mean[np.isfinite(self.mean)]).max(initial=0.0))

    def cell(self, place: tuple[int, ...]) -> str:
        """The mean at a place with its half-width, as text; * if some seeds of it failed."""
        mean, width = float(self.mean[place]), float(self.half_width[place])
        if math.isnan(mean):
            return "failed" if self.missing[place] else NOT_RUN
        mark = "*" if self.missing[place] else ""
        if math.isnan(width):
            return f"{aligned(mean)[0]}{mark}"
        text, spread = aligned(mean, width)
        return f"{text} ± {spread}{mark}"

    def led_by(self, names: tuple[str, ...]) -> Averaged:
        """The same with the axes `names` in front."""
        axes = [axis.name for axis in self.axes]
        order = [*map(axes.index, names), *(k for k, axis in enumerate(axes) if axis not in names)]
        return Averaged(
            tuple(self.axes[k] for k in order),
            self.mean.transpose(order),
            self.half_width.transpose(order),
            self.missing.transpose(order),
        )


def shown_unit(found: Averaged, unit: str) -> tuple[float, str]:
    """The factor of the means, in their `unit`, by which they are shown, and their unit then."""
    scale, prefix = scale_of(found.largest) if re.split("[./]", unit)[0] in SCALED else (1.0, "")
    return scale, "" if unit == "1" else prefix + unit


def averaged(
    axes: tuple[Axis, ...], values: np.ndarray, is_run: np.ndarray | None = None
) -> Averaged:
    """Means over seeds of `values` (n, …) [their unit], with 95 % confidence by Student's t.

    The half-width is nan for one seed. Values that are nan are missing; means are over the others.
    The values have the shape of the axes, as has `is_run` (n, …) [1]: False of what is not run.
    """
    repeats = [k for k, axis in enumerate(axes) if axis.repeats]
    designs = tuple(axis for axis in axes if not axis.repeats)
    count = math.prod(len(axes[k]) for k in repeats)
    rest = [k for k in range(len(axes)) if k not in repeats]
    shape = (*(len(axis) for axis in designs), count)
    values = values.transpose((*rest, *repeats)).reshape(shape)
    missing = np.isnan(values).sum(axis=-1)
    mean, width = np.full(missing.shape, np.nan), np.full(missing.shape, np.nan)
    for lacking in np.unique(missing):
        left = values.shape[-1] - int(lacking)
        if not left:
            continue
        alike = missing == lacking
        rows = values[alike]
        interval = confidence_interval(rows[~np.isnan(rows)].reshape(-1, left))
        mean[alike], width[alike] = interval.mean, interval.half_width
    if is_run is not None:
        some = is_run.transpose((*rest, *repeats)).reshape(shape).any(axis=-1)
        missing = np.where(some, missing, 0)
    return Averaged(designs, mean, width, missing)


@dataclass(frozen=True)
class States:
    """The sea states or cases of a study: the dimensions `names`, and their `shares` (…) [1]."""

    names: tuple[str, ...]
    shares: np.ndarray

    def last(self, axes: tuple[Axis, ...], values: np.ndarray) -> np.ndarray:
        """`values` (n, …) [their unit] of `axes`, with the states that occur as the last axis."""
        names = [axis.name for axis in axes]
        places = [names.index(name) for name in self.names]
        moved = np.moveaxis(values, places, range(-len(places), 0))
        rows = moved.reshape((*moved.shape[: -len(places)], -1))
        return rows[..., self.shares.ravel() > 0.0]

    def rest(self, axes: tuple[Axis, ...]) -> tuple[Axis, ...]:
        """Those of the axes that are none of states: designs and seeds."""
        return tuple(axis for axis in axes if axis.name not in self.names)

    @property
    def weights(self) -> np.ndarray:
        """Shares (n,) [1] of the states that occur, with a sum of 1."""
        positive = self.shares[self.shares > 0.0]
        return positive / positive.sum()


def states_of(data: Dataset) -> States | None:
    """The sea states or cases of a result; None if it has no probabilities."""
    if "probability" not in data:
        return None
    one = data["probability"]
    return States(tuple(map(str, one.dims)), one.values)


def over_states(
    grid: Grid, values: np.ndarray, states: States, wanted: Wanted, unit: str
) -> list[tuple[str, str, Averaged]]:
    """Names, units and values over the designs of what is told of all states.

    Of mean powers the energy of a year follows, in MWh; `values` (n, …) [`unit`] have the shape of
    the grid.
    """
    name, over_all = _over_states(grid, values, states, wanted)
    found = [(name, unit, over_all)]
    if is_power(wanted, unit):
        energy = over_all.scaled(float(states.shares.sum()) * POWERS[unit] * YEAR / MEGAWATT_HOUR)
        found.append(("energy of a year of 8766 h", "MWh", energy))
    return found


def is_power(wanted: Wanted, unit: str) -> bool:
    """True for mean powers: their sums over states are energies."""
    return wanted.statistic == "mean" and unit in POWERS


def _over_states(
    grid: Grid, values: np.ndarray, states: States, wanted: Wanted
) -> tuple[str, Averaged]:
    """The name of what is told of all states, and its values over the designs.

    `values` (n, …), in their unit, have the shape of the grid. Extremes: the largest, or smallest,
    of the means over seeds. Loads that do the same damage: (Σ p xᵏ)^(1/k), with the exponent k of
    the S-N curve. Roots of mean squares: k = 2. All else: the mean Σ p x. Of the latter three the
    interval is that of the sums of each seed, as seeds are the same in all states. For a seed that
    failed in a state stands the mean of the others there; then there is no interval.
    """
    if wanted.statistic in LARGEST:
        return "largest of all states", _extreme(grid, values, states, 1.0)
    if wanted.statistic == "minimum":
        return "smallest of all states", _extreme(grid, values, states, -1.0)
    name, exponent = "mean by probability", 1.0
    if wanted.statistic == "damage_equivalent_load":
        name, exponent = "damage equivalent by probability", dict(wanted.parameters)["exponent"]
    elif wanted.statistic == "rms":
        name, exponent = "rms by probability", 2.0
    rows = states.last(grid.axes, _filled(grid, values))
    sums = rows @ states.weights
    if exponent != 1.0:
        top = np.maximum(np.abs(rows).max(axis=-1), np.finfo(float).tiny)  # powers may overflow
        sums = top * ((rows / top[..., None]) ** exponent @ states.weights) ** (1.0 / exponent)
    found = averaged(states.rest(grid.axes), sums)
    lost = np.isnan(states.last(grid.axes, values)).any(axis=-1)
    missing = averaged(states.rest(grid.axes), np.where(lost, np.nan, 0.0)).missing
    width = np.where(missing > 0, np.nan, found.half_width)
    return name, replace(found, half_width=width, missing=missing)


def _filled(grid: Grid, values: np.ndarray) -> np.ndarray:
    """`values` (n, …) [their unit] with the mean over the other seeds where one failed."""
    repeats = tuple(k for k, axis in enumerate(grid.axes) if axis.repeats)
    count = np.isfinite(values).sum(axis=repeats, keepdims=True)
    total = np.nansum(values, axis=repeats, keepdims=True)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return np.where(np.isnan(values), mean, values)


def _extreme(grid: Grid, values: np.ndarray, states: States, sign: float) -> Averaged:
    found = averaged(grid.axes, values)
    mean, width, missing = (
        states.last(found.axes, one) for one in (found.mean, found.half_width, found.missing)
    )
    at = np.argmax(sign * mean, axis=-1)[..., None]  # the first nan, if there is one
    mean, width, missing = (np.take_along_axis(x, at, -1)[..., 0] for x in (mean, width, missing))
    return Averaged(states.rest(found.axes), mean, width, missing)
