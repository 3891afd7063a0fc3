"""Tables of results as other tools write them (CSV): separators, decimal commas, comments, units.

The form is taken from the last row: columns are separated by semicolons, tabs, commas or blanks.
Rows of numbers follow the names of the columns; a row of units may be between them. Lines above the
names are left out, empty entries and ``nan`` are gaps. Ambiguous content is
refused, with its line number.

Dates and times of day become seconds from the first row. Understood are ISO 8601
(``2026-03-01T12:00:00.25Z``), its parts with a blank or in columns of their own, and times of day
alone.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.csv_columns import (
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

Line = tuple[int, str]
DAY = 86400.0
PLACE = "0"
"""Entry that stands for a date or a time of day once it is read."""
_DATE = r"(?P<date>\d{4}(?P<mark>[-/.])\d{1,2}(?P=mark)\d{1,2})"
_TIME = (
    r"(?P<time>(?P<hour>\d{1,2}):(?P<minute>\d{2}):(?P<second>\d{2}(?:\.\d+|COMMA)?)"
    r"(?P<zone>Z|\s?UTC|\s?[+-]\d{2}:\d{2}|[+-]\d{4}|[+-]\d{2}(?![\d.]))?)"
)
_GAP = r"(?P<gap>T|[\s\"]*[;,\t][\s\"]*|\s+)"
_BEFORE, _BEHIND = r"(?<![\w.:/-])", r"(?![\w:])"
_STAMP, _OF_DAY = f"{_BEFORE}{_DATE}{_GAP}{_TIME}{_BEHIND}", f"{_BEFORE}{_TIME}{_BEHIND}"
_OTHER = re.compile(
    r"(?<![\w.:/-])\d{1,2}([-/.]\d{1,2}[-/.]|[- ][a-z]{3,9}[- ])\d{2,4}[T\s\";,]+\d{1,2}:\d{2}"
    r"|:\d{2}\S*\s*[ap]m\b",
    re.IGNORECASE,
)
"""Dates in another order, or with names of months, and times of half a day."""
_COMMA_BEFORE_BLANK = r",\d+(?=\s+[-+.\d])"
"""Commas of seconds, in columns that are separated by blanks."""
_NUMBERS = re.compile(r"[-+.,;\deE\s\"]*")
REMEDY = "write dates as 2026-03-01 12:00:00.250, or seconds since the first row"
_MISSING = ("", "nan", "na", "n/a", "null", "none", "-")
_MOST_ABOVE = 1000
"""Lines above the first row of numbers."""
_TOA5_LINES = 4
"""Lines above the rows of a file that begins with TOA5, Campbell Scientific's form of tables."""
_NAMES_OF_MARKS = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}


@dataclass(frozen=True)
class Clock:
    """`seconds` (n,) [s] of each row after the first, which is at `first`, a text of the file.

    `origin` [s] is that of the first row after the year 0, None of a time of day alone; `zoned` is
    true if it is in UTC. The texts take as many columns as `columns`, the first of which begins
    with the character `at` of the first row, from 0.
    """

    seconds: np.ndarray = field(repr=False)
    first: str
    origin: float | None
    zoned: bool
    at: int
    columns: int


