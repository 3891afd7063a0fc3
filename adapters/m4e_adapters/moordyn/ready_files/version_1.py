"""Input files of MoorDyn version 1, which differ in the order of columns.

Source: the MoorDyn documentation, "The V1 Input File". MoorDyn 2.7.2 would take the length of a
line for the point where it begins.
"""

from __future__ import annotations

from m4e_adapters.moordyn.ready_files.read_file import ReadFile
from m4e_adapters.moordyn.ready_files.sections import Row, number

TYPE_WORDS = 9  # of a line type: without bending stiffness
POINTS = ("CONNECTION PROPERTIES", "NODE PROPERTIES")  # titles that version 2 takes as well
LINES = "ID LineType AttachA AttachB UnstrLen NumSegs Outputs"
TYPES = "Name Diam MassDen EA BA EI Cd Ca CdAx CaAx"


def is_version_1(file: ReadFile) -> bool:
    """True for a file of version 1; its first line type and its first line are then problems."""
    lines, types = file.rows("lines"), file.rows("line types")
    points = {row.words[0] for row in file.rows("points")}
    old_lines = bool(lines) and all(_is_old_line(row, points) for row in lines)
    old_types = bool(types) and all(_is_old_type(row) for row in types)
    if not old_lines and not (old_types and file.has_title(POINTS)):
        return False
    if old_types:
        message = "this is a line type of MoorDyn version 1: it has no bending stiffness EI"
        remedy = (
            f"convert the file to version 2: '{TYPES}', with EI 0; version 1 has Ca CaAx Cd CdAx"
        )
        file.wrong(types[0], message, remedy)
    if old_lines:
        message = "this is a line of MoorDyn version 1: length and segments stand before its ends"
        file.wrong(lines[0], message, f"convert the file to version 2: '{LINES}'")
    return True


def _is_old_line(row: Row, points: set[str]) -> bool:
    return {*row.words[4:6]} <= points and len(row.words) > 5 and not {*row.words[2:4]} <= points


def _is_old_type(row: Row) -> bool:
    return len(row.words) == TYPE_WORDS and all(map(number, row.words[1:]))
