"""A MoorDyn input file as rows of words with their places, and what is found wrong with it."""

from __future__ import annotations

import re
from pathlib import Path

from m4e_adapters.moordyn.ready_files.sections import Row, number, tables
from m4e_fmi.errors import InputError, Problem, missing_file
from m4e_fmi.files.file_kinds import check_named
from m4e_fmi.files.files_read import TooLongError, read_text
from m4e_fmi.files.limits import LARGEST_LINE_FILE

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
}
"""Names that MoorDyn takes as well (MoorDyn2.cpp, readOptionsLine)."""


class ReadFile:
    """Rows and options of one file; `problems` grows with what is found wrong.

    `options` are the rows of the options by MoorDyn's names in small letters, the last of each.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.problems: list[Problem] = []
        text = _text(path)
        self._lines = text.splitlines()
        self.tables = tables(text)
        self.options = {option_name(row): row for row in self.rows("options") if row.words[1:]}

    def rows(self, section: str) -> tuple[Row, ...]:
        """The rows of a section; none if it is not there."""
        return self.tables.get(section, ())

    def option(self, key: str, default: float) -> float:
        """The value of an option that is a number."""
        row = self.options.get(key)
        return float(row.words[0]) if row and number(row.words[0]) else default

    def has_title(self, titles: tuple[str, ...]) -> bool:
        """True if a section is opened with one of `titles`, in capitals."""
        heads = [line.upper() for line in self._lines if "---" in line]
        return any(title in head for head in heads for title in titles)

    @property
    def depth(self) -> float:
        """Depth [m] of the seabed: WtrDpth, or as MoorDyn has it that of the lowest point."""
        zs = [float(r.words[4]) for r in self.rows("points") if r.words[4:] and number(r.words[4])]
        return self.option("wtrdpth", max(0.0, -min(zs, default=0.0)))

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


def option_name(row: Row) -> str:
    """The name of an option, the same for all that MoorDyn calls it by."""
    name = row.words[1].lower()
    return ALIASES.get(name, name)


def has_force(row: Row) -> bool:
    """True if a row of a point has the three columns of a constant force.

    They stand before drag area and added mass; words behind those are a comment.
    """
    return len(row.words) >= FORCED_POINT and all(map(number, row.words[7:FORCED_POINT]))


def _text(path: Path) -> str:
    check_named(path, SUFFIXES, "MoorDyn file")
    try:
        text = read_text(path, encoding="utf-8-sig", largest=LARGEST_LINE_FILE)
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        message, remedy = missing_file(path, "MoorDyn file")
        raise InputError.single(message, remedy, keys=("file",)) from None
    except UnicodeDecodeError as error:
        message = f"cannot be read: byte {error.start + 1} is not valid UTF-8"
        remedy = "a MoorDyn input file is text: save it as UTF-8"
        raise InputError.single(message, remedy, str(path)) from None
    except (OSError, TooLongError) as error:
        raise InputError.single(f"MoorDyn file: {error}", "", str(path)) from None
    if not text.strip():
        remedy = "name a MoorDyn v2 input file, or describe the lines in the system file"
        raise InputError.single("MoorDyn file: it is empty", remedy, str(path))
    return text
