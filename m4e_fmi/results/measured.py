"""One motion over time from a table of measurements (CSV) or a file of results, in SI units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.csv_columns import COMMAS, SUFFIXES, column_names, read_columns, shortened
from m4e_fmi.results.results_file import load
from m4e_fmi.units import Unit, parse_unit

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
_UNIT = re.compile(r"\[([^\[\]]*)\]")
_TIMES = ("time", "t")


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

    InputError with line and remedy: no such column, units that are no length or angle, entries that
    are not finite numbers, times that do not increase.
    """
    table = path.suffix.lower() in SUFFIXES
    return _of_table(path, name) if table else _of_results(path, name)


def _of_table(path: Path, name: str | None) -> Measured:
    columns = column_names(path)
    time_name = _time_column(path, columns)
    chosen = _chosen(path, [c for c in columns if c != time_name], name)
    try:
        read = read_columns(path, [time_name, chosen])
    except InputError as error:
        problems = [
            p if p.remedy or not p.line else replace(p, remedy=LEAVE_OUT) for p in error.problems
        ]
        raise InputError(problems) from None
    time, values = (np.array(column) for column in read.values)
    back = [
        read.problem(k + 1, f"time {time[k + 1]:g} does not follow {time[k]:g}", "sort the rows")
        if time[k + 1] < time[k]
        else read.problem(k + 1, f"time {time[k]:g} is there twice", "remove one of the rows")
        for k in np.flatnonzero(np.diff(time) <= 0.0).tolist()
    ]
    if back:
        raise InputError(shortened(back))
    notes = []
    seconds = _unit(path, time_name, "s", "time")
    motion = _motion(_plain(chosen))
    text = _UNIT.search(chosen)
    if text is None and motion in TURNS:
        message = f"column {chosen!r} does not say its unit, deg or rad"
        raise InputError.single(message, f"name it '{chosen} [deg]' or '{chosen} [rad]'", str(path))
    if text is None:
        notes.append(f"column {chosen!r} says no unit: taken as m")
    unit = _unit(path, chosen, "m", "a length or an angle", other="rad")
    return Measured(
        path,
        _plain(chosen),
        unit.si_text,
        motion,
        time * seconds.factor,
        values * unit.factor,
        tuple(notes),
    )


def _of_results(path: Path, name: str | None) -> Measured:
    results = load(path)
    series = {n: s for n, s in results.series.items() if s.recorded.is_real}
    if name is None:
        message = "has many variables"
        remedy = f"name one with --variable; {suggestion('', _lengths(series), 'motions')}"
        raise InputError.single(message, remedy, str(path))
    if name not in series:
        message = f"has no variable {name!r} that is a number"
        raise InputError.single(message, suggestion(name, series, "variables"), str(path))
    one = series[name]
    unit = _checked(path, name, one.unit, "m", "a length or an angle", other="rad")
    kept = np.append(np.diff(results.time) > 0.0, True)  # of rows at an event, the last
    values = np.asarray(one.values, dtype=float)[kept] * unit.factor
    time = np.asarray(results.time, dtype=float)[kept]
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        message = f"{name} is {values[bad[0]]:g} at t = {time[bad[0]]:g} s"
        raise InputError.single(message, "look at why the run went wrong there", str(path))
    return Measured(path, name, unit.si_text, _motion(name), time, values)


def _lengths(series: dict) -> list[str]:
    return [name for name, one in series.items() if one.unit in ("m", "rad", "deg")]


def _plain(column: str) -> str:
    """The name of a column without its unit."""
    return column.split("[")[0].strip(" #")


def _motion(name: str) -> str:
    words = re.split(r"[\s._]+", name.lower())
    return MOTIONS.get(words[-1], "")


def _time_column(path: Path, columns: Sequence[str]) -> str:
    for column in columns:
        if _plain(column).lower() in _TIMES:
            return column
    message = "has no column for the time"
    raise InputError.single(message, f"call it 'time [s]'; {COMMAS}", str(path))


def _chosen(path: Path, columns: Sequence[str], name: str | None) -> str:
    """The column whose name, with or without its unit, is `name`."""
    if name is None and len(columns) == 1:
        return columns[0]
    plain = {_plain(column): column for column in columns}
    if name is None:
        remedy = f"name one with --column; {suggestion('', plain, 'columns')}"
        raise InputError.single(f"has {len(columns)} columns beside the time", remedy, str(path))
    if name in columns:
        return name
    if name not in plain:
        message = f"no column {name!r}"
        raise InputError.single(message, suggestion(name, plain, "columns"), str(path))
    return plain[name]


def _unit(path: Path, column: str, default: str, what: str, *, other: str = "") -> Unit:
    found = _UNIT.search(column)
    text = found[1].strip() if found else default
    return _checked(path, column, text, default, what, other=other)


def _checked(path: Path, name: str, text: str, default: str, what: str, *, other: str = "") -> Unit:
    """The unit `text` if it is one of the dimension of `default` or `other`; else InputError."""
    wanted = [parse_unit(unit) for unit in (default, other) if unit]
    try:
        unit = parse_unit(text)
    except ValueError as error:
        raise InputError([Problem(f"{name!r}: {error}", f"expected {what}", str(path))]) from None
    if not any(unit.same_dimension(one) for one in wanted):
        message = f"{name!r} is in {text}, expected {what}"
        raise InputError.single(message, "choose another column or variable", str(path))
    return unit
