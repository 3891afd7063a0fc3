"""Tables of results as other tools write them (CSV): separators, decimal commas, comments, units.

The form is taken from the last row: columns are separated by semicolons, tabs, commas or blanks.
Rows of numbers follow the names of the columns; a row of units may be between them. Lines above the
names are left out, empty entries and ``nan`` are gaps. Ambiguous content is
refused, with its line number.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.csv_columns import (
    AS_SECONDS,
    COMMENTS,
    LONGEST_SHOWN,
    OF_CLOCK,
    UTF_8,
    WINDOWS,
    heading,
    is_unit,
    shortened,
    table_text,
    unit_text,
)
from m4e_fmi.files.limits import LARGEST_RECORD
from m4e_fmi.shown import one_line

_MISSING = ("", "nan", "na", "n/a", "null", "none", "-")
_MOST_ABOVE = 1000
"""Lines above the first row of numbers."""
_NAMES_OF_MARKS = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}


def beginning(text: str) -> str:
    """The first characters of a text, in quotation marks."""
    return repr(one_line(text)[:LONGEST_SHOWN])


@dataclass(frozen=True)
class TableVariable:
    """Values (n,) of a variable over time, nan in gaps; `unit` None if the file has none.

    `held` is true of whole numbers and truth values, which hold from row to row.
    """

    name: str
    unit: str | None
    values: np.ndarray = field(repr=False)
    held: bool = False


@dataclass(frozen=True)
class ForeignTable:
    """Columns of a table, and `notes` on how it was read; row k is in line `lines[k]`, from 1."""

    columns: tuple[TableVariable, ...]
    lines: tuple[int, ...] = field(repr=False)
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Form:
    """Separator of columns (None: blanks) and decimal mark."""

    separator: str | None
    decimal: str = "."

    def entries(self, line: str) -> list[str]:
        if self.separator is None:
            return line.split()
        try:
            (row,) = csv.reader([line], delimiter=self.separator, strict=True)
        except (csv.Error, ValueError):
            row = line.split(self.separator)
        return [entry.strip() for entry in row]

    def number(self, entry: str) -> float | None:
        """The number of an entry, nan of a missing one; None for anything else."""
        if entry.lower() in _MISSING:
            return math.nan
        if self.decimal == ",":
            if "." in entry:
                return None
            entry = entry.replace(",", ".")
        try:
            return None if "_" in entry else float(entry)
        except ValueError:
            return None

    def is_number(self, entry: str) -> bool:
        """True for a number, not for a missing one."""
        value = self.number(entry)
        return value is not None and math.isfinite(value)

    def plain_row(self, line: str) -> list[float] | None:
        """The row of numbers of a line without gaps, quickly; None if it is not as simple."""
        if "_" in line or (self.decimal == "," and "." in line):
            return None
        text = line.replace(",", ".") if self.decimal == "," else line
        try:
            return list(map(float, text.split(self.separator)))
        except ValueError:
            return None

    def numbers(self, line: str) -> list[float] | None:
        """The row of numbers of a line; None unless two columns are there and one is a number."""
        found = [self.number(entry) for entry in self.entries(line)]
        row = [value for value in found if value is not None]
        whole = len(row) == len(found) >= 2 and not all(map(math.isnan, row))
        return row if whole else None


_FORMS = (
    _Form(";"), _Form(";", ","), _Form("\t"), _Form("\t", ","), _Form(","), _Form(None),
    _Form(None, ","),
)  # fmt: skip


def read_foreign_table(path: Path) -> ForeignTable:
    """The columns of a CSV file of any tool.

    InputError with lines: no file or text, no rows of numbers, no names above them, entries that
    are no numbers, rows of another length.
    """
    text, encoding = table_text(path, largest=LARGEST_RECORD, encodings=(UTF_8, WINDOWS))
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip()]
    rows = [(k, line) for k, line in lines if not line.lstrip().startswith(COMMENTS)]
    form = _form(path, rows)
    first = next(
        (n for n, (_, line) in enumerate(rows[:_MOST_ABOVE]) if form.numbers(line)), len(rows)
    )
    if first == len(rows):
        raise InputError.single("has no rows of numbers", "give a table of results", str(path))
    above = [(k, line) for k, line in lines if k < rows[first][0]]
    names, units, skipped = _headings(path, form, above, rows[first])
    values, problems = _values(path, form, rows[first:], len(names))
    InputError.raise_for(shortened(problems))
    columns = tuple(map(TableVariable, names, units, values.T))
    notes = ((f"taken as {encoding}",) if encoding else ()) + _notes(form, skipped)
    return ForeignTable(columns, tuple(k for k, _ in rows[first:]), notes)


def _form(path: Path, rows: Sequence[tuple[int, str]]) -> _Form:
    """The form of the last row: the first in which it is one of numbers.

    Commas are decimal marks where rows are numbers with them only.
    """
    last = rows[-1][1] if rows else ""
    for form in _FORMS:
        if form.separator is not None and form.separator not in last:
            continue
        if form.numbers(last):
            other = _Form(form.separator, ",")
            marked = [line for _, line in rows if "," in line and form.separator != ","]
            commas = any(other.numbers(line) and not form.numbers(line) for line in marked)
            return other if commas else form
    if not rows:
        raise InputError.single("has no rows", "give a table of results", str(path))
    line, shown = rows[-1]
    message = f"the last row is not one of numbers in columns: {beginning(shown)}"
    remedy = (
        AS_SECONDS
        if OF_CLOCK.search(shown)
        else "separate columns by ; or tabs where decimals have a comma, and leave out marks "
        "between thousands"
    )
    raise InputError([Problem(message, remedy, str(path), line, 1)])


def _headings(
    path: Path,
    form: _Form,
    above: Sequence[tuple[int, str]],
    first: tuple[int, str],
) -> tuple[list[str], list[str | None], int]:
    """Names and units of columns, and the number of lines above that are left out.

    A separator at the end of rows does not make one more column.
    """
    found: list[tuple[int, list[str]]] = []
    row = form.entries(first[1])
    widths = range(len(row) - (not row[-1]), len(row) + 1)
    for k, line in above:
        stripped = line.strip()
        mark = next((m for m in COMMENTS if stripped.startswith(m)), "")
        entries = form.entries(stripped.removeprefix(mark) if mark else line)
        while entries and not entries[-1]:
            entries.pop()
        if len(entries) in widths:
            found.append((k, entries))
    if not found:
        number, line = first
        message = f"no names of {len(row)} columns are above the first row of numbers"
        remedy = (
            "write them above it, the time first, separated as the numbers are; decimal commas "
            "need columns separated by ; or tabs"
        )
        shown = one_line(line)[:LONGEST_SHOWN]
        raise InputError([Problem(message, remedy, str(path), number, 1, shown, len(shown))])
    number, names, units = _names(path, form, found)
    return names, units, sum(k < number for k, _ in above)


def _names(
    path: Path, form: _Form, found: Sequence[tuple[int, list[str]]]
) -> tuple[int, list[str], list[str | None]]:
    """Line, names and units of columns from the rows `found` above the numbers."""
    number, names = found[-1]
    if wrong := [entry for entry in names if form.is_number(entry)]:
        message = f"names of columns or numbers expected, got both: {one_line(', '.join(names))}"
        remedy = f"{wrong[0]!r} is a number; write names above the numbers, and no marks in those"
        raise InputError([Problem(message[:200], remedy, str(path), number, 1)])
    units: list[str | None] = []
    last = [re.sub(r"^[\[(](.*)[\])]$", r"\1", entry) for entry in names]
    of_units = (is_unit(unit_text(entry)) for entry in last)
    if len(found) > 1 and all(of_units):
        units = [unit_text(entry) for entry in last]
        number, names = found[-2]
    else:
        parts = [heading(entry) for entry in names]
        names, units = [name for name, _ in parts], [unit for _, unit in parts]
    problems = [
        Problem(f"two columns are called {name!r}", "rename one of them", str(path), number, 1)
        for name in dict.fromkeys(names)
        if names.count(name) > 1 and name
    ]
    InputError.raise_for(shortened(problems))
    return number, names, units


def _values(
    path: Path, form: _Form, rows: Sequence[tuple[int, str]], width: int
) -> tuple[np.ndarray, list[Problem]]:
    values, problems = np.full((len(rows), width), np.nan), []
    for k, (number, line) in enumerate(rows):
        if (plain := form.plain_row(line)) is not None and len(plain) == width:
            values[k] = plain
            continue
        entries = form.entries(line)
        while len(entries) > width and not entries[-1]:
            entries.pop()
        if len(entries) != width:
            message = f"{len(entries)} entries, the names above are {width}"
            remedy = f"columns are separated by {_NAMES_OF_MARKS[form.separator]} in this file"
            problems.append(Problem(message, remedy, str(path), number, 1))
            continue
        row = [form.number(entry) for entry in entries]
        for value, entry in zip(row, entries, strict=True):
            if value is None:
                message = f"expected a number, got {beginning(entry)}"
                remedy = "empty entries and nan are gaps"
                problems.append(Problem(message, remedy, str(path), number, 1))
        values[k] = [math.nan if value is None else value for value in row]
    return values, problems


def _notes(form: _Form, skipped: int) -> tuple[str, ...]:
    notes = []
    if form.separator != "," or form.decimal != ".":
        mark = "decimal commas" if form.decimal == "," else "decimal points"
        notes.append(f"columns separated by {_NAMES_OF_MARKS[form.separator]}, {mark}")
    if skipped:
        notes.append(f"{skipped} line{'s' * (skipped != 1)} above the names left out")
    return tuple(notes)
