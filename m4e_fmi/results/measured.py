"""One motion over time from a table of measurements (CSV) or a file of results, in SI units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.files.csv_columns import SUFFIXES, heading
from m4e_fmi.results.compared_file import Quantity, read_compared
from m4e_fmi.results.doubts import doubts
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
    found, is_table = read_compared(path), path.suffix.lower() in SUFFIXES
    numbers = {n: one for n, one in found.quantities.items() if not one.held}
    chosen = _column(path, numbers, name) if is_table else _variable(path, numbers, name)
    motion, notes = _motion(chosen.name), [*found.notes] if is_table else []
    if chosen.unit is None and motion in TURNS:
        message = f"column {chosen.name!r} does not say its unit, deg or rad"
        remedy = f"name it '{chosen.name} [deg]' or '{chosen.name} [rad]'"
        raise InputError.single(message, remedy, str(path))
    if chosen.unit is None:
        notes.append(f"column {chosen.name!r} says no unit: taken as m")
    text = chosen.unit or "m"
    unit = _length_or_angle(path, chosen.name, text)
    doubted = tuple(doubts(found.time, chosen.values, text)) if is_table else ()
    known = np.isfinite(chosen.values)
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
        (*notes, *doubted),
        doubted,
    )


def _motion(name: str) -> str:
    words = re.split(r"[\s._]+", name.lower())
    return MOTIONS.get(words[-1], "")


def _column(path: Path, columns: Mapping[str, Quantity], name: str | None) -> Quantity:
    """The column of a table whose name, with or without its unit, is `name`."""
    if name is None and len(columns) == 1:
        return next(iter(columns.values()))
    if name is None:
        remedy = f"name one with --column; {suggestion('', columns, 'columns')}"
        raise InputError.single(f"has {len(columns)} columns beside the time", remedy, str(path))
    plain = name if name in columns else heading(name)[0]
    if plain not in columns:
        remedy = suggestion(name, columns, "columns")
        raise InputError.single(f"no column {name!r}", remedy, str(path))
    return columns[plain]


def _variable(path: Path, variables: Mapping[str, Quantity], name: str | None) -> Quantity:
    """The variable `name` of results."""
    if name is None:
        motions = [n for n, one in variables.items() if one.unit in ("m", "rad", "deg")]
        remedy = f"name one with --variable; {suggestion('', motions, 'motions')}"
        raise InputError.single("has many variables", remedy, str(path))
    if name not in variables:
        message = f"has no variable {name!r} that is a number"
        raise InputError.single(message, suggestion(name, variables, "variables"), str(path))
    return variables[name]


def _length_or_angle(path: Path, name: str, text: str) -> Unit:
    """The unit `text` if it is one of a length or an angle; else InputError."""
    try:
        unit = parse_unit(text)
    except ValueError as error:
        message = f"{name!r}: {error}"
        raise InputError.single(message, "expected a length or an angle", str(path)) from None
    if not any(unit.same_dimension(parse_unit(one)) for one in ("m", "rad")):
        message = f"{name!r} is in {text}, expected a length or an angle"
        raise InputError.single(message, "choose another column or variable", str(path))
    return unit
