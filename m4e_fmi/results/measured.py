"""One motion over time from a table of measurements (CSV) or a file of results, in SI units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.csv_columns import SUFFIXES, heading
from m4e_fmi.results.compared_file import Quantity, read_compared
from m4e_fmi.results.doubts import doubts
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


@dataclass(frozen=True)
class Measured:
    """`values` (n,) [`unit`, m or rad] of a motion at `time` (n,) [s], as recorded in a file.

    `motion` is surge, heave, …, or empty if the name does not say which. `notes` tell what was
    taken for granted; those that are `doubts` tell of rows that may be no measurements.
    """

    path: Path
    name: str
    unit: str
    motion: str
    time: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


def read_measured(path: Path, name: str | None = None) -> Measured:
    """The column or variable `name` of a file; of a table with two columns the one beside time.

    Tables are read as by `read_compared`; rows without a value are left out. InputError with line
    and remedy: no such column, units that are no length or angle, entries that are no numbers,
    times that decrease.
    """
    table = path.suffix.lower() in SUFFIXES
    return _of_table(path, name) if table else _of_results(path, name)


def _of_table(path: Path, name: str | None) -> Measured:
    table = read_compared(path)
    chosen = _chosen(path, table.quantities, name)
    motion = _motion(chosen.name)
    if chosen.unit is None and motion in TURNS:
        message = f"column {chosen.name!r} does not say its unit, deg or rad"
        remedy = f"name it '{chosen.name} [deg]' or '{chosen.name} [rad]'"
        raise InputError.single(message, remedy, str(path))
    notes = list(table.notes)
    if chosen.unit is None:
        notes.append(f"column {chosen.name!r} says no unit: taken as m")
    text = chosen.unit or "m"
    unit = _checked(path, chosen.name, text, "m", "a length or an angle", other="rad")
    doubted = tuple(doubts(table.time, chosen.values, text))
    known = np.isfinite(chosen.values)
    if not known.any():
        raise InputError.single(f"column {chosen.name!r} has no numbers", "", str(path))
    values = chosen.values[known] * unit.factor
    return Measured(
        path,
        chosen.name,
        unit.si_text,
        motion,
        table.time[known],
        values,
        (*notes, *doubted),
        doubted,
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


def _motion(name: str) -> str:
    words = re.split(r"[\s._]+", name.lower())
    return MOTIONS.get(words[-1], "")


def _chosen(path: Path, columns: Mapping[str, Quantity], name: str | None) -> Quantity:
    """The column whose name, with or without its unit, is `name`."""
    if name is None and len(columns) == 1:
        return next(iter(columns.values()))
    if name is None:
        remedy = f"name one with --column; {suggestion('', columns, 'columns')}"
        raise InputError.single(f"has {len(columns)} columns beside the time", remedy, str(path))
    plain = name if name in columns else heading(name)[0]
    if plain not in columns:
        raise InputError.single(
            f"no column {name!r}", suggestion(name, columns, "columns"), str(path)
        )
    return columns[plain]


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
