"""`Work`, the runs of a study as `run` needs them, and their result: one labelled data set."""

from __future__ import annotations

import csv
import platform
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import m4e_fmi
from m4e_fmi.files.writing import written
from m4e_fmi.report.run_report.record import InputFile
from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.record import Record
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import xarray

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of texts that spreadsheets take for formulas."""
OF_WAVES = "power of the waves per metre of crest, the sum of ρ g a² c_g/2 over their components"
Label = tuple[str, str]
"""Unit and description."""


@dataclass(frozen=True)
class Labels:
    """Units and descriptions of varied names and of variables that are wanted."""

    varied: Mapping[str, Label] = field(default_factory=dict)
    variables: Mapping[str, Label] = field(default_factory=dict)


Batch = Mapping[int, Record]
Make = Callable[[Sequence[int]], Generator[Batch]]


@dataclass(frozen=True)
class Work:
    """The runs of a `study`: the `keys` of what each follows from, and how they are made.

    Both have an entry for each point of the grid, "" and nan for those that are not run. `start_up`
    (n_points,) [s] is the time from which on rows count. `inputs` are files as they are before the
    first run. `records` makes the runs of some numbers.
    `rows` tells which rows statistics are of. `wave_power` (n_points,) [W/m] is that of the waves
    per metre of crest, in `water` of a depth and a density; empty if it is not known of any run.
    """

    study: Study
    keys: Sequence[str] = field(repr=False)
    start_up: Sequence[float] = field(repr=False)
    labels: Labels = field(repr=False)
    inputs: Sequence[InputFile] = field(repr=False)
    warnings: Mapping[str, int]
    notes: Sequence[str]
    records: Make = field(repr=False)
    rows: str
    wave_power: Sequence[float] = field(default=(), repr=False)
    water: str = ""


def rows_text(intervals: Sequence[float | None]) -> str:
    """Where the rows of runs are, which have these intervals [s] between them (None: none)."""
    known = [one for one in intervals if one is not None]
    if not known:
        return "at all communication points"
    low, high = min(known), max(known)
    return f"every {low:g} s" if low == high else f"every {low:g} to {high:g} s"


def dataset(
    study: Study,
    records: Sequence[Record],
    labels: Labels,
    *,
    start_up: Sequence[float],
    attributes: Mapping[str, str],
    wave_power: Sequence[float] = (),
    water: str = "",
) -> xarray.Dataset:
    """One data set of all points of the grid; nan where a run failed, and where none is made.

    `records` are those of the points, in order; `start_up` (n_points,) [s] is the time from which
    on the rows of each run count; `wave_power` and `water` are those of `Work`.
    """
    import xarray

    grid, names = study.grid, [axis.name for axis in study.grid.axes]
    shape = grid.shape
    found = xarray.Dataset(
        {
            one.name: _variable(
                names,
                np.array([r.values.get(one.name, np.nan) for r in records]).reshape(shape),
                one.unit(labels.variables.get(one.variable, ("", ""))[0]),
                str(one),
            )
            for one in study.wanted
        },
        coords=_coordinates(grid, labels),
        attrs={
            "title": study.name,
            "comment": study.description,
            "study": study.text,
            "m4e_fmi_version": m4e_fmi.__version__,
            "python_version": platform.python_version(),
            "created": datetime.now(UTC).isoformat("T", "seconds"),
            **{name: _valid(text) for name, text in attributes.items()},
        },
    )
    for name, values, unit, text in (
        (
            "coupling_error",
            [r.coupling_error for r in records],
            "1",
            "largest estimated coupling error over the range",
        ),
        ("wall_time", [r.wall_time for r in records], "s", "time that the run took"),
        ("start_up", start_up, "s", "rows from this time on count in statistics"),
        *([("wave_power", wave_power, "W/m", f"{OF_WAVES}, in {water}")] if water else []),
    ):
        found[name] = _variable(names, np.array(values, dtype=float).reshape(shape), unit, text)
    failures = np.array([_valid(r.failure) for r in records], dtype=object).reshape(shape)
    found["failure"] = (names, failures, {"long_name": "why the run failed; empty if it did not"})
    if not grid.is_run.all():
        text = "False of what has no probability and is not run"
        found["is_run"] = (names, grid.is_run, {"long_name": text})
    if grid.probability:
        weighted, shares = grid.probability
        text = "probability of a sea state or case"
        found["probability"] = _variable(weighted, shares, "1", text)
    _add_series(found, study, records, labels)
    return found


def _valid(text: str) -> str:
    """The text as a file takes it: without what stands for bytes of odd file names."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _variable(
    names: Sequence[str], values: np.ndarray, unit: str, text: str
) -> tuple[Sequence[str], np.ndarray, dict[str, str]]:
    return names, values, {"units": unit or "1", "long_name": text}


