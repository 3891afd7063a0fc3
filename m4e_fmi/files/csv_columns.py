"""Columns of numbers from a CSV file, in the units asked for; names and units of headings.

All problems of a file are reported together, by line.
"""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, is_file, is_other, missing_file, suggestion
from m4e_fmi.files.file_kinds import check_named
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_TABLE
from m4e_fmi.units import number_in, parse_unit

_NO_TEXT = re.compile("[\x00-\x08\x0e-\x1f]")
_UNIT = re.compile(r"(?<!\s)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*$")
_WITHIN = re.compile(r"(?<=\S)\s+[\[(]([^\[\]()]*)[\])]\s*(?=\S)")
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
LONGEST_SHOWN = 40
"""Characters of an entry that a message shows."""
MOST_PROBLEMS = 10
"""Problems of one file that are reported one by one."""


@dataclass(frozen=True)
class Columns:
    """Columns of a file: `values[i][k]` is the number in row k of the i-th column asked for.

    Row k, from 0, stands in line `lines[k]` of `path`, from 1. Numbers are in the units that they
    were asked for in; `names` are those of the file, with its units.
    """

    path: Path
    names: tuple[str, ...]
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
    path: Path,
    wanted: Sequence[tuple[str | int, str | None]],
    asked: Mapping[str, Asked] | None = None,
) -> Columns:
    """The columns `wanted` of a CSV file: each by its name or place, from 0, and in a unit.

    Names in the first row may end with a unit, ``force [kN]`` or ``force (kN)``, from which numbers
    are converted; without, they are in the unit asked for. A column may be asked for with or
    without that ending, and in the unit None: as it stands in the file.
    `asked` gives the source of each demand by column name, where the problems do not show it.
    Columns are separated by commas, semicolons or tabs; empty lines are skipped.
    InputError with all problems: no file, not a text, fewer than two columns, unknown names,
    units that are unknown or of another dimension, entries that are not finite numbers.
    """
    lines, rows = _rows(path)
    header = [entry.strip() for entry in rows[0][1]]
    known = _places(header)
    names = [name if isinstance(name, str) else header[name] for name, _ in wanted]
    places = [known[name][0] for name in names if name in known]
    units = [unit for name, (_, unit) in zip(names, wanted, strict=True) if name in known]
    columns = [(header[place], unit) for place, unit in zip(places, units, strict=True)]
    unclear = _header_problems(header, dict.fromkeys(names), known, asked or {})
    unclear += filter(None, (_unit_problem(*column) for column in dict.fromkeys(columns)))
    InputError.raise_for(_problem(path, lines, rows[0][0], *texts) for texts in unclear)
    factors = [
        number_in(unit, f"1 {heading(name)[1] or unit}") if unit else 1.0 for name, unit in columns
    ]
    values = tuple(
        [factor * _number(row, place) for _, row in rows[1:]]
        for place, factor in zip(places, factors, strict=True)
    )
    problems = [
        _problem(
            path,
            lines,
            line,
            f"expected a finite number in column {header[place]!r}, {got}",
            _remedy(row[place] if place < len(row) else ""),
        )
        for line, row in rows[1:]
        for place, factor in dict.fromkeys(zip(places, factors, strict=True))
        if not math.isfinite(factor * _number(row, place))
        for got in [f"got {_shown(row[place])}" if place < len(row) else "got nothing"]
    ]
    problems += [
        _problem(path, lines, line, f"{len(row)} entries, the header has {len(header)}", COMMAS)
        for line, row in rows[1:]
        if any(entry.strip() for entry in row[len(header) :])
    ]
    InputError.raise_for(shortened(problems))
    names = tuple(name for name, _ in columns)
    return Columns(path, names, tuple(line for line, _ in rows[1:]), values, lines)


def column_names(path: Path) -> list[str]:
    """Names of the columns of a CSV file without units, from its first row.

    Errors as `read_columns` without names.
    """
    _, rows = _rows(path)
    header = [entry.strip() for entry in rows[0][1]]
    if unclear := _header_problems(header, (), {}, {}):
        raise InputError.single(*unclear[0], str(path))
    return [heading(entry)[0] for entry in header]


def heading(text: str) -> tuple[str, str | None]:
    """Name and unit of a heading, as ``heave [m]`` or ``heave (m)``; None where it has no unit.

    Parentheses belong to the name if they hold no unit. A unit within a name, as in ``tension (kN)
    at end A``, stays part of it.
    """
    found = _UNIT.search(text)
    if found and text[: found.start()].strip():
        unit = unit_text(found[1] if found[1] is not None else found[2])
        if found[1] is not None or is_unit(unit):
            return text[: found.start()].strip(), unit
    return text.strip(), _unit_within(text)


def _unit_within(text: str) -> str | None:
    """The only unit in brackets between words; None without, or of several."""
    units = [
        unit for unit in _WITHIN.findall(text) if unit.strip() not in ("", "1") and is_unit(unit)
    ]
    return units[0].strip() if len(units) == 1 else None


def unit_text(text: str) -> str:
    """The unit in the brackets of a heading, "1" of an empty one or a dash."""
    return "1" if text.strip() in ("", "-", "–") else text.strip()


def is_unit(text: str) -> bool:
    """True of the text of a known unit."""
    try:
        parse_unit(text)
    except ValueError:
        return False
    return True


