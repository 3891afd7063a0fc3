"""Checks of a MoorDyn file before MoorDyn sees it.

With many of these faults MoorDyn 2.7.2 ends the process, says little, hangs or goes on silently.
"""

from __future__ import annotations

import math

from m4e_adapters.moordyn.ready_files.attachments import FREE, Attachments
from m4e_adapters.moordyn.ready_files.columns import WORDS, check_columns
from m4e_adapters.moordyn.ready_files.options import check_options
from m4e_adapters.moordyn.ready_files.read_file import ReadFile
from m4e_adapters.moordyn.ready_files.sections import Row, number
from m4e_adapters.moordyn.ready_files.version_1 import is_version_1
from m4e_fmi.errors import suggestion

NUMBERED = ("bodies", "rods", "points", "lines")
TYPES = {"line types": "line type", "rod types": "rod type"}
CLOSE = 1e-6  # [m] between the ends of a line that are at the same place


def check(file: ReadFile) -> None:
    """Note everything in `file` that cannot be run; of a file of version 1, that it is one."""
    if is_version_1(file):
        return
    short = _check_structure(file)
    whole = not file.problems  # else rows may be attached to what was not read
    _check_headings(file)
    for section in WORDS:
        for row in file.rows(section):
            if row not in short:
                check_columns(file, section, row)
    _check_types(file, short)
    for row in file.rows("failure"):
        remedy = (
            "remove the section: MoorDyn cannot roll back before a failure, as repetition requires"
        )
        file.wrong(row, "line failures are not supported", remedy)
    for title in file.tables.get("not supported", ()):
        file.wrong(title, "this section is not supported", "remove it")
    check_options(file)
    if whole:
        Attachments(file).check()


def check_places(file: ReadFile, places: dict[str, tuple[float, float, float]]) -> None:
    """Note what is below the seabed, and lines and rods without length; places [m], world frame."""
    for row in file.rows("points"):
        z = places[row.words[0]][2]
        if z < -file.depth - CLOSE:
            message = (
                f"point {row.words[0]} at z = {z:g} m is below the seabed at {-file.depth:g} m"
            )
            file.wrong(row, message, f"raise it, or make WtrDpth at least {-z:g}")
    for row in file.rows("rods"):
        _check_rod_ends(file, row)
    for row in file.rows("lines"):
        ends = [places[end] for end in row.words[2:4] if end in places]
        if len(ends) == 2 and math.dist(*ends) < CLOSE:
            message = f"both ends of line {row.words[0]} are at one place"
            file.wrong(row, message, "MoorDyn cannot lay out such a line: move one of its points")


def _check_rod_ends(file: ReadFile, row: Row) -> None:
    ends = [float(word) for word in row.words[3:9]]
    if math.dist(ends[:3], ends[3:]) < CLOSE and float(row.words[9]) > 0:
        message = f"both ends of rod {row.words[0]} are at one place"
        file.wrong(row, message, "move one, or give a rod without length 0 segments")
    lowest = min(ends[2], ends[5])
    if row.words[2].upper() in FREE and lowest < -file.depth - CLOSE:
        message = f"rod {row.words[0]} at z = {lowest:g} m is below the seabed at {-file.depth:g} m"
        file.wrong(row, message, f"raise it, or make WtrDpth at least {-lowest:g}")


def _check_structure(file: ReadFile) -> set[Row]:
    """Note missing sections and wrong numbers; the rows that are too short."""
    for section in ("line types", "points", "lines"):
        if not file.rows(section):
            file.wrong(None, f"the section {section.upper()} is missing or empty", "add it")
    short = {
        row for section in WORDS for row in file.rows(section) if _is_short(file, section, row)
    }
    for section in NUMBERED:
        _check_numbers_of(file, section)
    return short


def _check_headings(file: ReadFile) -> None:
    for row in file.tables.get("no heading", ()):
        section = next(name for name in WORDS if row in file.rows(name))
        message = (
            f"one of two lines above the rows of {section.upper()}, names and units, is missing"
        )
        remedy = "write it above this row, as '(-) (-)': MoorDyn would leave this row out instead"
        file.wrong(row, message, remedy)


def _is_short(file: ReadFile, section: str, row: Row) -> bool:
    count = WORDS[section]
    if len(row.words) >= count:
        return False
    message = f"{count} values are needed here, {len(row.words)} are given"
    file.wrong(row, message, "is this a file of MoorDyn version 2?")
    return True


def _check_numbers_of(file: ReadFile, section: str) -> None:
    for k, row in enumerate(file.rows(section)):
        if row.words[0] != str(k + 1):
            message = f"number {row.words[0]} where {k + 1} is expected"
            remedy = f"number the {section} 1, 2, 3, … in the order of the file"
            file.wrong(row, message, remedy, 0)
            return


def _check_types(file: ReadFile, short: set[Row]) -> None:
    for section, noun in TYPES.items():
        names: set[str] = set()
        for row in file.rows(section):
            if row.words[0] in names:
                file.wrong(row, f"the {noun} {row.words[0]!r} is given twice", "rename one of them")
            names.add(row.words[0])
    for row in file.rows("line types"):
        _check_lift(file, row)
    types = {row.words[0] for row in file.rows("line types")}
    for row in file.rows("lines"):
        if row not in short and row.words[1] not in types:
            remedy = suggestion(row.words[1], types, "line types")
            file.wrong(row, f"there is no line type {row.words[1]!r}", remedy, 1)


def _check_lift(file: ReadFile, row: Row) -> None:
    for k, word in enumerate(row.words[10:11], 10):
        if not number(word) or float(word) != 0:
            message = "vortex-induced vibration (Cl) is not supported"
            file.wrong(row, message, "set Cl to 0: MoorDyn does not save its state", k)