def _coordinates(grid: Grid, labels: Labels) -> dict[str, tuple[object, ...]]:
    found: dict[str, tuple[object, ...]] = {}
    for axis in grid.axes:
        if len(axis.varied) > 1:
            numbers = np.arange(1, len(axis) + 1)
            found[axis.name] = ((axis.name,), numbers, {"long_name": f"number of the {axis.name}"})
        for k, varied in enumerate(axis.varied):
            unit, text = labels.varied.get(varied.targets[0], (varied.unit, ""))
            told = {
                "long_name": text or ", ".join(varied.targets),
                "name": ", ".join(varied.targets),
            }
            name = axis.name if len(axis.varied) == 1 else varied.name
            values = np.array([point[k] for point in axis.points])
            if values.dtype.kind == "O":  # whole numbers that files do not have
                values = values.astype(float)
            units = {"units": unit} if unit and values.dtype.kind in "iuf" else {}
            found[name] = ((axis.name,), values, {**units, **told})
    return found


def _add_series(
    found: xarray.Dataset, study: Study, records: Sequence[Record], labels: Labels
) -> None:
    """Whole series, along the dimension `time`; nan behind the end of runs that are shorter.

    Where runs have rows at different times, as with adaptive steps, the dimension is `row`, and
    `time` has the times of each run.
    """
    longest = max(records, key=lambda r: len(r.time), default=None)
    if not study.series or longest is None or not len(longest.time):
        return
    names, count = [axis.name for axis in study.grid.axes], len(longest.time)
    told = {"units": "s", "long_name": "simulated time"}
    same = all(np.array_equal(r.time, longest.time[: len(r.time)]) for r in records)
    along = "time" if same else "row"
    if same:
        found.coords["time"] = (("time",), longest.time, told)
    else:
        times = _rows([r.time for r in records], count).reshape((*study.grid.shape, count))
        found["time"] = ((*names, "row"), times, told)
    for name in study.series:
        rows = _rows([r.series.get(name, np.empty(0)) for r in records], count)
        unit, text = labels.variables.get(name, ("", ""))
        values = rows.reshape((*study.grid.shape, count))
        found[name] = _variable((*names, along), values, unit, text or name)


def _rows(series: Sequence[np.ndarray], count: int) -> np.ndarray:
    """Series of different lengths as rows (n_runs, count), with nan behind their ends."""
    rows = np.full((len(series), count), np.nan)
    for row, values in zip(rows, series, strict=True):
        row[: len(values)] = values
    return rows


def write_dataset(found: xarray.Dataset, path: Path) -> None:
    """Write a data set as netCDF, or as a long table by the suffix .csv, whole or not at all.

    RunError if it cannot be written.
    """
    with written(path) as part:
        if path.suffix.lower() == ".csv":
            _write_table(found, part)
            return
        try:
            with PROCESS:
                found.to_netcdf(part, engine="netcdf4")
        except RuntimeError as error:  # what netCDF4 makes of a full disk
            raise OSError(str(error)) from error


def _write_table(found: xarray.Dataset, path: Path) -> None:
    """A row for each run: its varied quantities, then its results; no series."""
    names = [n for n in found.variables if not {"time", "row"} & {*found[n].dims}]
    order = [*(n for n in names if n in found.coords), *(n for n in names if n in found.data_vars)]
    dims = list(found["failure"].dims)
    like = found["failure"].reset_coords(drop=True)
    columns = {n: found[n].broadcast_like(like).transpose(*dims).values.ravel() for n in order}
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        heads = []
        for name in columns:
            unit = found[name].attrs.get("units", "")
            heads.append(f"{name} [{unit}]" if unit not in ("", "1") else str(name))
        writer.writerow(heads)
        cells = ([_plain(cell) for cell in column.tolist()] for column in columns.values())
        writer.writerows(zip(*cells, strict=True))


def _plain(cell: object) -> object:
    """A cell; a text that a spreadsheet would take for a formula with an apostrophe before it."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(FORMULA) else cell
