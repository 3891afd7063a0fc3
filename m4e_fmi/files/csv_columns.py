"""Columns of numbers from a CSV file; all its problems are reported together, by line."""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, is_file, is_other, suggestion
from m4e_fmi.files.file_kinds import check_named
from m4e_fmi.files.files_read import TooLongError, opened, read_text
from m4e_fmi.files.limits import LARGEST_TABLE
from m4e_fmi.units import parse_unit

_NO_TEXT = re.compile("[\x00-\x08\x0e-\x1f]")
_WITH_COMMA = re.compile(r"[+-]?(\d+,\d*|,\d+)([eE][+-]?\d+)?")
_WITH_POINT = re.compile(r"[+-]?(\d+\.\d*|\.\d+)([eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_IN_BRACKETS = re.compile(r"\[([^\[\]]*)\]\s*$")
SUFFIXES = (".csv", ".txt", ".dat", ".tsv")
"""Of names of tables."""
UTF_8, UTF_16, WINDOWS = "utf-8-sig", "utf-16", "Windows-1252"
"""Encodings of tables; those of UTF begin with a mark, or may."""
OF_CLOCK = re.compile(r"\d{1,2}:\d{2}\b|\d{4}-\d{2}-\d{2}|\b\d{1,2}[./]\d{1,2}[./]\d{2,4}\b")
"""Of dates and times of day."""
AS_SECONDS = "write dates and times of day as seconds since the first row"
COMMAS = "separate columns by commas, and write decimal points"
COMMENTS = ("#", "%", "!", "//")
"""Marks of lines above tables that are no rows."""
_LONGEST_SHOWN = 40
"""Characters of an entry that a message shows."""
MOST_PROBLEMS = 10
"""Problems of one file that are reported one by one."""


@dataclass(frozen=True)
class Columns:
    """Columns of a file: `values[i][k]` is the number in row k of the i-th column asked for.

    Row k, from 0, stands in line `lines[k]` of `path`, from 1. Units are the file's.
    """

    path: Path
    lines: tuple[int, ...]
    values: tuple[list[float], ...] = field(repr=False)
    _text: Sequence[str] = field(default=(), repr=False, compare=False)

    def problem(self, row: int, message: str, remedy: str = "") -> Problem:
        """A problem with a row of the file."""
        return _problem(self.path, self._text, self.lines[row], message, remedy)


@dataclass(frozen=True)
class Asked:
    """Source of a demand for a column, and the remedy if it is missing, both for messages."""

    by: str
    remedy: str


def read_columns(
    path: Path, wanted: Sequence[str | int], asked: Mapping[str, Asked] | None = None
) -> Columns:
    """The columns `wanted` of a CSV file, by the names in its first row or by place, from 0.

    `asked` gives the source of each demand by column name, where the problems do not show it.
    Columns are separated by commas, semicolons or tabs; empty lines are skipped. Between
    semicolons or tabs numbers may have decimal commas, as of spreadsheets in many languages.
    InputError with all problems: no file, not a text, fewer than two columns, unknown names,
    entries that are not finite numbers.
    """
    lines, rows = _rows(path)
    header = [entry.strip() for entry in rows[0][1]]
    names = [entry if isinstance(entry, str) else header[entry] for entry in wanted]
    by_place = [header[entry] for entry in wanted if not isinstance(entry, str)]
    unclear = dict.fromkeys(
        (*_header_problems(header, names, asked or {}), *_unit_problems(by_place))
    )
    if unclear:
        raise InputError(_problem(path, lines, rows[0][0], *texts) for texts in unclear)
    places = [header.index(name) for name in names]
    values = tuple([_number(row, place) for _, row in rows[1:]] for place in places)
    problems = [
        _problem(
            path,
            lines,
            line,
            f"expected a finite number in column {header[place]!r}, {got}",
            _remedy(row[place] if place < len(row) else ""),
        )
        for line, row in rows[1:]
        for place in dict.fromkeys(places)
        if not math.isfinite(_number(row, place))
        for got in [f"got {_shown(row[place])}" if place < len(row) else "got nothing"]
    ]
    problems += [
        _problem(path, lines, line, f"{len(row)} entries, the header has {len(header)}", COMMAS)
        for line, row in rows[1:]
        if any(entry.strip() for entry in row[len(header) :])
    ]
    if problems:
        raise InputError(shortened(problems))
    return Columns(path, tuple(line for line, _ in rows[1:]), values, lines)


def column_names(path: Path) -> list[str]:
    """Names of the columns of a CSV file, its first row; errors as `read_columns` without names."""
    _, rows = _rows(path)
    header = [entry.strip() for entry in rows[0][1]]
    if unclear := _header_problems(header, [], {}):
        raise InputError.single(*unclear[0], str(path))
    return header


def _rows(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Lines of a file, and the entries of those that are not empty with their numbers."""
    text = table_text(path)
    mark = _separator(text)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=mark, strict=True)
    try:
        rows = [(reader.line_num, row) for row in reader if any(entry.strip() for entry in row)]
    except csv.Error as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    message, remedy = "has no two columns", "separate them by commas, names first"
    if not rows:
        raise InputError.single(message, remedy, str(path))
    lines = text.splitlines()
    if len(rows[0][1]) < 2:
        if any(len(row) > 1 for _, row in rows):
            message, remedy = (
                "no names of columns",
                "remove the lines above the names of the columns",
            )
        raise InputError([_problem(path, lines, rows[0][0], message, remedy)])
    return lines, rows if mark == "," else _with_points(path, lines, rows)


Rows = list[tuple[int, list[str]]]
"""Entries of lines by the number of the line."""


def _with_points(path: Path, lines: Sequence[str], rows: Rows) -> Rows:
    """The rows with points in place of decimal commas.

    InputError where commas may stand between thousands: there are points, too, or all commas have
    three digits behind them.
    """
    of = [(line, entry.strip()) for line, row in rows for entry in row]
    commas = [(line, entry) for line, entry in of if _WITH_COMMA.fullmatch(entry)]
    if not commas:
        return rows
    line, entry = commas[0]
    points = [other for _, other in of if _WITH_POINT.fullmatch(other)]
    if points or all(_THOUSANDS.fullmatch(entry) for _, entry in commas):
        why = f"{points[0]!r} has a point" if points else "all commas have three digits behind them"
        message = f"{entry!r} may have a decimal comma, or one between thousands: {why}"
        raise InputError([_problem(path, lines, line, message, "write decimal points")])
    return [
        (line, [e.replace(",", ".") if _WITH_COMMA.fullmatch(e.strip()) else e for e in row])
        for line, row in rows
    ]


def _separator(text: str) -> str:
    """Mark between columns of the first line that is not empty: a semicolon, a tab or a comma."""
    first = text.strip("\r\n ").partition("\n")[0]
    return next((mark for mark in ";\t," if mark in first), ",")


def shortened(problems: Sequence[Problem]) -> list[Problem]:
    """The first problems of a file, and how many more there are."""
    shown, rest = list(problems[:MOST_PROBLEMS]), problems[MOST_PROBLEMS:]
    if rest:
        shown.append(Problem(f"{len(rest)} more problems in this file", "", rest[0].file))
    return shown


def table_text(path: Path, *, largest: int = LARGEST_TABLE, encoding: str = UTF_8) -> str:
    """Text of a table of up to `largest` bytes; InputError unless it is one by name and content."""
    _check_table(path)
    try:
        return _checked_text(path, encoding, largest)
    except UnicodeDecodeError as error:
        shown = {UTF_8: "UTF-8", UTF_16: "UTF-16"}.get(encoding, encoding)
        message = f"cannot be read: byte {error.start + 1} is not valid {shown}"
        raise InputError.single(message, "save it as UTF-8", str(path)) from None


def foreign_text(path: Path, *, largest: int) -> tuple[str, str]:
    """As `table_text`, of a table that another tool wrote; and its encoding if that is not UTF-8.

    A file that begins with the mark of UTF-16 is in that. One that is not valid UTF-8 is taken as
    Windows-1252, which has all printed characters of Latin-1.
    """
    _check_table(path)
    try:
        with opened(path) as file:
            marked = file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    except OSError as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    if marked:
        return table_text(path, largest=largest, encoding=UTF_16), "UTF-16"
    try:
        return _checked_text(path, UTF_8, largest), ""
    except UnicodeDecodeError:
        return table_text(path, largest=largest, encoding=WINDOWS), WINDOWS


def _check_table(path: Path) -> None:
    """InputError unless a file of that name is there, and is a table by its name."""
    if is_other(path):
        raise InputError.single("is a pipe or a device", "copy it into a file", str(path))
    if not is_file(path):
        names = list[str]()
        with suppress(OSError):  # of a name that no file system takes
            here = path.parent if path.parent.is_dir() else Path()
            names = [other.name for other in here.glob("*.csv")]
        raise InputError.single("no such file", suggestion(path.name, names), str(path))
    check_named(path, SUFFIXES, "table")


def _checked_text(path: Path, encoding: str, largest: int) -> str:
    """Text of a file in an encoding, without its mark; InputError, and UnicodeDecodeError."""
    try:
        text = read_text(path, encoding=encoding, largest=largest)
    except TooLongError as error:
        raise InputError.single(str(error), "leave out rows, or columns", str(path)) from None
    except OSError as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    if _NO_TEXT.search(text):
        raise InputError.single("is not a table: it has control characters", "", str(path))
    return text


def unit_of_column(name: str) -> str:
    """The unit in brackets at the end of a column's name, "" without; ValueError if it is none."""
    found = _IN_BRACKETS.search(name)
    unit = found[1].strip() if found else ""
    if unit in ("", "-"):
        return ""
    parse_unit(unit)
    return unit


def _unit_problems(names: Sequence[str]) -> list[tuple[str, str]]:
    """Message and remedy for each column taken by place whose name has a unit that is not SI."""
    found = []
    for name in names:
        unit = _IN_BRACKETS.search(name)
        try:
            plain = not unit or parse_unit(unit[1]).factor == 1.0
        except ValueError:
            plain = False
        if not plain:
            message = f"column {name[:_LONGEST_SHOWN]!r} names a unit, which is not read"
            found.append(
                (message, "convert the column to SI units, and name them so or not at all")
            )
    return found


def _header_problems(
    header: Sequence[str], names: Sequence[str], asked: Mapping[str, Asked]
) -> list[tuple[str, str]]:
    if all(math.isfinite(_number(header, place)) for place in range(len(header))):
        return [("the first row is numbers: column names are missing", "write names above them")]
    found = []
    for name in names:
        if name not in header:
            known = [entry[:_LONGEST_SHOWN] for entry in header]
            message, remedy = f"no column {name!r}", suggestion(name, known, "columns")
            if header[0].startswith(COMMENTS):
                beside = header[0].lstrip("".join(COMMENTS)).strip()
                what = "this mark before" if beside == name else "the lines above"
                remedy = f"remove {what} the names of the columns"
            if name in asked:
                message = f"{message} in this file, {asked[name].by}"
                remedy = f"{asked[name].remedy}; {remedy}"
            found.append((message, remedy))
        elif header.count(name) > 1:
            found.append((f"two columns are called {name!r}", "rename one of them"))
    return found


def _remedy(entry: str) -> str:
    """Remedy for an entry that is not a number, "" if none is certain."""
    if OF_CLOCK.search(entry):
        return AS_SECONDS
    if ";" in entry:
        return "separate the names of the columns as the numbers are, by semicolons"
    return ""


def _number(row: Sequence[str], place: int) -> float:
    """The number in a row, nan if there is none."""
    try:
        return float(row[place])
    except (ValueError, IndexError):
        return math.nan


def _problem(
    path: Path, lines: Sequence[str], line: int, message: str, remedy: str = ""
) -> Problem:
    source = lines[line - 1][:_LONGEST_SHOWN] if 0 < line <= len(lines) else ""
    return Problem(message, remedy, str(path), line, 1, source, len(source))


def _shown(entry: str) -> str:
    return repr(entry if len(entry) <= _LONGEST_SHOWN else f"{entry[:_LONGEST_SHOWN]}…")
