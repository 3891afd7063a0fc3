"""What is checked of a MoorDyn file before MoorDyn sees it.

MoorDyn 2.7.2 ends the process, says little, hangs or goes on silently with much of what is found
here.
"""

from __future__ import annotations

import math
import re

from m4e_adapters.moordyn.attachments import Attachments
from m4e_adapters.moordyn.read_file import ReadFile, has_force, number, option_name
from m4e_adapters.moordyn.sections import Row
from m4e_fmi.errors import suggestion

COLUMNS = {"line types": 10, "rod types": 7, "bodies": 14, "rods": 11, "points": 9, "lines": 7}
NUMBERED = ("bodies", "rods", "points", "lines")
Range = tuple[str, float, float]
LINE_TYPE: dict[int, Range] = {
    1: ("diameter", 1e-6, 1e3),
    2: ("mass per length", 1e-6, 1e6),
    3: ("stiffness EA", 1e-3, 1e15),
    4: ("damping BA", -1e6, 1e15),
    5: ("bending stiffness EI", 0.0, 1e15),
    6: ("drag coefficient Cd", 0.0, 1e3),
    7: ("added mass coefficient Ca", 0.0, 1e3),
    8: ("axial drag coefficient CdAx", 0.0, 1e3),
    9: ("axial added mass coefficient CaAx", 0.0, 1e3),
}
"""Name, least and largest value [SI] by column; a negative BA is a damping ratio."""
PLACE = ("coordinate", -1e7, 1e7)
POINT: dict[int, Range] = {
    **dict.fromkeys((2, 3, 4), PLACE),
    5: ("mass", 0.0, 1e12),
    6: ("volume", 0.0, 1e9),
}
FORCE = ("constant force", -1e12, 1e12)
DRAG, ADDED_MASS = ("drag area CdA", 0.0, 1e9), ("added mass coefficient CA", 0.0, 1e3)
LINE: dict[int, Range] = {4: ("unstretched length", 1e-3, 1e6), 5: ("number of segments", 1, 1000)}
OPTIONS: dict[str, tuple[float, float]] = {
    "dtm": (1e-6, 1e3),
    "cfl": (1e-6, 1e3),
    "g": (1e-6, 1e3),
    "rho": (0.0, 1e5),
    "wtrdpth": (0.0, 1e5),
    "kbot": (0.0, 1e15),
    "cbot": (0.0, 1e15),
    "dtic": (1e-6, 1e4),
    "tmaxic": (0.0, 1e5),
    "cdscaleic": (1e-6, 1e6),
    "threshic": (0.0, 1e6),
    "icgendynamic": (0.0, 1.0),
    "wavekin": (0.0, 7.0),
    "dtwave": (0.0, 1e6),
    "currents": (0.0, 5.0),
    "unifycurrentgrid": (0.0, 1.0),
    "writelog": (0.0, 3.0),
    "writeunits": (0.0, 1.0),
    "frictioncoefficient": (0.0, 1e3),
    "fricdamp": (0.0, 1e15),
    "statdynfricscale": (0.0, 1e6),
    "dtout": (0.0, 1e6),
    "disableoutput": (0.0, 1.0),
    "disableouttime": (0.0, 1.0),
}
"""Least and largest value of the options that are numbers (MoorDyn2.cpp, readOptionsLine)."""
WORDS = ("tscheme", "fileic", "seafloorfile")
SCHEMES = re.compile(
    r"l?euler|heun|rk[24]|l?ab[234]|(beuler|midpoint|aca|wilson)\d+", re.IGNORECASE
)
FROM_FILES = {"wavekin": "water kinematics", "currents": "currents"}
CLOSE = 1e-6  # [m] between the ends of a line that are at the same place


def check(file: ReadFile) -> None:
    """Note everything in `file` that cannot be run."""
    for section in ("line types", "points", "lines"):
        if not file.rows(section):
            file.wrong(None, f"the section {section.upper()} is missing or empty", "add it")
    short = {
        row for section in COLUMNS for row in file.rows(section) if _is_short(file, section, row)
    }
    for section in NUMBERED:
        _check_numbers_of(file, section)
    names: set[str] = set()
    for row in file.rows("line types"):
        if row.words[0] in names:
            file.wrong(row, f"the line type {row.words[0]!r} is given twice", "rename one of them")
        names.add(row.words[0])
        if row not in short:
            _check_ranges(file, row, LINE_TYPE)
            _check_lift(file, row)
    for row in file.rows("points"):
        if row not in short:
            force = dict.fromkeys((7, 8, 9), FORCE) if has_force(row) else {}
            last = 7 + len(force)
            _check_ranges(file, row, {**POINT, **force, last: DRAG, last + 1: ADDED_MASS})
    for row in file.rows("lines"):
        if row not in short:
            _check_line(file, row, names)
    for row in file.rows("failure"):
        remedy = "remove the section: a failure cannot be undone on a rewind"
        file.wrong(row, "line failures are not supported", remedy)
    for title in file.tables.get("not supported", ()):
        file.wrong(title, "this section is not supported", "remove it")
    _check_options(file)
    if not short and not file.problems:
        Attachments(file).check()


