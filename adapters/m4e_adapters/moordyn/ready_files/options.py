"""The options of a MoorDyn file: their names, their values, and those that are not supported."""

from __future__ import annotations

import re

from m4e_adapters.moordyn.ready_files.columns import Column, no_number, out_of_range
from m4e_adapters.moordyn.ready_files.read_file import ReadFile, option_name
from m4e_adapters.moordyn.ready_files.sections import Row, number
from m4e_fmi.errors import suggestion

RANGES: dict[str, tuple[float, float]] = {
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
CHOSEN = {"dtm": "a stable internal step is chosen"}
"""The effect of leaving an option out, where it is not MoorDyn's own default."""


def check_options(file: ReadFile) -> None:
    """Note unknown options, values that cannot be meant, and two values of one option."""
    first: dict[str, Row] = {}
    for row in file.rows("options"):
        if len(row.words) < 2:
            file.wrong(row, "an option needs a value and a name", "write '0.001 dtM'")
            continue
        key = option_name(row)
        _check_option(file, row, key)
        before = first.setdefault(key, row)
        if not _same(before.words[0], row.words[0]):
            message = (
                f"{row.words[1]} {row.words[0]}: line {before.line} gives "
                f"{before.words[1]} {before.words[0]}"
            )
            file.wrong(row, message, "MoorDyn takes the last one: remove one of the two lines")
    _check_files(file)
    if "wtrdpth" not in file.options and file.rows("lines"):
        row = (file.rows("options") or file.rows("lines"))[-1]
        message = "the depth of the water, WtrDpth, is missing in OPTIONS"
        file.wrong(row, message, "add it below, in m: '200 WtrDpth'")
    row = file.options.get("tscheme")
    if row and not SCHEMES.fullmatch(row.words[0]):
        message = f"there is no time scheme {row.words[0]!r}"
        file.wrong(row, message, "use RK2 or RK4", 0)


def _check_option(file: ReadFile, row: Row, key: str) -> None:
    value, name = row.words[:2]
    if key not in RANGES and key not in WORDS:
        spelled = name if not number(name) else value
        remedy = suggestion(spelled.lower(), {*RANGES, *WORDS}, "options")
        file.wrong(row, f"unknown option {name!r}", remedy, 1)
    elif key in RANGES and not number(value):
        remedy = "tables in other files are not supported: give a constant"
        if value.upper() == "DEFAULT":
            without = CHOSEN.get(key, "MoorDyn takes its own default")
            remedy = f"remove the line: without it, {without}"
        file.wrong(row, *no_number(name, value, remedy), 0)
    elif key in RANGES and not RANGES[key][0] <= float(value) <= RANGES[key][1]:
        file.wrong(row, *out_of_range(Column(name, *RANGES[key]), value), 0)


def _check_files(file: ReadFile) -> None:
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


def _same(a: str, b: str) -> bool:
    return a == b or (number(a) and number(b) and float(a) == float(b))
