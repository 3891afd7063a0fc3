"""Numbers of waves in CSV files: spectra, components, records; all problems with their lines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config.waves import (
    MOST_COMPONENTS,
    Component,
    ComponentWaves,
    Record,
    SpectrumTable,
)
from m4e_fmi.errors import InputError
from m4e_fmi.files.csv_columns import Columns, column_names, read_columns, shortened
from m4e_fmi.results.compared_file import marks

FEWEST_ROWS, MOST_ROWS = 3, 10_000  # of a spectrum
SHORTEST_RECORD = 32  # rows
UNEVEN = 2e-3  # of a step: difference of a time from equal steps that is none
FILL = "fill it, or give the part before or after it"
STEPS = (
    "sort the rows; fill gaps, or give the part before or after them; interpolate to equal steps, "
    "and write enough digits"
)
UNITS = {
    "time": "s",
    "elevation": "m",
    "omega": "rad/s",
    "frequency": "Hz",
    "amplitude": "m",
    "period": "s",
    "phase": "rad",
    "direction": "deg",
}
"""Of the numbers in columns whose names say none, and of those that are read."""


@dataclass(frozen=True)
class Density:
    """A spectrum: `density` (n,) [m2.s/rad] at `omega` (n,) [rad/s], which ascend."""

    omega: np.ndarray = field(repr=False)
    density: np.ndarray = field(repr=False)


@dataclass(frozen=True)
class Samples:
    """A record of `elevation` (n,) [m] at equal steps of `interval` [s] from `start` [s]."""

    start: float
    interval: float
    elevation: np.ndarray = field(repr=False)


def read_density(section: SpectrumTable, folder: Path) -> Density:
    """The spectrum of a section whose file is in `folder`; InputError with all its problems."""
    path = folder / section.file
    key = _one_of(path, "omega", "frequency")
    per = "m2.s/rad" if key == "omega" else "m2/Hz"
    columns = read_columns(path, [(key, UNITS[key]), ("density", per)])
    frequency, density = map(np.array, columns.values)
    _check(columns, list(_of_density(frequency, density)), fewest=FEWEST_ROWS, most=MOST_ROWS)
    turn = 2.0 * math.pi if key == "frequency" else 1.0
    return Density(turn * frequency, density / turn)


def _of_density(frequency: np.ndarray, density: np.ndarray) -> Iterator[tuple[int, str, str]]:
    if len(frequency) and frequency[0] < 0:
        yield 0, f"a frequency of {frequency[0]:g} is negative", "give the spectrum from 0 on"
    for row in np.flatnonzero(np.diff(frequency) <= 0).tolist():
        text = f"frequency {frequency[row + 1]:g} is not above {frequency[row]:g}"
        yield row + 1, text, "sort the rows; each frequency stands once"
    for row in np.flatnonzero(density < 0).tolist():
        yield row, f"a density of {density[row]:g} is negative", "a spectrum has energies"
    if len(density) and not density.any():
        yield 0, "all densities are 0", "write {spectrum: still} for no waves"


def read_components(section: ComponentWaves, folder: Path) -> tuple[Component, ...]:
    """The components of a section; its file is in `folder`. InputError with all its problems."""
    if section.components is not None:
        return section.components
    path = folder / (section.file or "")
    names, key = column_names(path), _one_of(path, "period", "omega")
    like = {name.partition("(")[0].strip().lower() for name in names}
    # a name in other letters, or with a unit that is not known, is reported
    wanted = ["amplitude", key, *(name for name in ("phase", "direction") if name in like)]
    columns = read_columns(path, [(name, UNITS[name]) for name in wanted])
    problems = [
        (row, f"{name} {value:g} is not positive", "leave the row out, or correct it")
        for name, values in zip(("amplitude", key), columns.values, strict=False)
        for row, value in enumerate(values)
        if value <= 0
    ]
    _check(columns, problems, fewest=1, most=MOST_COMPONENTS)
    return tuple(
        Component.model_validate(dict(zip(wanted, row, strict=True)))
        for row in zip(*columns.values, strict=True)
    )


def _one_of(path: Path, first: str, second: str) -> str:
    """Which of two columns a file has; the first if none. InputError if it has both."""
    names = column_names(path)
    if first in names and second in names:
        message = f"has both a column {first!r} and a column {second!r}"
        raise InputError.single(message, "leave one out", str(path))
    return second if second in names else first


def read_record(section: Record, folder: Path) -> Samples:
    """The record of a section whose file is in `folder`; InputError with all its problems."""
    wanted = [(name, UNITS[name]) for name in ("time", "elevation")]
    columns = read_columns(folder / section.file, wanted)
    time, elevation = map(np.array, columns.values)
    problems = list(_of_times(time))
    if len(elevation) and np.ptp(elevation) == 0.0:
        problems.append((0, "the elevation never changes", "write {spectrum: still} for no waves"))
    problems += [
        (row, f"{elevation[row]:g} m is a mark of a missing value", FILL)
        for row in np.flatnonzero(marks(elevation)).tolist()
    ]
    fewer = "take a part, or longer steps: filter it before rows are left out"
    _check(columns, problems, fewest=SHORTEST_RECORD, most=MOST_ROWS, fewer=fewer)
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    return Samples(float(time[0]), interval, elevation)


def _of_times(time: np.ndarray) -> Iterator[tuple[int, str, str]]:
    """Index, fault and remedy of the first row whose time is not in equal steps upwards."""
    steps = np.diff(time)
    if not len(steps):
        return
    usual = float(np.median(steps))
    even = time[0] + (time[-1] - time[0]) / len(steps) * np.arange(len(time))
    for faults, right in (
        (~(np.abs(steps - usual) < 0.5 * usual), time[:-1] + usual),  # gaps, and times not sorted
        (np.abs(time - even)[1:] > UNEVEN * usual, even[1:]),
    ):
        if faults.any():
            row = int(np.argmax(faults))
            text = f"times are not in equal steps: {time[row + 1]:.9g} s, expected "
            yield row + 1, f"{text}{right[row]:.9g} s", STEPS
            return


def _check(
    columns: Columns,
    problems: Sequence[tuple[int, str, str]],
    *,
    fewest: int,
    most: int,
    fewer: str = "leave some out, or take a part",
) -> None:
    """InputError with the `problems` (row, message, remedy) of a file, or too few or many rows.

    `fewer` is the remedy for too many.
    """
    count = len(columns.lines)
    if not fewest <= count <= most:
        message = f"expected {fewest} to {most} rows, got {count}"
        remedy = "give more" if count < fewest else fewer
        raise InputError.single(message, remedy, str(columns.path))
    if problems:
        raise InputError(shortened([columns.problem(*problem) for problem in problems]))
