"""A MoorDyn v2 input file that somebody else wrote, checked and made quiet.

Everything that would abort the process, be ignored silently, or make a state that cannot be saved
and restored is refused here. The physics of an accepted file is not touched; only its output
switches are turned off and its internal time step is written out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from m4e_adapters.moordyn.line_file import QUIET, header
from m4e_adapters.moordyn.mooring import Fairlead, Mooring, internal_step
from m4e_adapters.moordyn.sections import Row, tables
from m4e_adapters.moordyn.stability import SCHEMES, Segment, damping_of_ratio
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files_read import read_text

COUPLED = ("FAIRLEAD", "VESSEL", "VES", "COUPLED", "CPLD")
FIXED = ("ANCHOR", "FIXED", "FIX")
LINE_TYPE_WORDS, POINT_WORDS, LINE_WORDS = 10, 9, 7
POSITIVE = {1: "diameter", 2: "mass per length", 3: "stiffness EA"}
NOT_NEGATIVE = {
    5: "bending stiffness EI",
    6: "drag coefficient Cd",
    7: "added mass coefficient Ca",
    8: "axial drag coefficient CdAx",
    9: "axial added mass coefficient CaAx",
}
"""By column of the line types; a negative BA is a damping ratio."""
OTHER_FILES = {
    "wavekin": "water kinematics",
    "currents": "currents",
    "fileic": "initial conditions",
}
SEA_FLOOR = "seafloorfile"
ALIASES = {"dt": "dtm", "kb": "kbot", "cb": "cbot", "icfile": "fileic"}
"""Names that MoorDyn takes as well (MoorDyn2.cpp, readOptionsLine)."""
OURS = {"dtm", "cfl", "writelog", "disableoutput", "disableouttime", "writeunits", "dtout"}
DEFAULT_SEABED = {"kbot": 3.0e6, "cbot": 3.0e5}  # MoorDyn's own, Pa/m and Pa·s/m


def ready_mooring(
    path: str | Path, *, fairleads: Mapping[str, tuple[float, float] | None]
) -> Mooring:
    """The mooring of a MoorDyn file; its coupled points are the fairleads, in file order.

    `fairleads` names them and may give their start (x, z) [m]; empty: fairlead_1, fairlead_2, …
    The y of each stays as the file says. Lines are line_1, line_2, … InputError with every problem.
    """
    path = Path(path)
    try:
        text = read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else str(error)
        raise InputError.single(f"MoorDyn file: {reason}", "", str(path)) from None
    file = _ReadyFile(path, text)
    file.check()
    points = file.fairleads(fairleads)
    if file.problems:
        raise InputError(file.problems)
    step = internal_step(
        file.segments(), scheme=file.scheme(), wanted=file.time_step(), file=str(path)
    )
    return Mooring(
        text=file.quiet_text(step),
        fairleads=points,
        lines=tuple(f"line_{k + 1}" for k in range(len(file.rows("lines")))),
        time_step=step,
        static_duration=0.0,
        drawn=file.fairleads(dict.fromkeys(fairleads)),
    )


class _ReadyFile:
    """Reads one file; `problems` grows with what is found wrong."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self.problems: list[Problem] = []
        self._lines = text.splitlines()
        self._tables = tables(text)
        self._options = {_option_name(row): row for row in self.rows("options") if row.words[1:]}

    def rows(self, section: str) -> tuple[Row, ...]:
        return self._tables.get(section, ())

    def check(self) -> None:
        for section in ("line types", "points", "lines"):
            if not self.rows(section):
                self._wrong(None, f"the section {section.upper()} is missing or empty", "add it")
        for row in self.rows("line types"):
            self._check_line_type(row)
        for section in ("bodies", "rods"):
            for row in self.rows(section):
                kind = row.words[1] if len(row.words) > 1 else ""
                if kind.upper().startswith(COUPLED):
                    self._wrong(
                        row,
                        f"coupled {section} are not supported",
                        "attach the lines to coupled points, one for each fairlead",
                    )
        for row in self.rows("points"):
            if self._has_words(row, POINT_WORDS):
                self._numbers(row, range(2, POINT_WORDS))
        for row in self.rows("lines"):
            self._check_line(row)
        for row in self.rows("failure"):
            message = "line failures are not supported"
            self._wrong(row, message, "remove the section: a failure cannot be undone on a rewind")
        self._check_options()

    def fairleads(self, given: Mapping[str, tuple[float, float] | None]) -> tuple[Fairlead, ...]:
        """The coupled points, under the names of `given` if there are any."""
        rows = [r for r in self.rows("points") if len(r.words) > 4 and _is(r.words[1], COUPLED)]
        names = list(given) or [f"fairlead_{k + 1}" for k in range(len(rows))]
        if not rows:
            message = "there is no coupled point"
            self._wrong(None, message, "give the points that a body moves the type 'Coupled'")
        elif len(names) != len(rows):
            message = f"{len(rows)} coupled points, but {len(names)} names in 'fairleads'"
            self._wrong(rows[0], message, "name each coupled point, in the order of the file")
        if self.problems:
            return ()
        found = []
        for name, row in zip(names, rows, strict=True):
            x, y, z = (float(word) for word in row.words[2:5])
            x, z = given.get(name) or (x, z)
            found.append(Fairlead(name, x, y, z))
        return tuple(found)

    def scheme(self) -> str:
        row = self._options.get("tscheme")
        return row.words[0].upper() if row else "RK2"

    def time_step(self) -> float | None:
        """The internal step [s] that the file asks for; dtM goes before CFL, as in MoorDyn."""
        if "dtm" in self._options:
            return self._option("dtm", 0.0)
        segments = self.segments()
        if "cfl" not in self._options or not segments:
            return None
        period = min(
            2 * math.pi * s.length * math.sqrt(s.mass_per_length / s.axial_stiffness)
            for s in segments.values()
        )
        return self._option("cfl", 0.0) * period

    def segments(self) -> dict[str, Segment]:
        """A segment of every line that has moving nodes."""
        types = {row.words[0]: row.words for row in self.rows("line types")}
        points = {row.words[0]: row.words[1] for row in self.rows("points")}
        found = {}
        for k, row in enumerate(self.rows("lines")):
            _, name, *ends, length, count = row.words[:6]
            held = all(_is(points.get(end, "Free"), (*FIXED, *COUPLED)) for end in ends)
            if int(count) == 1 and held:
                continue
            d, m, ea, ba, ei = (float(word) for word in types[name][1:6])
            piece = float(length) / int(count)
            found[f"line_{k + 1}"] = Segment(
                length=piece,
                diameter=d,
                mass_per_length=m,
                axial_stiffness=ea,
                damping=ba
                if ba >= 0
                else damping_of_ratio(-ba, length=piece, mass_per_length=m, axial=ea),
                bending_stiffness=ei,
                seabed_stiffness=self._option("kbot", DEFAULT_SEABED["kbot"]),
                seabed_damping=self._option("cbot", DEFAULT_SEABED["cbot"]),
            )
        return found

    def quiet_text(self, time_step: float) -> str:
        """The file with `time_step` [s] written out and without anything that writes files."""
        lines = list(self._lines)
        for row in self.rows("lines"):
            lines[row.line - 1] = " ".join([*row.words[: LINE_WORDS - 1], "-"])
        dropped = {row.line for row in self.rows("outputs")}
        dropped |= {
            row.line for row in self.rows("options") if row.words[1:] and _option_name(row) in OURS
        }
        kept = [line for k, line in enumerate(lines) if k + 1 not in dropped]
        ours = [f"{value} {key}" for value, key in (*QUIET, (repr(time_step), "dtM"))]
        place = next((k for k, line in enumerate(kept) if _opens_options(line)), None)
        if place is None:
            kept = [*_until_outputs(kept), header("OPTIONS")]
            place = len(kept) - 1
            ours.append(header("END"))
        return "\n".join([*kept[: place + 1], *ours, *kept[place + 1 :], ""])

    def _check_line_type(self, row: Row) -> None:
        if not self._has_words(row, LINE_TYPE_WORDS):
            return
        if not self._numbers(row, range(1, LINE_TYPE_WORDS)):
            return
        for k, what in POSITIVE.items():
            if float(row.words[k]) <= 0:
                self._wrong(row, f"{what} must be positive", f"got {row.words[k]}")
        for k, what in NOT_NEGATIVE.items():
            if float(row.words[k]) < 0:
                self._wrong(row, f"{what} must not be negative", f"got {row.words[k]}")
        if any(float(word) != 0 for word in row.words[10:11] if _number(word)):
            message = "vortex-induced vibration (Cl) is not supported"
            self._wrong(row, message, "set Cl to 0: MoorDyn does not save its state")

    def _check_line(self, row: Row) -> None:
        if not self._has_words(row, LINE_WORDS) or not self._numbers(row, (4, 5)):
            return
        types = [r.words[0] for r in self.rows("line types")]
        if row.words[1] not in types:
            message = f"there is no line type {row.words[1]!r}"
            self._wrong(row, message, suggestion(row.words[1], types, "line types"))
        points = [r.words[0] for r in self.rows("points")]
        for end in row.words[2:4]:
            if end.isdigit() and end not in points:
                message = f"there is no point {end}"
                self._wrong(row, message, suggestion(end, points, "points"))
        if float(row.words[4]) <= 0:
            message = f"unstretched length {row.words[4]} is not positive"
            self._wrong(row, message, "give the length in metres")
        if not row.words[5].isdigit() or int(row.words[5]) < 1:
            message = f"{row.words[5]} segments"
            self._wrong(row, message, "a line needs a whole number of segments, at least 1")

    def _check_options(self) -> None:
        scheme = self._options.get("tscheme")
        if scheme and self.scheme() not in SCHEMES:
            message = f"time scheme {scheme.words[0]} is not supported"
            self._wrong(scheme, message, f"use one of {', '.join(SCHEMES)}")
        for key, what in OTHER_FILES.items():
            row = self._options.get(key)
            if row and row.words[0] != "0":
                message = f"{row.words[1]} {row.words[0]}: {what} from files are not supported"
                self._wrong(row, message, f"set {row.words[1]} to 0")
        if SEA_FLOOR in self._options:
            row = self._options[SEA_FLOOR]
            message = f"{row.words[1]} {row.words[0]}: a sea floor from a file is not supported"
            self._wrong(row, message, "remove the line: the sea floor is flat, at WtrDpth")
        for key in ("dtm", "cfl", "kbot", "cbot", "wtrdpth"):
            row = self._options.get(key)
            if not row or not self._numbers(row, (0,)):
                continue
            if key in ("dtm", "cfl") and float(row.words[0]) <= 0:
                self._wrong(row, f"{row.words[1]} must be positive", "or leave it out")
            if key in ("kbot", "cbot") and float(row.words[0]) < 0:
                self._wrong(row, f"{row.words[1]} must not be negative", "or leave it out")

    def _option(self, key: str, default: float) -> float:
        row = self._options.get(key)
        return float(row.words[0]) if row else default

    def _has_words(self, row: Row, count: int) -> bool:
        if len(row.words) < count:
            message = f"{count} values are needed here, {len(row.words)} are given"
            self._wrong(row, message, "is this a file of MoorDyn version 2?")
        return len(row.words) >= count

    def _numbers(self, row: Row, places: range | tuple[int, ...]) -> bool:
        bad = [row.words[k] for k in places if not _number(row.words[k])]
        for word in bad:
            remedy = "tables in other files, and curves, are not supported: give a constant"
            self._wrong(row, f"{word!r} is not a number", remedy)
        return not bad

    def _wrong(self, row: Row | None, message: str, remedy: str) -> None:
        if row is None:
            self.problems.append(Problem(message, remedy, str(self.path)))
            return
        text = self._lines[row.line - 1]
        width = len(text.strip())
        column = len(text) - len(text.lstrip()) + 1
        self.problems.append(
            Problem(message, remedy, str(self.path), row.line, column, text, width)
        )


def _is(word: str, kinds: tuple[str, ...]) -> bool:
    return word.upper() in kinds


def _option_name(row: Row) -> str:
    """The name of an option, the same for all that MoorDyn calls it by."""
    name = row.words[1].lower()
    return ALIASES.get(name, name)


def _number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def _opens_options(line: str) -> bool:
    return "---" in line and "OPTIONS" in line.upper()


def _until_outputs(lines: list[str]) -> list[str]:
    opening = next((k for k, x in enumerate(lines) if "---" in x and "OUTPUT" in x.upper()), None)
    return lines[:opening]
