"""Variables over time of a file to be compared: ours (netCDF), or a table of any tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.csv_columns import SUFFIXES, shortened
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.results.foreign_table import ForeignTable, Quantity, read_foreign_table
from m4e_fmi.results.results_file import NETCDF, Results, load
from m4e_fmi.shown import listing, span
from m4e_fmi.units import parse_unit

TIMES = ("time", "t", "times", "zeit", "temps", "tiempo", "tempo", "simtime", "simulation time")
"""Headings of times, in lower case and without unit."""


@dataclass(frozen=True)
class ComparedFile:
    """Variables by name at `time` (n,) [s], which increases; `notes` tell how the file was read.

    Of a file with dates the time counts from its first row, at `origin` [s] after the year 0, which
    is in UTC if the file is `zoned`, and else at a place that it does not tell.
    """

    path: Path
    time: np.ndarray = field(repr=False)
    quantities: Mapping[str, Quantity]
    notes: tuple[str, ...] = ()
    origin: float | None = None
    zoned: bool = False

    def __repr__(self) -> str:
        title = f"ComparedFile of {str(self.path)!r}: {span(self.time)}"
        return listing(title, variables=tuple(self.quantities))


def read_compared(source: str | Path | Results) -> ComparedFile:
    """The variables of a file or of results in memory.

    InputError for a file of another kind, no column for the time, times that decrease or are not
    numbers.
    """
    if isinstance(source, Results):
        return _of_results(source)
    path = as_path(source)
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return _of_table(path, read_foreign_table(path))
    if suffix == NETCDF or not path.is_file():
        return _of_results(load(path))
    kinds = ", ".join((NETCDF, *SUFFIXES))
    message, remedy = "is no file of results by its name", f"names of such files end in {kinds}"
    raise InputError.single(message, remedy, str(path))


def _of_table(path: Path, table: ForeignTable) -> ComparedFile:
    clock, timed, notes = table.clock, table.clock_column, list(table.notes)
    if clock is None or timed is None:
        return _of_columns(path, table.columns, notes, table.lines)
    rest = [column for column in table.columns if column is not timed]
    if any(_is_in_seconds(column) for column in rest):
        notes.append(
            f"dates or times of day in {timed.name!r} left out: a time in seconds is there"
        )
        return _of_columns(path, rest, notes, table.lines)
    notes.append(f"times are seconds from the first row, {clock.first}")
    columns = [replace(timed, name=TIMES[0]), *rest]
    found = _of_columns(path, columns, notes, table.lines)
    return replace(found, origin=clock.origin, zoned=clock.zoned)


def _is_in_seconds(column: Quantity) -> bool:
    """True for a time beside dates: T without a unit may as well be a temperature."""
    if column.name.lower() not in TIMES:
        return False
    try:
        return parse_unit(column.unit or "1").same_dimension(parse_unit("s"))
    except ValueError:
        return False


def _of_results(results: Results) -> ComparedFile:
    found = {
        name: Quantity(
            name, one.unit or "1", np.asarray(one.values, float), not one.recorded.is_real
        )
        for name, one in results.series.items()
        if not one.recorded.is_text
    }
    left = [name for name, one in results.series.items() if one.recorded.is_text]
    notes = (f"texts are not compared: {', '.join(left[:5])}",) if left else ()
    return ComparedFile(results.path, np.asarray(results.time, float), found, notes)


def _of_columns(
    path: Path, columns: Sequence[Quantity], notes: Sequence[str], lines: Sequence[int] | None
) -> ComparedFile:
    times = [c for c in columns if c.name.lower() in TIMES]
    if not times:
        remedy = f"call it 'time [s]'; {suggestion('', [c.name for c in columns], 'columns')}"
        raise InputError.single("has no column for the time", remedy, str(path))
    first, told = times[0], list(notes)
    time = _seconds(path, first, told)
    _check_times(path, time, lines)
    last = np.append(np.diff(time) > 0.0, True)  # of rows at one time, as at an event
    if not last.all():
        told.append(f"{np.sum(~last)} rows at the time of the next left out")
    found = {
        c.name: replace(c, unit=c.unit or None, values=c.values[last])
        for c in columns
        if c is not first and c.name
    }
    return ComparedFile(path, time[last], found, tuple(told))


def _seconds(path: Path, column: Quantity, notes: list[str]) -> np.ndarray:
    if column.unit is None:
        notes.append(f"column {column.name!r} says no unit: taken as s")
        return column.values
    try:
        unit = parse_unit(column.unit)
    except ValueError as error:
        raise InputError.single(f"{column.name!r}: {error}", "expected s", str(path)) from None
    if not unit.same_dimension(parse_unit("s")):
        message = f"{column.name!r} is in {column.unit}, expected a time"
        raise InputError.single(message, "call it 'time [s]'", str(path))
    if unit.factor != 1.0:
        notes.append(f"time converted from {column.unit} to s")
    return column.values * unit.factor


def _check_times(path: Path, time: np.ndarray, lines: Sequence[int] | None) -> None:
    """InputError for times (n,) [s] that are not finite, or decrease."""
    number = lines or range(1, len(time) + 1)
    problems = [
        Problem("the time is missing or not finite", "leave such rows out", str(path), number[k], 1)
        for k in np.flatnonzero(~np.isfinite(time)).tolist()
    ]
    problems += [
        Problem(
            f"time {time[k + 1]:g} s follows {time[k]:g} s", "sort the rows", str(path),
            number[k + 1], 1,
        )
        for k in np.flatnonzero(np.diff(time) < 0.0).tolist()
    ]  # fmt: skip
    if problems or not len(time):
        raise InputError(shortened(problems) or [Problem("has no rows", "", str(path))])
