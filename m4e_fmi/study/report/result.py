"""`StudyResult`: dimensions, quantities and failures of a study, read from its result file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import InputError, is_file, missing_file
from m4e_fmi.study.report.record import StudyRecord, record_of
from m4e_fmi.study.report.series import StudySeries, series_of, unit_of
from m4e_fmi.study.shown.averages import means_of_designs
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import xarray

OF_RUNS = ("coupling_error", "wall_time", "start_up")
"""Numbers that every result has of each run."""


@dataclass(frozen=True)
class Column:
    """A varied quantity: its `values` (n,) along a dimension, in its `unit` (or texts)."""

    name: str
    unit: str
    text: str
    values: np.ndarray = field(repr=False)

    @property
    def is_number(self) -> bool:
        """False for texts and truth values."""
        return self.values.dtype.kind in "iuf"

    @property
    def labels(self) -> list[str]:
        """Texts of the values, with six digits."""
        return [f"{x:.6g}" if isinstance(x, float) else str(x) for x in self.values.tolist()]


@dataclass(frozen=True)
class Dimension:
    """A dimension of `count` points; each has a value of every one of the `columns`.

    `repeats` are runs of one design with other seeds.
    """

    name: str
    count: int
    columns: tuple[Column, ...]
    repeats: bool

    @property
    def is_grid(self) -> bool:
        """True if one quantity is varied along it; else its points are samples or cases."""
        return len(self.columns) == 1

    @property
    def labels(self) -> list[str]:
        """Texts of the points, numbers from 1 of samples and cases."""
        return self.columns[0].labels if self.is_grid else [str(k + 1) for k in range(self.count)]


@dataclass(frozen=True)
class Designs:
    """Means over seeds: `mean`, `half_width` (…) in the unit of the values, `missing` (…) [1]."""

    mean: np.ndarray
    half_width: np.ndarray
    missing: np.ndarray


@dataclass(frozen=True)
class StudyResult:
    """A result of a study: `numbers` by name (the shape of the dimensions), in their `units`.

    `failure` has the reason of each run that failed, "" of the others; `is_run` is False of what
    has no probability and was not run (both the shape of the dimensions). `probability` has the
    names of its dimensions and shares [1], None without.
    """

    path: Path
    attributes: Mapping[str, str] = field(repr=False)
    record: StudyRecord = field(repr=False)
    dimensions: tuple[Dimension, ...]
    numbers: Mapping[str, np.ndarray] = field(repr=False)
    units: Mapping[str, str]
    failure: np.ndarray = field(repr=False)
    is_run: np.ndarray = field(repr=False)
    probability: tuple[tuple[str, ...], np.ndarray] | None = field(default=None, repr=False)
    series: StudySeries | None = field(default=None, repr=False)

    @property
    def shape(self) -> tuple[int, ...]:
        """Points of each dimension."""
        return tuple(one.count for one in self.dimensions)

    @property
    def size(self) -> int:
        """Number of points, those which were not run among them."""
        return math.prod(self.shape)

    @property
    def count(self) -> int:
        """Number of runs."""
        return int(self.is_run.sum())

    @property
    def failed(self) -> np.ndarray:
        """Numbers (n_failed,) [1] of the runs that failed, from 0."""
        return np.flatnonzero(self.failure.reshape(-1) != "")

    @property
    def design_dimensions(self) -> tuple[Dimension, ...]:
        """Dimensions without those of seeds."""
        return tuple(one for one in self.dimensions if not one.repeats)

    def attribute(self, name: str) -> str:
        """A text that the file carries; "" without."""
        return self.attributes.get(name, "")

    def by_seeds(self, values: np.ndarray) -> np.ndarray:
        """The `values` (n, …) of all runs [their unit], as (…, n_seeds) of each design."""
        repeats = [k for k, one in enumerate(self.dimensions) if one.repeats]
        rest = [k for k in range(len(self.dimensions)) if k not in repeats]
        designs = tuple(self.shape[k] for k in rest)
        return values.transpose((*rest, *repeats)).reshape((*designs, -1))

    def designs(self, name: str) -> Designs:
        """Means of a quantity over seeds, with 95 % confidence."""
        mean, width, missing = means_of_designs(self.by_seeds(self.numbers[name]))
        return Designs(mean, width, np.where(self.by_seeds(self.is_run).any(axis=-1), missing, 0))

    def label(self, run: int) -> str:
        """The run in words, as ``peak_period 7.5, seed 2``."""
        places = np.unravel_index(run, self.shape) if self.shape else ()
        parts = [
            f"{one.name} {one.labels[int(k)]}"
            for one, k in zip(self.dimensions, places, strict=True)
        ]
        return ", ".join(parts) or "the run"


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
            return _of(path, data, record)
    except (OSError, ValueError, KeyError) as error:
        message = f"it is no netCDF file of a study, or is damaged: {error}"
        raise InputError.single(message, "run the study again", str(path)) from error


def _of(path: Path, data: xarray.Dataset, record: StudyRecord) -> StudyResult:
    names = [str(name) for name in data["failure"].dims]
    wanted = [*record.wanted, *OF_RUNS]
    shape = data["failure"].shape
    probability = None
    if "probability" in data:
        one = data["probability"]
        probability = tuple(map(str, one.dims)), one.values
    return StudyResult(
        path=path,
        attributes={str(name): str(value) for name, value in data.attrs.items()},
        record=record,
        dimensions=tuple(_dimensions(data, names, record.repeats)),
        numbers={name: data[name].values.astype(float).reshape(shape) for name in wanted},
        units={name: unit_of(data[name]) for name in wanted},
        failure=data["failure"].values.astype(str).astype(object).reshape(shape),
        is_run=data["is_run"].values.astype(bool) if "is_run" in data else np.ones(shape, bool),
        probability=probability,
        series=series_of(data, record.series, math.prod(shape)),
    )


def _dimensions(
    data: xarray.Dataset, names: Sequence[str], repeats: Sequence[str]
) -> Iterator[Dimension]:
    for name in names:
        found = [str(c) for c in data.coords if data[c].dims == (name,)]
        chosen = [c for c in found if c != name] or found
        columns = tuple(
            Column(c, unit_of(data[c]), str(data[c].attrs.get("long_name", "")), data[c].values)
            for c in chosen
        )
        yield Dimension(name, data.sizes[name], columns, name in repeats)
