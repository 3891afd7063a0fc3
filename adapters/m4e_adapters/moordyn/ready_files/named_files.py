"""Files that a MoorDyn file names, or MoorDyn looks for beside it: to travel with the mooring.

Curves of line types (EA, BA, EI; the Syrope model), water kinematics, currents and the seabed.
Source: MoorDyn2.cpp `readLineProps`, `read_curve`, `read_syrope_working_curves`, Waves.cpp `setup`,
Seafloor.cpp; the MoorDyn documentation, "Inputs".
"""

from __future__ import annotations

import re
from collections.abc import Iterable
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
OWN = "lines.txt"  # MoorDyn's input, beside which the files are put


@dataclass
class NamedFiles:
    """Contents of the files of `file`, by the names that its rows have from then on.

    `curves` holds the steepest slope and the largest value of each curve, by its name.
    """

    file: ReadFile
    contents: dict[str, bytes] = field(default_factory=dict)
    curves: dict[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for option, files in WATER.items():
            row = self.file.options.get(option)
            value = self.file.option(option, 0.0)
            if row and value not in files:
                message = (
                    f"{row.words[1]} {row.words[0]} is not one of {', '.join(map(str, files))}"
                )
                self.file.wrong(row, message, "MoorDyn would leave the water still", 0)
            for name in files.get(int(value), ()) if row else ():
                self._take(row, 0, name)
        row = self.file.options.get("seafloorfile")
        if row:  # MoorDyn looks in the folder that a program runs in
            name = self._take(row, 0, row.words[0], folders=self.file.path.absolute().parents)
            self.file.options["seafloorfile"] = replace(row, words=(name, *row.words[1:]))
        rows = self.file.rows("line types")
        self.file.tables["line types"] = tuple(map(self._line_type, rows))

    def _line_type(self, row: Row) -> Row:
        """The same line type with the names that its files have here."""
        words = list(row.words)
        for k in CURVES:
            first, *more = words[k].split("|") if k < len(words) else ("0",)
            name = first.removeprefix(SYROPE)
            if READ_AS_NUMBER.match(name):
                continue
            if k == DAMPING:  # it divides by the rate of stretching
                message = "MoorDyn fails with a curve of damping BA where a line does not move"
                self.file.wrong(row, message, "give one number", k)
            name = self._take(row, k, name)
            if first.startswith(SYROPE):
                words[k] = "|".join((SYROPE + self._working_curve(row, k, name), *more))
            else:
                words[k] = "|".join((self._curve(row, k, name), *more))
        return replace(row, words=tuple(words))

    def _take(self, row: Row, k: int, name: str, folders: Iterable[Path] = ()) -> str:
        """The name here of the file that a word of `row` names; its content is in `contents`."""
        for folder in folders or (self.file.path.parent,):
            try:
                # MoorDyn refuses a curve with a line that is empty
                content = read_bytes(folder / name, largest=LARGEST_LINE_FILE).rstrip()
            except TooLongError as error:
                self.file.wrong(row, f"{name} {error}", "shorten it", k)
            except (OSError, ValueError):
                continue
            else:
                here = Path(name).name
                while here == OWN or self.contents.get(here, content) != content:
                    here = f"_{here}"
                self.contents[here] = content
                return here
        message = f"the file {name!r} is not beside {self.file.path.name}"
        self.file.wrong(row, message, "put it there", k)
        return name

    def _curve(self, row: Row, k: int, name: str) -> str:
        """Note what is wrong with a curve, of (x, y) row by row from 0 on; its name."""
        lines = self._lines(name)[HEADING:] if name in self.contents else ["0 0", "1 0"]
        try:
            rows = [tuple(map(float, line.split()[:2])) for line in lines if line.strip()]
            slopes = [(y - b) / (x - a) for (a, b), (x, y) in pairwise(rows)]
            self.curves[name] = max(slopes), max(y for _, y in rows)
            if rows != sorted(rows):
                raise ValueError
        except (ValueError, ZeroDivisionError):
            message = f"{name} is not a table of two columns of numbers, the first ascending"
            self.file.wrong(row, message, f"below {HEADING} lines of heading", k)
        return name

    def _working_curve(self, row: Row, k: int, name: str) -> str:
        """The file of the Syrope model with the name that its curve has here; its own name."""
        lines = self._lines(name)
        for n, words in enumerate(map(str.split, lines)):
            if len(words) > 1 and words[1].lower() == "owc":
                curve = self._curve(row, k, self._take(row, k, words[0]))
                lines[n] = f"{curve} OWC"
                self.contents[name] = "\n".join([*lines, ""]).encode()
                self.curves[name] = self.curves.get(curve, (0.0, 0.0))
        return name

    def _lines(self, name: str) -> list[str]:
        return self.contents.get(name, b"").decode("latin-1").splitlines()
