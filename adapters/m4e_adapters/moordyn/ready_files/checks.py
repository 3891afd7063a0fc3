"""Checks of a MoorDyn file: by MoorDyn itself, and before that of its silent mistakes.

MoorDyn 2.7.2 reads of a word as many characters as make a number, and 0 where there are none; it
leaves rows without a heading out, and runs with masses below zero.
"""

from __future__ import annotations

import math
import re
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from m4e_adapters.moordyn.line_file import header, table
from m4e_adapters.moordyn.ready_files.attachments import ENDS, FREE, ends_of
from m4e_adapters.moordyn.ready_files.named_files import (
    CURVES,
    OWN,
    READ_AS_NUMBER,
    SYROPE,
    NamedFiles,
)
from m4e_adapters.moordyn.ready_files.read_file import (
    HEADING,
    TABLES,
    ReadFile,
    Row,
    has_force,
    number,
    option_name,
)
from m4e_fmi.errors import suggestion

Column = tuple[str, float, float]
"""Name of a number, its least and its largest value [SI; degrees]."""
PLACE, ANGLE = ("coordinate", -1e7, 1e7), ("angle", -360.0, 360.0)
MASS, VOLUME, DIAMETER = ("mass", 0.0, 1e12), ("volume", 0.0, 1e9), ("diameter", 1e-6, 1e3)
DRAG, ADDED_MASS = ("drag coefficient Cd", 0.0, 1e3), ("added mass coefficient Ca", 0.0, 1e3)
COLUMNS: dict[str, dict[int, Column]] = {
    "line types": {
        1: DIAMETER,
        2: ("mass per length", 1e-6, 1e6),
        3: ("stiffness EA", 1e-3, 1e15),
        4: ("damping BA", -1e6, 1e15),  # a negative one is a damping ratio
        5: ("bending stiffness EI", 0.0, 1e15),
        6: DRAG,
        7: ADDED_MASS,
        8: ("axial drag coefficient CdAx", 0.0, 1e3),
        9: ("axial added mass coefficient CaAx", 0.0, 1e3),
        10: ("lift coefficient Cl", 0.0, 1e3),
    },
    "rod types": {
        1: DIAMETER,
        2: ("mass per length", 0.0, 1e9),
        3: DRAG,
        4: ADDED_MASS,
        5: ("drag coefficient of the ends CdEnd", 0.0, 1e3),
        6: ("added mass coefficient of the ends CaEnd", 0.0, 1e3),
    },
    "bodies": {
        **dict.fromkeys((2, 3, 4), PLACE),
        **dict.fromkeys((5, 6, 7), ANGLE),
        8: MASS,
        9: ("centre of gravity", -1e7, 1e7),
        10: ("moment of inertia", 0.0, 1e18),
        11: VOLUME,
        12: ("drag area CdA", 0.0, 1e15),  # of rotations [m⁵], too
        13: ADDED_MASS,
    },
    "rods": {
        **dict.fromkeys(range(3, 9), PLACE),
        9: ("number of segments", 0, 1000),  # 0: a rod without length
    },
    "points": {
        **dict.fromkeys((2, 3, 4), PLACE),
        5: MASS,
        6: VOLUME,
        7: ("drag area CdA", 0.0, 1e9),
        8: ADDED_MASS,
    },
    "points with a force": {
        **dict.fromkeys((2, 3, 4), PLACE),
        5: MASS,
        6: VOLUME,
        **dict.fromkeys((7, 8, 9), ("constant force", -1e12, 1e12)),
        10: ("drag area CdA", 0.0, 1e9),
        11: ADDED_MASS,
    },
    "lines": {4: ("unstretched length", 1e-3, 1e6), 5: ("number of segments", 1, 1000)},
    "syrope ic": {1: ("tension Tmax0", 0.0, 1e15), 2: ("tension Tmean0", 0.0, 1e15)},
    "failure": {3: ("time of failure", 0.0, 1e12), 4: ("tension of failure", 0.0, 1e15)},
}
SEVERAL = {
    *(("bodies", k) for k in (9, 10, 12, 13)),
    *(("line types", k) for k in CURVES),
}
"""Columns of values with | in between."""
SEGMENTS = {"rods": 9, "lines": 5}  # column of their number, which is whole; outputs stand behind
OPTIONS: dict[str, tuple[float, float]] = {
    "dtm": (1e-6, 1e3),
    "cfl": (1e-6, 1e3),
    "g": (0.0, 1e3),
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
ELSEWHERE = ("outswitch", "inertialf", "inertialf_rampt", "waterkin", "wavekin_rampt")
"""Options of MoorDyn-F that MoorDyn-C does not know."""
PASSED = ("tscheme", "wtrdpth", "wavekin", "dtwave", "currents", "unifycurrentgrid", "seafloorfile")
"""Options of which MoorDyn itself is asked."""
FRICTION = ("mu_kt", "mu_ka")  # of MoorDyn-F, across the line and along it
CLOSE = 1e-6  # [m] between the ends of a line that are at the same place
MOST_STEPS = 1e7  # internal steps on the way to the initial state
CREATE = """\
import moordyn
lines = moordyn.Create('lines.txt')
places = [float(k) for k in range(moordyn.NCoupledDOF(lines))]
if {waves}: moordyn.Init_NoIC(lines, places, [0.0] * len(places))
"""
LONGEST = 60.0  # [s] for MoorDyn to read a file
SOURCE_PLACE = re.compile(r"^ERR \S+:\d+ \w+\(\): *", re.MULTILINE)
AT_LINE = re.compile(r"Error in lines.txt at line (\d+):?\s*('.*'\n)?")


def check(file: ReadFile, named: NamedFiles) -> None:
    """Note everything in `file` and the files that it names which MoorDyn refuses or misreads."""
    if not any(map(file.rows, ("lines", "rods", "bodies"))):
        remedy = "add it, or name a MoorDyn v2 input file"
        file.wrong(None, "the section LINES is missing or empty", remedy)
        return
    for row, message, remedy in file.lost:
        file.wrong(row, message, f"MoorDyn would leave it out: {remedy}")
    for section in (*TABLES, "failure"):
        for row in file.rows(section):
            _check_numbers(file, section, row)
    for section in ("line types", "rod types"):
        names = [row.words[0] for row in file.rows(section)]
        for k, row in enumerate(file.rows(section)):
            if row.words[0] in names[:k]:
                file.wrong(row, f"the type {row.words[0]!r} is given twice", "rename one of them")
    for row in (*file.rows("control"), *file.rows("external loads")):
        message = "only MoorDyn-F has a section CONTROL or EXTERNAL LOADS"
        file.wrong(row, message, "remove the section")
    if not file.problems:
        _check_by_moordyn(file, named)
    _check_options(file)


def check_places(file: ReadFile, places: dict[str, tuple[float, float, float]]) -> None:
    """Note what is below the seabed, and lines and rods without length; places [m], world frame."""
    heights = [
        (row, f"point {row.words[0]}", places[row.words[0]][2]) for row in file.rows("points")
    ]
    heights += [
        (row, f"rod {row.words[0]}", min(float(row.words[5]), float(row.words[8])))
        for row in file.rows("rods")
        if row.words[2].upper() in FREE
    ]
    for row, what, z in heights:
        if z < -file.depth - CLOSE and "seafloorfile" not in file.options:
            message = f"{what} at z = {z:g} m is below the seabed at {-file.depth:g} m"
            file.wrong(row, message, f"raise it, or make WtrDpth at least {-z:g}")
    for row in file.rows("rods"):
        ends = [float(word) for word in row.words[ENDS]]
        if math.dist(ends[:3], ends[3:]) < CLOSE and float(row.words[9]) > 0:
            message = f"both ends of rod {row.words[0]} are at one place"
            file.wrong(row, message, "move one, or give a rod without length 0 segments")
    for row in file.rows("lines"):
        ends = [places[end] for end in ends_of(row) if end in places]
        if len(ends) == 2 and math.dist(*ends) < CLOSE:
            message = f"both ends of line {row.words[0]} are at one place"
            file.wrong(row, message, "MoorDyn cannot lay out such a line: move one of its points")


def _check_numbers(file: ReadFile, section: str, row: Row) -> None:
    """Note the words of `row` that are not numbers, or none that can be meant."""
    forced = section == "points" and has_force(row)
    columns = COLUMNS["points with a force" if forced else section]
    for k, (name, least, largest) in columns.items():
        word = row.words[k] if k < len(row.words) else ""
        values = word.split("|") if (section, k) in SEVERAL else [word]
        whole = SEGMENTS.get(section) == k
        curve = section == "line types" and k in CURVES
        for n, value in enumerate(values if word else ()):
            limits = (min(least, 0.0) if n else least, largest)
            if n or not curve or READ_AS_NUMBER.match(value.removeprefix(SYROPE)):
                _check_number(file, row, k, name, value, limits, whole=whole)


def _check_number(
    file: ReadFile,
    row: Row,
    k: int,
    name: str,
    word: str,
    limits: tuple[float, float],
    *,
    whole: bool = False,
) -> None:
    fits = number(word) and limits[0] <= float(word) <= limits[1]
    if fits and (not whole or float(word).is_integer()):
        return
    kind = "whole number" if whole else "number"
    message = f"{name}: {word!r} is not a {kind} between {limits[0]:g} and {limits[1]:g}"
    remedy = "give all columns in SI units (angles in degrees); remove an option for its default"
    file.wrong(row, message, remedy, k)


def _check_options(file: ReadFile) -> None:
    """Note unknown options, values that cannot be meant, and two values of one option."""
    for row in file.rows("options"):
        if len(row.words) < 2:
            file.wrong(row, "an option needs a value and a name", "write '0.001 dtM'")
            continue
        key, (value, name) = option_name(row), row.words[:2]
        if key in OPTIONS:
            _check_number(file, row, 0, name, value, OPTIONS[key])
        elif key not in (*WORDS, *ELSEWHERE):
            remedy = suggestion(name.lower(), {*OPTIONS, *WORDS}, "options")
            file.wrong(row, f"unknown or unsupported option {name!r}", remedy, 1)
        last = file.options[key]
        if last.words[0] != value and last.line != row.line:
            goes = " ".join(last.words[1::-1])
            file.notes.append(f"{goes} (line {last.line}) goes before {name} {value} of the file")
    friction = [r for r in file.rows("options") if "".join(r.words[1:2]).lower() in FRICTION]
    if (len(friction) % 2 and any(r.words[0].strip("0.") for r in friction)) or (
        len({row.words[0] for row in friction}) > 1
    ):
        message = "MoorDyn-C has one friction coefficient, along the line and across"
        file.wrong(friction[-1], message, f"give both {' and '.join(FRICTION)}, the same")
    unknown = [" ".join(file.options[key].words[1::-1]) for key in ELSEWHERE if key in file.options]
    if unknown:
        still = ", so that the water is still without `waves` of the component"
        file.notes.append(
            f"options of MoorDyn-F without an effect: {', '.join(unknown)}"
            f"{still if 'waterkin' in file.options else ''}"
        )
    steps = file.option("tmaxic", 0.0) / max(file.option("dtm", 1.0), OPTIONS["dtm"][0])
    if steps > MOST_STEPS and not file.problems:
        message = f"the initial state would take up to {steps:.3g} internal steps"
        file.wrong(file.options["tmaxic"], message, "give a smaller TmaxIC")
    if "wtrdpth" not in file.options:
        row = (file.rows("options") or file.rows("lines") or file.rows("bodies") or (None,))[-1]
        message = "the depth of the water, WtrDpth, is missing in OPTIONS"
        remedy = "add it below, in m: '200 WtrDpth', or to the component: 'water: {depth: 200}'"
        file.wrong(row, message, remedy)


def _check_by_moordyn(file: ReadFile, named: NamedFiles) -> None:
    """Note what MoorDyn says of the tables of `file`, at the row that it names."""
    text = ["MoorDyn v2 input file"]
    rows: dict[int, Row] = {}
    for section in TABLES:
        rows |= enumerate(file.rows(section), len(text) + HEADING + 2)
        text += table(section, [" ".join(row.words) for row in file.rows(section)])
    options = [row for key, row in file.options.items() if key in PASSED]
    text += [header("OPTIONS"), *(" ".join(row.words[:2]) for row in options), header("END"), ""]
    waves = file.option("wavekin", 0.0) > 1
    said = _said("\n".join(text), tuple(named.contents.items()), waves=waves)
    if said:
        at = AT_LINE.search(said)
        message = f"MoorDyn refuses it: {' '.join(AT_LINE.sub('', said).split())}"
        remedy = "see the inputs of MoorDyn v2 in its documentation"
        if "ModuleNotFoundError" in said:
            remedy = "pip install moordyn"
        file.wrong(rows.get(int(at[1])) if at else None, message, remedy)


@cache
def _said(text: str, files: tuple[tuple[str, bytes], ...], *, waves: bool) -> str:
    """The errors that MoorDyn has for an input file; a wrong file can end its process."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / OWN).write_text(text, encoding="utf-8")
        for name, content in files:
            (Path(folder) / name).write_bytes(content)
        command = [sys.executable, "-c", CREATE.format(waves=waves)]
        try:
            run = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=LONGEST, check=False
            )
        except subprocess.TimeoutExpired:
            return f"it has not read it after {LONGEST:g} s"
    said = run.stdout + run.stderr
    if "ERR " in said:
        return SOURCE_PLACE.sub("", said[said.index("ERR ") :].partition("Error (-")[0])
    return (said.splitlines() or [f"it ended with {run.returncode}"])[-1] if run.returncode else ""
