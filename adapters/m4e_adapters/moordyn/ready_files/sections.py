"""The tables of a MoorDyn v2 input file, as MoorDyn itself finds them.

A line with ``---`` opens a section; a table begins after two more lines, names and units. A word
with ``#`` begins a comment. Source: the MoorDyn v2 documentation, "Inputs", and the behaviour of
version 2.7.2.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from itertools import pairwise, takewhile

TITLES = {
    "line types": ("LINE DICTIONARY", "LINE TYPES"),
    "rod types": ("ROD DICTIONARY", "ROD TYPES"),
    "bodies": ("BODIES", "BODY LIST", "BODY PROPERTIES"),
    "rods": ("RODS", "ROD LIST", "ROD PROPERTIES"),
    "points": (
        "POINTS",
        "POINT LIST",
        "POINT PROPERTIES",
        "CONNECTION PROPERTIES",
        "NODE PROPERTIES",
    ),
    "lines": ("LINES", "LINE LIST", "LINE PROPERTIES"),
    "failure": ("FAILURE",),
    "options": ("OPTIONS",),
    "outputs": ("OUTPUT",),
}
UNSUPPORTED = ("SYROPE", "CONTROL", "EXTERNAL")
WITHOUT_HEADING = ("options", "outputs")
HEADING = 2  # lines of a table before its rows: names and units
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class Row:
    """One line of a table: its words and its line number, from 1."""

    words: tuple[str, ...]
    line: int


def tables(text: str) -> dict[str, tuple[Row, ...]]:
    """The rows of every section that the file has, in file order, by the names in TITLES.

    Under "not supported" are the titles of sections that would be left out; under "no heading" is
    the first row of each table whose names or units are missing, which MoorDyn would leave out.
    """
    lines = text.splitlines()
    openings = [k for k, line in enumerate(lines) if "---" in line]
    found: dict[str, tuple[Row, ...]] = {}
    for opening, end in pairwise([*openings, len(lines)]):
        section = _section(lines[opening])
        if section is None and any(word in lines[opening].upper() for word in UNSUPPORTED):
            title = Row(tuple(lines[opening].split()), opening + 1)
            found["not supported"] = (*found.get("not supported", ()), title)
        if section is None or section in found:
            continue
        rows = [_row(lines[k], k) for k in range(opening + 1, end)]
        if section not in WITHOUT_HEADING:
            early = next((k for k, row in enumerate(rows[:HEADING]) if _is_data(row)), None)
            if early is not None:
                found["no heading"] = (*found.get("no heading", ()), rows[early])
            rows = rows[HEADING if early is None else early :]
        found[section] = tuple(row for row in rows if row.words)
    return found


def number(word: str) -> bool:
    """True for a finite number that MoorDyn reads to its end."""
    return bool(NUMBER.fullmatch(word)) and math.isfinite(float(word))


def _row(line: str, k: int) -> Row:
    return Row(tuple(takewhile(lambda word: "#" not in word, line.split())), k + 1)


def _is_data(row: Row) -> bool:
    """True if three words or more are numbers, and half of all, or the first one is 1."""
    numbers = sum(map(number, row.words))
    return numbers >= 3 and (2 * numbers >= len(row.words) or row.words[0] == "1")


def _section(line: str) -> str | None:
    title = line.upper()
    for section, spellings in TITLES.items():
        if any(spelling in title for spelling in spellings):
            return section
    return None