def check_places(file: ReadFile, places: dict[str, tuple[float, float, float]]) -> None:
    """Note points below the seabed and lines between points at one place [m], world frame."""
    for row in file.rows("points"):
        z = places[row.words[0]][2]
        if z < -file.depth - CLOSE:
            message = (
                f"point {row.words[0]} at z = {z:g} m is below the seabed at {-file.depth:g} m"
            )
            file.wrong(row, message, f"raise it, or make WtrDpth at least {-z:g}")
    for row in file.rows("lines"):
        ends = [places[end] for end in row.words[2:4] if end in places]
        if len(ends) == 2 and math.dist(*ends) < CLOSE:
            message = f"both ends of line {row.words[0]} are at one place"
            file.wrong(row, message, "MoorDyn cannot lay out such a line: move one of its points")


def _is_short(file: ReadFile, section: str, row: Row) -> bool:
    count = COLUMNS[section]
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
            file.wrong(row, message, remedy, row.words[0])
            return


def _check_ranges(file: ReadFile, row: Row, ranges: dict[int, Range]) -> None:
    for k, (what, least, largest) in ranges.items():
        word = row.words[k]
        if not number(word):
            remedy = f"give the {what} as a number; tables in other files are not supported"
            file.wrong(row, f"{what}: {word!r} is not a number", remedy, word)
        elif not least <= float(word) <= largest:
            file.wrong(row, *_out_of_range(what, word, least, largest), word)


def _out_of_range(what: str, word: str, least: float, largest: float) -> tuple[str, str]:
    value = float(word)
    if value < 0 <= least:
        return f"{what} must not be negative, got {word}", "check its sign"
    if value == 0 < least:
        return f"{what} must be positive, got {word}", "give its value in SI units"
    limits = f"between {least:g} and {largest:g}"
    return f"{what} {word} cannot be meant", f"give a value {limits}, in SI units"


def _check_lift(file: ReadFile, row: Row) -> None:
    for word in row.words[10:11]:
        if not number(word) or float(word) != 0:
            message = "vortex-induced vibration (Cl) is not supported"
            file.wrong(row, message, "set Cl to 0: MoorDyn does not save its state", word)


def _check_line(file: ReadFile, row: Row, types: set[str]) -> None:
    if row.words[1] not in types:
        message = f"there is no line type {row.words[1]!r}"
        file.wrong(row, message, suggestion(row.words[1], types, "line types"), row.words[1])
    _check_ranges(file, row, LINE)
    if number(row.words[5]) and float(row.words[5]) != int(float(row.words[5])):
        message = f"{row.words[5]} segments"
        file.wrong(row, message, "a line needs a whole number of segments", row.words[5])


def _check_options(file: ReadFile) -> None:
    known = {**dict.fromkeys(WORDS), **OPTIONS}
    for row in file.rows("options"):
        if len(row.words) < 2:
            file.wrong(row, "an option needs a value and a name", "write '0.001 dtM'")
            continue
        key, (value, name) = option_name(row), row.words[:2]
        if key not in known:
            spelled = name if not number(name) else value
            remedy = suggestion(spelled.lower(), known, "options")
            file.wrong(row, f"unknown option {name!r}", remedy, name)
        elif key in OPTIONS and not number(value):
            remedy = "tables in other files are not supported: give a constant"
            file.wrong(row, f"{name}: {value!r} is not a number", remedy, value)
        elif key in OPTIONS and not OPTIONS[key][0] <= float(value) <= OPTIONS[key][1]:
            file.wrong(row, *_out_of_range(name, value, *OPTIONS[key]), value)
    for key, what in FROM_FILES.items():
        row = file.options.get(key)
        given_by_api = key == "wavekin" and row and row.words[0] == "1"
        if row and number(row.words[0]) and float(row.words[0]) != 0 and not given_by_api:
            message = f"{row.words[1]} {row.words[0]}: {what} from files are not supported"
            file.wrong(row, message, f"set {row.words[1]} to 0")
    row = file.options.get("seafloorfile")
    if row:
        message = f"{row.words[1]} {row.words[0]}: a sea floor from a file is not supported"
        file.wrong(row, message, "remove the line: the sea floor is flat, at WtrDpth")
    row = file.options.get("tscheme")
    if row and not SCHEMES.fullmatch(row.words[0]):
        message = f"there is no time scheme {row.words[0]!r}"
        file.wrong(row, message, "use RK2 or RK4", row.words[0])
