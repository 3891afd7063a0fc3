"""`StudyResult`: grid, quantities and failures of a study, read from its result file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import InputError, is_file, missing_file
from m4e_fmi.study.given.grid import Axis, Grid, Shares, Varied
from m4e_fmi.study.report.record import StudyRecord, record_of
from m4e_fmi.study.shown.over_states import (
    POWERS,
    Averaged,
    States,
    averaged,
    is_power,
    states_of,
)
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import xarray

MOST_CURVES = 2_000
"""Series in a page: each is a block of its own."""
MOST_NUMBERS = 20_000_000
"""Numbers of all series in a page: of Float32, 100 MB as text."""


@dataclass(frozen=True)
class StudySeries:
    """Series of some `runs` (m,), numbers from 0, at `time` (n,) [s].

    `values` (m, n) by variable have their unit of `units`; nan behind the end of a run. `all_runs`
    counts the runs that have series [1].
    """

    time: np.ndarray = field(repr=False)
    runs: np.ndarray = field(repr=False)
    values: dict[str, np.ndarray] = field(repr=False)
    units: dict[str, str]
    texts: dict[str, str]
    all_runs: int


def series_of(data: xarray.Dataset, names: tuple[str, ...], count: int) -> StudySeries | None:
    """The series `names` of `count` runs; None if there are none, or rows at times of their own.

    Of more runs than a page takes, those at even distances.
    """
    there = [name for name in names if name in data]
    if not there or data["time"].ndim > 1:
        return None
    first = data[there[0]].values.reshape(count, -1)
    good = np.flatnonzero(np.isfinite(first).sum(axis=1) > 1)
    most = max(1, min(MOST_CURVES, MOST_NUMBERS // first.shape[1]) // len(there))
    runs = good if len(good) <= most else good[np.linspace(0, len(good) - 1, most).astype(int)]
    if not len(runs):
        return None
    values = {name: data[name].values.reshape(count, -1)[runs].astype(float) for name in there}
    return StudySeries(
        time=data["time"].values.astype(float),
        runs=runs,
        values=values,
        units={name: unit_of(data[name]) for name in there},
        texts={name: str(data[name].attrs.get("long_name", "")) for name in there},
        all_runs=len(good),
    )


def unit_of(one: xarray.DataArray) -> str:
    """Unit of a variable; "" of numbers without."""
    unit = str(one.attrs.get("units", ""))
    return "" if unit == "1" else unit


OF_RUNS = ("coupling_error", "wall_time", "start_up")
"""Numbers that every result has of each run."""
WAVE_POWER = "wave_power"
"""Power of the waves of each run [W/m]: of results of systems in waves."""
GIVEN_OFF = re.compile(r"(.+\.)?load\.\w+\.power")
"""Powers of loads of a model: what they take is negative."""


@dataclass(frozen=True)
class StudyResult:
    """A result of a study: `numbers` by name (the shape of the grid), in their `units`.

    `quantities` are those that were wanted and capture widths, by name, in words.
    `labels` are unit and description of varied quantities. `failure` has the reason of each run
    that failed, "" of the others (the shape of the grid). `states` have probabilities, None
    without.
    """

    path: Path
    attributes: Mapping[str, str] = field(repr=False)
    record: StudyRecord = field(repr=False)
    grid: Grid
    quantities: Mapping[str, str]
    labels: Mapping[str, tuple[str, str]]
    numbers: Mapping[str, np.ndarray] = field(repr=False)
    units: Mapping[str, str]
    failure: np.ndarray = field(repr=False)
    states: States | None = field(default=None, repr=False)
    series: StudySeries | None = field(default=None, repr=False)

    @property
    def failed(self) -> np.ndarray:
        """Numbers (n_failed,) [1] of the runs that failed, from 0."""
        return np.flatnonzero(self.failure.reshape(-1) != "")

    def attribute(self, name: str) -> str:
        """A text that the file carries; "" without."""
        return self.attributes.get(name, "")

    def label(self, run: int) -> str:
        """A run in words, with units."""
        places = zip(self.grid.axes, self.grid.place(run), strict=True)
        return ", ".join(self.point(one, k) for one, k in places) or "the run"

    def point(self, axis: Axis, k: int) -> str:
        """Point number `k` of a dimension in words, with its unit."""
        unit = self.labels[axis.varied[0].name][0] if len(axis.varied) == 1 else ""
        return f"{axis.name} {axis.labels[k]} {unit}".rstrip()

    def designs(self, name: str) -> Averaged:
        """Means of a quantity over seeds, with 95 % confidence."""
        return averaged(self.grid.axes, self.numbers[name], self.grid.is_run)


def load_study_result(path: Path) -> StudyResult:
    """The result of a study in a netCDF file.

    InputError for a file that is missing or damaged, or is no result of a study.
    """
    import xarray

    if not is_file(path):
        raise InputError.single(*missing_file(path), str(path))
    try:
        with (
            PROCESS,
            xarray.open_dataset(
                path, engine="netcdf4", decode_times=False, decode_timedelta=False, cache=False
            ) as data,
        ):
            record = record_of(data.attrs, str(path))
            names = [str(name) for name in data["failure"].dims]
            of_runs = [*OF_RUNS, *([WAVE_POWER] if WAVE_POWER in data else [])]
            wanted = [*record.wanted, *of_runs]
            shape = data["failure"].shape
            run = data["is_run"].values.astype(float) if "is_run" in data else np.ones(shape)
            axes = tuple(_axis(data, name, repeats=name in record.repeats) for name in names)
            numbers = {name: data[name].values.astype(float).reshape(shape) for name in wanted}
            units = {name: unit_of(data[name]) for name in wanted}
            quantities = {name: str(told) for name, told in record.wanted.items()}
            for name, one in record.wanted.items() if WAVE_POWER in data else ():
                if is_power(one, units[name]) and (width := f"capture width, {name}") not in units:
                    sign = -1.0 if GIVEN_OFF.fullmatch(one.variable) else 1.0
                    power = sign * POWERS[units[name]] * numbers[name]
                    with np.errstate(divide="ignore", invalid="ignore"):
                        numbers[width], units[width] = power / numbers[WAVE_POWER], "m"
                    quantities[width] = f"{name} over the {data[WAVE_POWER].attrs['long_name']}"
            return StudyResult(
                path=path,
                attributes={str(name): str(value) for name, value in data.attrs.items()},
                record=record,
                grid=Grid(axes, (Shares(tuple(names), run),)),
                labels={
                    str(name): (unit_of(one), str(one.attrs.get("long_name", "")))
                    for name, one in data.coords.items()
                },
                numbers=numbers,
                units=units,
                quantities=quantities,
                failure=data["failure"].values.astype(str).astype(object).reshape(shape),
                states=states_of(data),
                series=series_of(data, record.series, math.prod(shape)),
            )
    except (OSError, ValueError, KeyError) as error:
        message = f"it is no netCDF file of a study, or is damaged: {error}"
        raise InputError.single(message, "run the study again", str(path)) from error


def _axis(data: xarray.Dataset, name: str, *, repeats: bool) -> Axis:
    """A dimension of the file; the numbers of samples and cases are no quantity of them."""
    found = [str(c) for c in data.coords if data[c].dims == (name,)]
    chosen = [c for c in found if c != name] or found
    points = zip(*(data[c].values.tolist() for c in chosen), strict=True)
    return Axis(name, tuple(Varied(c, (c,)) for c in chosen), tuple(points), repeats=repeats)
