"""A MoorDyn v2 input file as rows of words with their places, as MoorDyn itself finds them.

A line with ``---`` opens a section; a table begins after two more lines, names and units. A word
with ``#`` begins a comment. Source: the MoorDyn v2 documentation, "Inputs", and the behaviour of
version 2.7.2.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise, takewhile
from pathlib import Path
from types import MappingProxyType

from m4e_fmi.errors import InputError, Problem, missing_file
from m4e_fmi.files.file_kinds import check_named
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_LINE_FILE

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
    "syrope ic": ("SYROPE IC",),
    "failure": ("FAILURE",),
    "control": ("CONTROL",),
    "external loads": ("EXTERNAL",),
    "options": ("OPTIONS",),
    "outputs": ("OUTPUT",),
}
TABLES = ("line types", "rod types", "bodies", "rods", "points", "lines", "syrope ic")
HEADING = 2  # lines of a table before its rows: names and units
HEADLESS = (
    "one of two lines above the rows of this table, names and units, is missing",
    "write it above this row, as '(-) (-)'",
)
STRANGE = (
    "the section of this row is unknown, or there a second time",
    f"sections are {', '.join((*TABLES, 'failure', 'options')).upper()}",
)
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
WORD = re.compile(r"\S+")
SUFFIXES = (".dat", ".txt", ".inp", ".in", ".moordyn", ".md")  # of names of files
FORCED_POINT = 12  # words of a point on which a force acts
ALIASES = {
    "dt": "dtm",
    "gravity": "g",
    "wtrdnsty": "rho",
    "kb": "kbot",
    "cb": "cbot",
    "icdt": "dtic",
    "ictmax": "tmaxic",
    "icdfac": "cdscaleic",
    "icthresh": "threshic",
    "gendynamicic": "icgendynamic",
    "icfile": "fileic",
    "mu_kt": "frictioncoefficient",
    "mu_ka": "frictioncoefficient",
    "cv": "fricdamp",
    "mc": "statdynfricscale",
}
"""Names that MoorDyn takes as well (MoorDyn2.cpp, readOptionsLine), and those of MoorDyn-F."""


@dataclass(frozen=True)
class Row:
    """One line of a table: its words and its line number, from 1."""

    words: tuple[str, ...]
    line: int


class ReadFile:
    """Rows and options of one file; `problems` and `notes` grow with what is found in it.

    `options` are the rows of the options by MoorDyn's names in small letters, the last of each;
    `given` are values of options that the file may leave out; `text` is its content if there is no
    file at `path`.
    `lost` are rows that MoorDyn skips, as of `tables`.
    """

    def __init__(
        self,
        path: Path,
        given: Mapping[str, float] = MappingProxyType({}),
        *,
        text: str | None = None,
    ) -> None:
        self.path = path
        self.problems: list[Problem] = []
        self.notes: list[str] = []
        text = _text(path) if text is None else text
        self._lines = text.splitlines()
        self.tables, self.lost = tables(text)
        self.options = {option_name(row): row for row in self.rows("options") if row.words[1:]}
        for key, value in given.items():
            row = self.options.setdefault(key, Row((repr(value), key), 0))
            if number(row.words[0]) and float(row.words[0]) != value:
                message = f"{' '.join(row.words[1::-1])}: `water` of the component gives {value:g}"
                self.wrong(row, message, "remove one of the two")

    def rows(self, section: str) -> tuple[Row, ...]:
        """The rows of a section; none if it is not there."""
        return self.tables.get(section, ())

    def option(self, key: str, default: float) -> float:
        """The value of an option that is a number."""
        row = self.options.get(key)
        return float(row.words[0]) if row and number(row.words[0]) else default

    @property
    def depth(self) -> float:
        """Depth [m] of the seabed, WtrDpth."""
        return self.option("wtrdpth", 0.0)

    def wrong(self, row: Row | None, message: str, remedy: str, column: int | None = None) -> None:
        """Note a problem: with the file, a row or its word in a `column`, from 0."""
        if row is None:
            self.problems.append(Problem(message, remedy, str(self.path)))
            return
        text = self._lines[row.line - 1]
        words = list(WORD.finditer(text))
        first, last = (0, -1) if column is None else (column, column)
        at, end = words[first].start(), words[last].end()
        self.problems.append(
            Problem(message, remedy, str(self.path), row.line, at + 1, text, end - at)
        )


def tables(text: str) -> tuple[dict[str, tuple[Row, ...]], list[tuple[Row, str, str]]]:
    """The rows of every section of a file, by the names in TITLES, and those that MoorDyn skips.

    These are, with reason and remedy, the first rows of tables whose names or units are missing,
    and of sections of an unknown title, or of one that was there before.
    """
    lines = text.splitlines()
    openings = [k for k, line in enumerate(lines) if "---" in line]
    found: dict[str, tuple[Row, ...]] = {}
    lost = []
    for opening, end in pairwise([*openings, len(lines)]):
        title = lines[opening].upper()
        section = next((s for s, known in TITLES.items() if any(k in title for k in known)), None)
        rows = [_row(lines[k], k) for k in range(opening + 1, end)]
        if section is None or section in found:
            lost += [(row, *STRANGE) for row in rows if _is_data(row)][:1]
            continue
        if section not in ("options", "outputs"):
            early = next((k for k, row in enumerate(rows[:HEADING]) if _is_data(row)), HEADING)
            lost += [(row, *HEADLESS) for row in rows[early:HEADING][:1]]
            rows = rows[early:]
        found[section] = tuple(row for row in rows if row.words)
    return found, lost


def number(word: str) -> bool:
    """True for a finite number that MoorDyn reads to its end."""
    return bool(NUMBER.fullmatch(word)) and math.isfinite(float(word))


def option_name(row: Row) -> str:
    """The name of an option, the same for all that MoorDyn calls it by."""
    name = row.words[1].lower()
    return ALIASES.get(name, name)


def has_force(row: Row) -> bool:
    """True if a row of a point has the three columns of a constant force.

    They stand before drag area and added mass; words behind those are a comment.
    """
    return len(row.words) >= FORCED_POINT and all(map(number, row.words[7:FORCED_POINT]))


def _row(line: str, k: int) -> Row:
    return Row(tuple(takewhile(lambda word: "#" not in word, line.split())), k + 1)


def _is_data(row: Row) -> bool:
    """True if three words or more are numbers, and half of all, or the first one is 1."""
    numbers = sum(map(number, row.words))
    return numbers >= 3 and (2 * numbers >= len(row.words) or row.words[0] == "1")


def _text(path: Path) -> str:
    check_named(path, SUFFIXES, "MoorDyn file")
    try:
        content = read_bytes(path, largest=LARGEST_LINE_FILE)
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        message, remedy = missing_file(path, "MoorDyn file")
        raise InputError.single(message, remedy, keys=("file",)) from None
    except (OSError, TooLongError) as error:
        message = f"MoorDyn file cannot be read: {error}"
        raise InputError.single(message, "name a MoorDyn v2 input file", str(path)) from None
    return content.decode("utf-8-sig", "replace")  # older files have units like m³ in latin-1
