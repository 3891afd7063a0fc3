"""Rows of a measured record that seem to be no measurements: marks of missing values, spikes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

LEAST_NINES = 3
"""Of a mark, as -9999 or 999.9."""
BEYOND = 2.0
"""Magnitude of a mark, over the largest of the other values, at least."""
BESIDE = 2
"""Rows on each side of one, of whose median a spike is far."""
OF_SPREAD, OF_USUAL, OF_ALL = 5.0, 20.0, 1.0
"""Distance of a spike from that median, at least: over the spread of the rows around, over the
median of all such distances, over the standard deviation of all values."""
REMEDY = "they count as measured; if they are not, leave their entries empty"


def doubts(time: NDArray[np.float64], values: NDArray[np.float64], unit: str) -> Iterator[str]:
    """Sentences on rows of `values` (n,) [`unit`] at `time` (n,) [s] that may be no measurements.

    Values that are not finite are gaps, of which nothing is told here.
    """
    known = np.isfinite(values)
    t, x = time[known], values[known]
    marked = _marks(x)
    for value in np.unique(x[marked]).tolist():
        rows = t[x == value]
        yield (
            f"{_rows(len(rows))} {value:g} {unit}, the first at {rows[0]:g} s, as marks of missing "
            f"values are: {REMEDY}"
        )
    t, x = t[~marked], x[~marked]
    far = _spikes(x)
    if far.any():
        k = int(np.flatnonzero(far)[0])
        yield (
            f"{_rows(int(np.sum(far)))} far from those beside, the first at {t[k]:g} s "
            f"({x[k]:g} {unit}), as spikes are: {REMEDY}"
        )


def _rows(count: int) -> str:
    return f"{count} row{'s are' if count > 1 else ' is'}"


def _marks(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """True of `values` (n,) whose digits are nines, far beyond all others."""
    large = np.unique(values[np.abs(values) > np.median(np.abs(values))]) if len(values) else values
    nines = np.isin(values, [value for value in large.tolist() if _has_nines(value)])
    others = np.abs(values[~nines])
    if not len(others):
        return np.zeros(len(values), bool)
    return nines & (np.abs(values) > BEYOND * others.max())


def _has_nines(value: float) -> bool:
    digits = f"{abs(value):g}".replace(".", "")
    return len(digits) >= LEAST_NINES and {*digits} == {"9"}


def _spikes(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """True of `values` (n,) that are far from the median of the rows around them."""
    if len(values) <= 4 * BESIDE:
        return np.zeros(len(values), bool)
    padded = np.pad(values, BESIDE, mode="reflect")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * BESIDE + 1)
    around = np.sort(around, axis=1)
    spread = np.minimum(around[:, -2] - around[:, 0], around[:, -1] - around[:, 1])
    away = np.abs(values - around[:, BESIDE])
    beyond = max(OF_USUAL * float(np.median(away)), OF_ALL * float(np.std(values)))
    return (away > OF_SPREAD * spread) & (away > beyond)