def without_clock(path: Path, rows: Sequence[Line]) -> tuple[list[Line], Clock | None]:
    """The rows with `PLACE` for dates and times of day, and these; None where the last has none.

    Rows before the first with a date or time are headings, and stay. InputError with the lines of
    later rows without one, and of invalid dates or dates not in ISO 8601.
    """
    end, last = rows[-1] if rows else (0, "")
    if _OTHER.search(last):
        message = f"no date or time of day of ISO 8601: {beginning(last)}"
        raise InputError([Problem(message, REMEDY, str(path), end, 1)])
    comma = r",\d+" if re.search(r"[;\t]", last) else _COMMA_BEFORE_BLANK
    patterns = [
        re.compile(text.replace("COMMA", comma), re.IGNORECASE) for text in (_STAMP, _OF_DAY)
    ]
    pattern = next((p for p in patterns if p.search(last)), None)
    if pattern is None:
        return list(rows), None
    found = [pattern.search(line) for _, line in rows]
    start = next(
        k
        for k, ((_, line), match) in enumerate(zip(rows, found, strict=True))
        if match and (_NUMBERS.fullmatch(line[: match.start()]) or k == len(rows) - 1)
    )
    lines, matches = rows[start:], found[start:]
    problems = [
        Problem(f"no date or time of day: {beginning(line)}", REMEDY, str(path), number, 1)
        for (number, line), match in zip(lines, matches, strict=True)
        if not match
    ]
    InputError.raise_for(shortened(problems))
    whole = [match for match in matches if match]
    clock = _clock(path, lines, whole, dated=pattern is patterns[0])
    replaced = []
    for (number, line), match in zip(lines, whole, strict=True):
        place = PLACE if clock.columns == 1 else f"{PLACE}{match['gap']}{PLACE}"
        replaced.append((number, line[: match.start()] + place + line[match.end() :]))
    return [*rows[:start], *replaced], clock


def _clock(
    path: Path, lines: Sequence[Line], matches: Sequence[re.Match[str]], *, dated: bool
) -> Clock:
    first = matches[0]
    moments, problems = [], []
    zoned = {bool(match["zone"]) for match in matches}
    if len(zoned) > 1:
        message = "some times have an offset from UTC, others have none"
        problems.append(Problem(message, "write it in all rows, or in none", str(path)))
    for (number, line), match in zip(lines, matches, strict=True):
        try:
            day = date(*map(int, re.split(r"[-/.]", match["date"]))).toordinal() if dated else 0
            moments.append((day, _second_of_day(match)))
        except ValueError as error:
            problems.append(Problem(f"{beginning(line)}: {error}", REMEDY, str(path), number, 1))
    if not dated:
        back = [k for k in range(1, len(moments)) if moments[k][1] < moments[k - 1][1] - DAY / 2]
        message = "the time of day is past midnight, and no date tells the day"
        problems += [Problem(message, REMEDY, str(path), lines[k][0], 1) for k in back]
    InputError.raise_for(shortened(problems))
    days, seconds = (np.array(column, float) for column in zip(*moments, strict=True))
    return Clock(
        seconds=DAY * (days - days[0]) + (seconds - seconds[0]),
        first=one_line(first.group().strip())[:LONGEST_SHOWN],
        origin=DAY * float(days[0]) + float(seconds[0]) if dated else None,
        zoned=zoned == {True},
        at=first.start(),
        columns=1 if not dated or not re.search(r"[;,\t]", first["gap"]) else 2,
    )