def _rows(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Lines of a file, and the entries of those that are not empty with their numbers."""
    text, _ = table_text(path)
    first = text.strip("\r\n ").partition("\n")[0]
    mark = next((mark for mark in ";\t," if mark in first), ",")
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
    return lines, rows


def shortened(problems: Sequence[Problem]) -> list[Problem]:
    """The first problems of a file, and how many more there are."""
    shown, rest = list(problems[:MOST_PROBLEMS]), problems[MOST_PROBLEMS:]
    if rest:
        shown.append(Problem(f"{len(rest)} more problems in this file", "", rest[0].file))
    return shown


def table_text(
    path: Path, *, largest: int = LARGEST_TABLE, encodings: Sequence[str] = (UTF_8,)
) -> tuple[str, str]:
    """Text of a table of up to `largest` bytes; its encoding is the first in which it is valid.

    Where there are several, a file that begins with the mark of UTF-16 is in that. The encoding is
    told unless it is UTF-8. InputError unless the file is a table by name and content.
    """
    if is_other(path):
        raise InputError.single("is a pipe or a device", "copy it into a file", str(path))
    if not is_file(path):
        raise InputError.single("no such file", missing_file(path)[1], str(path))
    check_named(path, SUFFIXES, "table")
    message, remedy = "", "save it as UTF-8"
    try:
        content = read_bytes(path, largest=largest)
    except TooLongError as error:
        raise InputError.single(str(error), "leave out rows, or columns", str(path)) from None
    except OSError as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    if len(encodings) > 1 and content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = (UTF_16,)
    for encoding in encodings:
        told = {UTF_8: "", UTF_16: "UTF-16"}.get(encoding, encoding)
        try:
            text = io.TextIOWrapper(io.BytesIO(content), encoding=encoding).read()
        except UnicodeDecodeError as error:
            shown = told or "UTF-8"
            message = f"cannot be read: byte {error.start + 1} is not valid {shown}"
            continue
        if not _NO_TEXT.search(text):
            return text, told
        message, remedy = "is not a table: it has control characters", ""
        break
    raise InputError.single(message, remedy, str(path))


def _unit_problem(name: str, unit: str | None) -> tuple[str, str] | None:
    """Message and remedy of a column whose name says a unit that is unknown or not like `unit`."""
    own = heading(name)[1] or unit or "1"
    try:
        difference = parse_unit(own).difference(parse_unit(unit or own))
    except ValueError as error:
        difference = str(error)
    if not difference:
        return None
    of = f"of {unit}" if unit else "known here"
    message = f"column {name[:LONGEST_SHOWN]!r} is not in a unit {of}: {difference}"
    if unit == "1":
        return message, f"state its unit where the file is named, as 'unit: {own}'"
    return message, f"convert it to {unit}" if unit else "write a known one, or none"


def _places(header: Sequence[str]) -> dict[str, list[int]]:
    """Places of the columns by name, with and without the unit."""
    found: dict[str, list[int]] = {}
    for place, entry in enumerate(header):
        for name in {entry, heading(entry)[0]}:
            found.setdefault(name, []).append(place)
    return found


def _header_problems(
    header: Sequence[str],
    names: Iterable[str],
    known: Mapping[str, Sequence[int]],
    asked: Mapping[str, Asked],
) -> list[tuple[str, str]]:
    if all(math.isfinite(_number(header, place)) for place in range(len(header))):
        return [("the first row is numbers: column names are missing", "write names above them")]
    found = []
    for name in names:
        if name not in known:
            listed = [entry[:LONGEST_SHOWN] for entry in header]
            message, remedy = f"no column {name!r}", suggestion(name, listed, "columns")
            if header[0].startswith(COMMENTS):
                beside = heading(header[0].lstrip("".join(COMMENTS)))[0]
                what = "this mark before" if beside == name else "the lines above"
                remedy = f"remove {what} the names of the columns"
            if name in asked:
                message = f"{message} in this file, {asked[name].by}"
                remedy = f"{asked[name].remedy}; {remedy}"
            found.append((message, remedy))
        elif len(known[name]) > 1:
            found.append((f"two columns are called {name!r}", "rename one of them"))
    return found


def _remedy(entry: str) -> str:
    """Remedy for an entry that is not a number, "" if none is certain."""
    if OF_CLOCK.search(entry):
        return AS_SECONDS
    if re.fullmatch(r"[-+\d.]*,[\d.eE+-]*", entry.strip()):
        return "write decimal points"
    if ";" in entry:
        return "separate the names of the columns as the numbers are, by semicolons"
    return ""


def _number(row: Sequence[str], place: int) -> float:
    """The number in a row, nan without one."""
    try:
        return float(row[place])
    except (ValueError, IndexError):
        return math.nan


def _problem(
    path: Path, lines: Sequence[str], line: int, message: str, remedy: str = ""
) -> Problem:
    source = lines[line - 1][:LONGEST_SHOWN] if 0 < line <= len(lines) else ""
    return Problem(message, remedy, str(path), line, 1, source, len(source))


def _shown(entry: str) -> str:
    return repr(entry if len(entry) <= LONGEST_SHOWN else f"{entry[:LONGEST_SHOWN]}…")
