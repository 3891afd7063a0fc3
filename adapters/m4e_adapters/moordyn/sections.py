"""The tables of a MoorDyn v2 input file, as MoorDyn itself finds them.

A line with ``---`` opens a section; a table begins after two more lines, names and units. Source:
the MoorDyn v2 documentation, "Inputs", and the behaviour of version 2.7.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

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


@dataclass(frozen=True)
class Row:
    """One line of a table: its words and its line number, from 1."""

    words: tuple[str, ...]
    line: int


def tables(text: str) -> dict[str, tuple[Row, ...]]:
    """The rows of every section that the file has, in file order, by the names in TITLES.

    Under "not supported" are the titles of sections that would be left out.
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
        first = opening + (1 if section in WITHOUT_HEADING else 3)
        rows = (Row(tuple(lines[k].split()), k + 1) for k in range(first, end))
        found[section] = tuple(row for row in rows if row.words)
    return found


def _section(line: str) -> str | None:
    title = line.upper()
    for section, spellings in TITLES.items():
        if any(spelling in title for spelling in spellings):
            return section
    return None
