"""Which variables of two files belong together, and in which unit they are compared."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, suggestion, unknown_names
from m4e_fmi.files.csv_columns import heading
from m4e_fmi.results.compared_file import ComparedFile, TableVariable
from m4e_fmi.units import parse_unit

_MOST_SHOWN = 4
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_CHANGED = re.compile(
    r"\s*(?P<name>\S.*?)"
    rf"(?:\s+\*\s+(?P<factor>{_NUMBER}))?"
    rf"(?:\s+(?P<sign>[+-])\s+(?P<offset>{_NUMBER}))?"
    r"(?P<ignored>\s*,\s*units ignored)?\s*$"
)


@dataclass(frozen=True)
class Pair:
    """A variable and its reference; the latter's values times `factor` plus `offset` in `unit`."""

    variable: TableVariable
    reference: TableVariable
    unit: str
    factor: float
    offset: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Column:
    """A name in the reference, and what its values are changed by, as for connections."""

    name: str
    factor: float = 1.0
    offset: float = 0.0
    units_ignored: bool = False

    @property
    def change(self) -> str:
        """The change of the values, for a note; empty if there is none."""
        text = "" if self.factor == 1.0 else f" * {self.factor:.9g}"
        if self.offset:
            text += f" {'-' if self.offset < 0.0 else '+'} {abs(self.offset):.9g}"
        text += ", units ignored" if self.units_ignored else ""
        return text and f"{self.name!r}{text}"


def matched(
    one: ComparedFile,
    reference: ComparedFile,
    *,
    mapping: Mapping[str, str],
    variables: Collection[str] | None,
) -> list[Pair]:
    """Pairs of variables: those that `mapping` names, then those of the same name.

    `mapping` leads from names in the reference, with or without unit, to ours; a name may be
    followed by a factor and an offset in our unit, as ``heave * -1 + 0.5``, and by
    ``, units ignored``. A name in the reference without a component stands for the only variable
    of ours that is called so. `variables` are those of ours that are wanted, None for all.
    InputError with all names that are unknown or without a counterpart, and all units that do not
    fit.
    """
    columns = {text: _column(text, reference) for text in mapping}
    taken = {column.name for column in columns.values()}
    problems = unknown_names(
        dict.fromkeys(column.name for column in columns.values()), reference.quantities,
        f"{reference.path.name} has no variable", "variables",
    )  # fmt: skip
    ours = [*mapping.values(), *(variables or ())]
    problems += unknown_names(
        dict.fromkeys(ours), one.quantities, f"{one.path.name} has no variable", "variables"
    )
    twice = {name for name in mapping.values() if list(mapping.values()).count(name) > 1}
    problems += [Problem(f"{name!r} is mapped twice", "map it once") for name in sorted(twice)]
    problems += [
        Problem(f"{text!r}: factor {one.factor:g}, offset {one.offset:g}", "expected no factor 0")
        for text, one in columns.items()
        if one.factor == 0.0 or not math.isfinite(one.factor) or not math.isfinite(one.offset)
    ]
    if problems:
        raise InputError(dict.fromkeys(problems))
    found = {name: columns[text] for text, name in mapping.items()}
    notes = {name: column.change for name, column in found.items() if column.change}
    for name in reference.quantities:
        if name in taken:
            continue
        if name in one.quantities:
            found.setdefault(name, _Column(name))
        elif (alone := _alone(name, one)) and alone not in found:
            found[alone] = _Column(name)
            notes[alone] = f"{name!r} of the reference is taken as {alone}, the only one so called"
    wanted = [name for name in one.quantities if variables is None or name in variables]
    problems = [_without(name, reference) for name in variables or () if name not in found]
    if not problems and not any(name in found for name in wanted):
        problems = [_nothing(one, reference)]
    InputError.raise_for(problems)
    return _in_units(
        [
            (one.quantities[n], reference.quantities[found[n].name], found[n], notes.get(n))
            for n in wanted
            if n in found
        ],
        reference.path,
    )


def _column(text: str, reference: ComparedFile) -> _Column:
    """The variable of the reference that a text names, with or without unit, and its change."""
    known, whole = reference.quantities, _plain(text, reference)
    match = _CHANGED.match(text)
    if whole in known or not match:
        return _Column(whole)
    offset = float(match["offset"] or 0.0)
    return _Column(
        _plain(match["name"], reference), float(match["factor"] or 1.0),
        -offset if match["sign"] == "-" else offset, match["ignored"] is not None,
    )  # fmt: skip


def _plain(name: str, reference: ComparedFile) -> str:
    """The name without its unit, if a variable of the reference is so called."""
    plain = heading(name)[0]
    known = reference.quantities
    return plain if name not in known and plain in known else name


def _alone(name: str, one: ComparedFile) -> str | None:
    """The only variable ``component.name``."""
    found = [n for n in one.quantities if n.partition(".")[2] == name]
    return found[0] if len(found) == 1 else None


def _without(name: str, reference: ComparedFile) -> Problem:
    near = suggestion(name, reference.quantities, "variables")
    remedy = f"name its counterpart with --map REFERENCE={name}; {near}"
    return Problem(f"{reference.path.name} has no variable {name!r}", remedy)


def _nothing(one: ComparedFile, reference: ComparedFile) -> Problem:
    def shown(file: ComparedFile) -> str:
        names = list(file.quantities)
        more = ", …" if len(names) > _MOST_SHOWN else ""
        return f"{file.path.name} has {', '.join(names[:_MOST_SHOWN])}{more}"

    message = f"no variable has the same name in both: {shown(one)}; {shown(reference)}"
    return Problem(message, "say which belong together: --map REFERENCE=COMPONENT.VARIABLE")


def _in_units(
    pairs: list[tuple[TableVariable, TableVariable, _Column, str | None]], path: Path
) -> list[Pair]:
    found, problems = [], []
    for variable, reference, column, note in pairs:
        notes = [note] if note else []
        try:
            unit, factor, told = (
                (variable.unit or "", 1.0, "")
                if column.units_ignored
                else _unit(variable, reference)
            )
        except ValueError as error:
            remedy = (
                "write the unit behind the name, as in 'name [unit]'; or convert by a factor: "
                f"--map '{reference.name} * 1.0, units ignored={variable.name}'"
            )
            message = f"{variable.name} and {reference.name}: {error}"
            problems.append(Problem(message, remedy, str(path)))
            continue
        notes += [told] if told else []
        found.append(
            Pair(variable, reference, unit, factor * column.factor, column.offset, tuple(notes))
        )
    InputError.raise_for(problems)
    return found


def _unit(variable: TableVariable, reference: TableVariable) -> tuple[str, float, str]:
    """Unit, the reference's factor, and what was done; ValueError if the units do not fit."""
    own, other = variable.unit, reference.unit
    if own is None and other is None:
        return "", 1.0, "no unit in either file: compared as they are"
    if other is None or own is None:
        known = str(own or other)
        name = reference.name if other is None else variable.name
        return known, 1.0, f"{name!r} says no unit: taken as {known}"
    if own == other:
        return own, 1.0, ""
    mine, theirs = parse_unit(own), parse_unit(other)
    if not mine.same_dimension(theirs):
        raise ValueError(f"{own} and {other} are of different dimension")
    factor = theirs.factor / mine.factor
    told = "" if factor == 1.0 else f"{reference.name!r} converted from {other} to {own}"
    return own, factor, told
