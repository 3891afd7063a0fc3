"""Dates and times of day in the rows of tables, as seconds from the first row.

Understood: ISO 8601 (``2026-03-01T12:00:00.25Z``), its parts with a blank or in columns of their
own, and times of day alone.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.csv_columns import LONGEST_SHOWN, shortened
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

    Rows before the first that has one are headings, and stay. InputError with the lines of those
    that have none behind it, and of dates that are none or not those of ISO 8601.
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
    if problems:
        raise InputError(shortened(problems))
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
    if problems:
        raise InputError(shortened(problems))
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
