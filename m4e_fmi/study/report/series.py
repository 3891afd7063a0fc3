"""Whole series of the runs of a study, as many as a page takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray

MOST_CURVES = 2_000
"""Series in a page: each is a block of its own."""
MOST_NUMBERS = 20_000_000
"""Numbers of all series in a page: of Float32, 100 MB as text."""
DENSER = 2
"""Rows at even times, of runs with rows of their own, over the rows of the longest run."""


@dataclass(frozen=True)
class StudySeries:
    """Series of some `runs` (m,), numbers from 0, at `time` (n,) [s].

    `values` (m, n) by variable have their unit of `units`; nan behind the end of a run. `all_runs`
    counts the runs that have series [1]; `evenly` is True if values are linear between the rows of
    each run, at even times.
    """

    time: np.ndarray = field(repr=False)
    runs: np.ndarray = field(repr=False)
    values: dict[str, np.ndarray] = field(repr=False)
    units: dict[str, str]
    texts: dict[str, str]
    all_runs: int
    evenly: bool


def series_of(data: xarray.Dataset, names: tuple[str, ...], count: int) -> StudySeries | None:
    """The series `names` of `count` runs; None if there are none.

    Of more runs than a page takes, those at even distances.
    """
    there = [name for name in names if name in data]
    if not there or "time" not in data:
        return None
    first = data[there[0]].values.reshape(count, -1)
    good = np.flatnonzero(np.isfinite(first).sum(axis=1) > 1)
    rows = first.shape[1] * (1 if data["time"].ndim == 1 else DENSER)
    most = max(1, min(MOST_CURVES, MOST_NUMBERS // rows) // len(there))
    runs = good if len(good) <= most else good[np.linspace(0, len(good) - 1, most).astype(int)]
    if not len(runs):
        return None
    values = {name: data[name].values.reshape(count, -1)[runs].astype(float) for name in there}
    time, evenly = data["time"].values.astype(float), data["time"].ndim > 1
    if evenly:
        own = time.reshape(count, -1)[runs]
        time = np.linspace(np.nanmin(own), np.nanmax(own), rows)
        values = {name: _between(time, own, found) for name, found in values.items()}
    return StudySeries(
        time=time,
        runs=runs,
        values=values,
        units={name: unit_of(data[name]) for name in there},
        texts={name: str(data[name].attrs.get("long_name", "")) for name in there},
        all_runs=len(good),
        evenly=evenly,
    )


def _between(time: np.ndarray, own: np.ndarray, values: np.ndarray) -> np.ndarray:
    """`values` (m, k) at times `own` (m, k) [s], linear between them at `time` (n,) [s]."""
    found = np.full((len(values), len(time)), np.nan)
    for row, at, known in zip(found, own, values, strict=True):
        there = np.isfinite(at)
        row[:] = np.interp(time, at[there], known[there], left=np.nan, right=np.nan)
    return found


def unit_of(one: xarray.DataArray) -> str:
    """Unit of a variable; "" of numbers without."""
    unit = str(one.attrs.get("units", ""))
    return "" if unit == "1" else unit