def _second_of_day(match: re.Match[str]) -> float:
    """Seconds after midnight, in UTC if the zone is there; ValueError if there is no such time."""
    hour, minute = int(match["hour"]), int(match["minute"])
    second = float(match["second"].replace(",", "."))
    if hour > 24 or minute > 59 or second >= 61.0:
        raise ValueError(f"{match['time']!r} is no time of day")
    zone, offset = (match["zone"] or "Z").strip().upper(), 0
    if zone[0] in "+-":
        digits = zone[1:].replace(":", "")
        offset = (3600 * int(digits[:2]) + 60 * int(digits[2:] or 0)) * (
            -1 if zone[0] == "-" else 1
        )
    return 3600.0 * hour + 60.0 * minute + second - offset


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
    """Columns of a table, and `notes` on how it was read; row k is in line `lines[k]`, from 1.

    `clock_column`, one of the columns, was dates or times of day: those of the `clock`.
    """

    columns: tuple[TableVariable, ...]
    lines: tuple[int, ...] = field(repr=False)
    notes: tuple[str, ...]
    clock: Clock | None = None
    clock_column: TableVariable | None = None


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
    rows, clock = without_clock(path, rows)
    form = _form(path, rows)
    first = next(
        (n for n, (_, line) in enumerate(rows[:_MOST_ABOVE]) if form.numbers(line)), len(rows)
    )
    if clock:
        first = len(rows) - len(clock.seconds)
    if first == len(rows):
        raise InputError.single("has no rows of numbers", "give a table of results", str(path))
    above = [(k, line) for k, line in lines if k < rows[first][0]]
    place = _place(form, rows[first][1], clock) if clock else None
    names, units, skipped = _headings(path, form, above, rows[first], place)
    values, problems = _values(path, form, rows[first:], len(names))
    InputError.raise_for(shortened(problems))
    columns = [
        TableVariable(name, unit, column)
        for name, unit, column in zip(names, units, values.T, strict=True)
    ]
    notes = ((f"taken as {encoding}",) if encoding else ()) + _notes(form, skipped)
    timed = None
    if clock and place is not None:
        last = place + clock.columns - 1
        timed = TableVariable(names[last], "s", clock.seconds)
        columns[place : last + 1] = [timed]
    numbers = tuple(k for k, _ in rows[first:])
    return ForeignTable(tuple(columns), numbers, notes, clock, timed)


def _place(form: _Form, line: str, clock: Clock) -> int:
    """The column, from 0, in which dates or times of day begin."""
    marked = f"{line[: clock.at]}@{line[clock.at + 1 :]}"
    return next(k for k, entry in enumerate(form.entries(marked)) if "@" in entry)


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
        REMEDY
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
    clock: int | None,
) -> tuple[list[str], list[str | None], int]:
    """Names and units of columns, and the number of lines above that are left out.

    A separator at the end of rows does not make one more column. Column `clock`, from 0, has dates
    or times of day; between blanks its date and its time may have a name each.
    """
    if toa5 := _of_toa5(form, above):
        return toa5
    found: list[tuple[int, list[str]]] = []
    row = form.entries(first[1])
    widths = range(len(row) - (not row[-1]), len(row) + 1)
    for k, line in above:
        stripped = line.strip()
        mark = next((m for m in COMMENTS if stripped.startswith(m)), "")
        entries = form.entries(stripped.removeprefix(mark) if mark else line)
        while entries and not entries[-1]:
            entries.pop()
        if clock is not None and form.separator is None and len(entries) == len(row) + 1:
            del entries[clock]
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
    number, names, units = _names(path, form, found, clock)
    return names, units, sum(k < number for k, _ in above)


def _of_toa5(
    form: _Form, above: Sequence[tuple[int, str]]
) -> tuple[list[str], list[str | None], int] | None:
    """The same of loggers' files that begin with TOA5; None of others.

    Lines with names, with units and with words such as Avg follow the first line.
    """
    rows = [form.entries(line) for _, line in above]
    if len(rows) != _TOA5_LINES or rows[0][0] != "TOA5" or len({len(row) for row in rows[1:]}) > 1:
        return None
    return rows[1], [unit or None for unit in rows[2]], 1


def _names(
    path: Path, form: _Form, found: Sequence[tuple[int, list[str]]], clock: int | None
) -> tuple[int, list[str], list[str | None]]:
    """Line, names and units of columns from the rows `found` above the numbers."""
    number, names = found[-1]
    if wrong := [entry for entry in names if form.is_number(entry)]:
        message = f"names of columns or numbers expected, got both: {one_line(', '.join(names))}"
        remedy = f"{wrong[0]!r} is a number; write names above the numbers, and no marks in those"
        raise InputError([Problem(message[:200], remedy, str(path), number, 1)])
    units: list[str | None] = []
    last = [re.sub(r"^[\[(](.*)[\])]$", r"\1", entry) for entry in names]
    of_units = (is_unit(unit_text(entry)) for k, entry in enumerate(last) if k != clock)
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
