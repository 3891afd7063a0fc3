"""Files that a MoorDyn file names, or MoorDyn looks for beside it: to travel with the mooring.

Curves of line types (EA, BA, EI; the Syrope model), water kinematics, currents and the seabed.
Source: MoorDyn2.cpp `readLineProps`, `read_curve`, `read_syrope_working_curves`, Waves.cpp `setup`,
Seafloor.cpp; the MoorDyn documentation, "Inputs".
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from m4e_adapters.moordyn.ready_files.read_file import ReadFile, Row
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_LINE_FILE

WATER: dict[str, dict[int, tuple[str, ...]]] = {
    "wavekin": {
        0: (),
        1: (),
        2: ("wave_frequencies.txt", "water_grid.txt"),
        3: ("wave_elevation.txt", "water_grid.txt"),
        7: ("wave_frequencies.txt",),
    },
    "currents": {
        0: (),
        1: ("current_profile.txt",),
        2: ("current_profile_dynamic.txt",),
        5: ("current_profile_4d.txt",),
    },
}
"""Files of the water by option and its value; MoorDyn takes other values for still water."""
CURVES = (3, 4, 5)  # words of a line type: EA, BA, EI
DAMPING = 4
SYROPE = "SYROPE:"  # of an EA before the name of its file
HEADING = 3  # lines of a curve before its rows
READ_AS_NUMBER = re.compile(r"[+-]?(\.?\d|inf|nan)", re.IGNORECASE)  # the start of a word
OWC = re.compile(rb"(\S+)[ \t]+OWC\b", re.IGNORECASE)  # of a Syrope model: the name of its curve
OWN = "lines.txt"  # MoorDyn's input, beside which the files are put

Slopes = tuple[float, float, float]
"""Steepest and least slope of a curve, and its largest value."""


@dataclass
class NamedFiles:
    """Contents of the files of `file`, by the names that its rows have from then on.

    `curves` holds the slopes of each curve, by its name.
    """

    file: ReadFile
    contents: dict[str, bytes] = field(default_factory=dict)
    curves: dict[str, Slopes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for option, files in WATER.items():
            row, value = self.file.options.get(option), self.file.option(option, 0.0)
            if row is None:
                continue
            if value not in files:
                message = f"MoorDyn leaves the water still with {row.words[1]} {row.words[0]}"
                self.file.wrong(row, message, f"use one of {', '.join(map(str, files))}", 0)
            for name in files.get(int(value), ()):
                self._take(row, 0, name)
        row = self.file.options.get("seafloorfile")
        if row:  # MoorDyn looks in the folder that a program runs in
            name = self._take(row, 0, row.words[0], self.file.path.absolute().parents)
            self.file.options["seafloorfile"] = replace(row, words=(name, *row.words[1:]))
        self.file.tables["line types"] = tuple(
            replace(row, words=tuple(self._line_type(row))) for row in self.file.rows("line types")
        )

    def _line_type(self, row: Row) -> Iterator[str]:
        """The words of a line type with the names that its files have here."""
        for k, word in enumerate(row.words):
            first, *more = word.split("|")
            name = first.removeprefix(SYROPE)
            if k in CURVES and not READ_AS_NUMBER.match(name):
                here = self._take(row, k, name)
                if first == name:
                    self._read_curve(row, k, here)
                else:
                    self._read_working_curve(row, k, here)
                word = "|".join((first.removesuffix(name) + here, *more))
            yield word

    def _take(self, row: Row, k: int, name: str, folders: Iterable[Path] = ()) -> str:
        """The name here of the file that a word of `row` names; its content is in `contents`."""
        places = [folder / name for folder in (self.file.path.parent, *folders)]
        path = next(filter(Path.is_file, places), places[0])
        try:
            # MoorDyn refuses a curve with a line that is empty
            content = read_bytes(path, largest=LARGEST_LINE_FILE).rstrip()
        except (OSError, ValueError, TooLongError):
            message = f"the file {name!r} cannot be read"
            self.file.wrong(row, message, f"put it beside {self.file.path.name}", k)
            return name
        here = path.name
        while here == OWN or self.contents.get(here, content) != content:
            here = f"_{here}"
        self.contents[here] = content
        return here

    def _read_curve(self, row: Row, k: int, name: str) -> None:
        """Note the slopes of a curve, of (x, y) row by row, or what is wrong with it."""
        try:
            lines = self.contents.get(name, b"").decode("latin-1").splitlines()[HEADING:]
            rows = [tuple(map(float, line.split()[:2])) for line in lines]
            slopes = [(y - b) / (x - a) for (a, b), (x, y) in pairwise(rows)]
            self.curves[name] = max(slopes), min(slopes), max(y for _, y in rows)
            fits = rows == sorted(rows) and k != DAMPING
        except (ValueError, ZeroDivisionError):
            fits = False
        if not fits and name in self.contents:
            message = f"{name} is not two columns of numbers, the first ascending"
            if k == DAMPING:  # it divides by the rate of stretching
                message = "MoorDyn fails with a curve of damping BA where a line does not move"
            self.file.wrong(row, message, "give one number, or mend the file", k)

    def _read_working_curve(self, row: Row, k: int, name: str) -> None:
        """Take the curve that a file of the Syrope model names, and let it name the one here."""
        found = OWC.search(self.contents.get(name, b""))
        if found:
            curve = self._take(row, k, found[1].decode("latin-1"))
            self._read_curve(row, k, curve)
            self.contents[name] = OWC.sub(
                lambda _: f"{curve} OWC".encode(), self.contents[name], count=1
            )
            self.curves[name] = self.curves.get(curve, (0.0, 0.0, 0.0))
