"""Variables over time of a file of results: ours (netCDF), or a table of any tool.

`read_compared` gives all of them, to be compared; `read_measured` one motion, in SI units.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.csv_columns import SUFFIXES, heading, shortened
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.results.foreign_table import TableVariable, read_foreign_table
from m4e_fmi.results.results_file import NETCDF, Results, load_results
from m4e_fmi.shown import listing, span
from m4e_fmi.units import Unit, parse_unit

TIMES = ("time", "t", "times", "zeit", "temps", "tiempo", "tempo", "simtime", "simulation time")
"""Headings of times, in lower case and without unit."""
LEAST_NINES = 3
"""Of a mark of a missing value, as -9999 or 999.9."""
BEYOND = 2.0
"""Magnitude of a mark, over the largest of the other values, at least."""
MOTIONS = {
    **dict.fromkeys(("surge", "x"), "surge"),
    **dict.fromkeys(("sway", "y"), "sway"),
    **dict.fromkeys(("heave", "z"), "heave"),
    **dict.fromkeys(("roll", "phi"), "roll"),
    **dict.fromkeys(("pitch", "theta"), "pitch"),
    **dict.fromkeys(("yaw", "psi"), "yaw"),
}
"""Motions by the last word of a name."""
LEAVE_OUT = "leave such rows out: a gap is told, and does no harm"
TURNS = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class ComparedFile:
    """Variables by name at `time` (n,) [s], which increases; `notes` tell how the file was read."""

    path: Path
    time: np.ndarray = field(repr=False)
    quantities: Mapping[str, TableVariable]
    notes: tuple[str, ...] = ()

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
        return _of_table(path)
    if suffix == NETCDF or not path.is_file():
        return _of_results(load_results(path))
    kinds = ", ".join((NETCDF, *SUFFIXES))
    message, remedy = "is no file of results by its name", f"names of such files end in {kinds}"
    raise InputError.single(message, remedy, str(path))


def _of_results(results: Results) -> ComparedFile:
    found = {
        name: TableVariable(
            name, one.unit or "1", np.asarray(one.values, float), not one.recorded.is_real
        )
        for name, one in results.series.items()
        if not one.recorded.is_text
    }
    left = [name for name, one in results.series.items() if one.recorded.is_text]
    notes = (f"texts are not compared: {', '.join(left[:5])}",) if left else ()
    return ComparedFile(results.path, np.asarray(results.time, float), found, notes)


def _of_table(path: Path) -> ComparedFile:
    table = read_foreign_table(path)
    columns, told, lines = table.columns, list(table.notes), table.lines
    times = [c for c in columns if c.name.lower() in TIMES]
    if not times:
        remedy = f"call it 'time [s]'; {suggestion('', [c.name for c in columns], 'columns')}"
        raise InputError.single("has no column for the time", remedy, str(path))
    first = times[0]
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


def _seconds(path: Path, column: TableVariable, notes: list[str]) -> np.ndarray:
    if column.unit is None:
        notes.append(f"column {column.name!r} says no unit: taken as s")
        return column.values
    unit = _unit(path, column.name, column.unit, ("s",), "a time", "call it 'time [s]'")
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


def marks(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Mask (n,) [1] of the `values` (n,) [any unit] that are nines, far beyond all others."""
    digits = {value: f"{abs(value):g}".replace(".", "") for value in np.unique(values).tolist()}
    nines = np.isin(values, [v for v, d in digits.items() if d == "9" * max(LEAST_NINES, len(d))])
    others = np.abs(values[~nines])
    if not len(others):
        return np.zeros(len(values), bool)
    return nines & (np.abs(values) > BEYOND * others.max())


def check_marks(file: ComparedFile, variable: TableVariable) -> None:
    """InputError for a variable of a table that has marks of missing values."""
    if file.path.suffix.lower() not in SUFFIXES or variable.held:
        return
    known = np.flatnonzero(np.isfinite(variable.values))
    for row in known[marks(variable.values[known])][:1].tolist():
        message = f"{variable.name} at {file.time[row]:g} s is {variable.values[row]:g}"
        remedy = "a mark of a missing value, as it seems: leave such entries empty"
        raise InputError.single(message, remedy, str(file.path))


@dataclass(frozen=True)
class Measured:
    """`values` (n,) [`unit`, m or rad] of a motion at `time` (n,) [s], as recorded in a file.

    `motion` is surge, heave, …, or empty if the name does not say which. `notes` tell what was
    taken for granted.
    """

    path: Path
    name: str
    unit: str
    motion: str
    time: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    notes: tuple[str, ...] = ()


def read_measured(path: Path, name: str | None = None) -> Measured:
    """The column or variable `name` of a file; of a table with two columns the one beside time.

    Tables are read as by `read_compared`; rows without a value are left out. InputError with line
    and remedy: no such column, units that are no length or angle, entries that are no numbers,
    times that decrease.
    """
    found, is_table = read_compared(path), path.suffix.lower() in SUFFIXES
    numbers = {n: one for n, one in found.quantities.items() if not one.held}
    chosen = _chosen(path, numbers, name)
    motion = MOTIONS.get(re.split(r"[\s._]+", chosen.name.lower())[-1], "")
    notes = [*found.notes] if is_table else []
    if chosen.unit is None and motion in TURNS:
        message = f"column {chosen.name!r} does not say its unit, deg or rad"
        remedy = f"name it '{chosen.name} [deg]' or '{chosen.name} [rad]'"
        raise InputError.single(message, remedy, str(path))
    if chosen.unit is None:
        notes.append(f"column {chosen.name!r} says no unit: taken as m")
    text = chosen.unit or "m"
    unit = _unit(
        path,
        chosen.name,
        text,
        ("m", "rad"),
        "a length or an angle",
        "choose another column or variable",
    )
    known = np.isfinite(chosen.values)
    check_marks(found, chosen)
    if not (known.all() or is_table):
        first = int(np.argmin(known))
        message = f"{name} is {chosen.values[first]:g} at t = {found.time[first]:g} s"
        raise InputError.single(message, "look at why the run went wrong there", str(path))
    if not known.any():
        raise InputError.single(f"column {chosen.name!r} has no numbers", "", str(path))
    return Measured(
        path,
        chosen.name,
        unit.si_text,
        motion,
        found.time[known],
        chosen.values[known] * unit.factor,
        tuple(notes),
    )


def _chosen(path: Path, known: Mapping[str, TableVariable], name: str | None) -> TableVariable:
    """The variable whose name, with or without its unit, is `name`; without one the only one."""
    if name is None and len(known) == 1:
        return next(iter(known.values()))
    if name is None:
        remedy = f"name one with --variable; {suggestion('', known, 'variables')}"
        raise InputError.single(f"has {len(known)} variables beside the time", remedy, str(path))
    plain = name if name in known else heading(name)[0]
    if plain not in known:
        message = f"has no variable {name!r} that is a number"
        raise InputError.single(message, suggestion(name, known, "variables"), str(path))
    return known[plain]


def _unit(
    path: Path, name: str, text: str, alike: Sequence[str], expected: str, remedy: str
) -> Unit:
    """The unit `text` of a column if it is of the dimension of one `alike`; else InputError."""
    try:
        unit = parse_unit(text)
    except ValueError as error:
        message = f"{name!r}: {error}"
        raise InputError.single(message, f"expected {expected}", str(path)) from None
    if not any(unit.same_dimension(parse_unit(one)) for one in alike):
        message = f"{name!r} is in {text}, expected {expected}"
        raise InputError.single(message, remedy, str(path))
    return unit
