"""Files of WAMIT: FILE.1 (added mass, damping), FILE.3 (excitation), FILE.hst (hydrostatics).

Rows of the .1 file are PER I J A [B], PER the period, −1 at ω = 0 and 0 at ω = ∞, where there is no
B; of the .3 file PER BETA I MOD PHA RE IM; of the .hst file I J C. Modes 1 … 6N are those of N
bodies. Values are A/(ρ Lᵏ), B/(ρ ω Lᵏ), X/(ρ g Lᵐ), C/(ρ g Lᵏ) with the length L = 1, and waves
e^{+iωt}. Pairs of modes without rows are 0. (WAMIT User Manual, "Output files in numeric form".)
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.file_data import SIX, FileBody, FileData, refused
from m4e_fmi.errors import InputError, Problem, is_file
from m4e_fmi.files.csv_columns import shortened
from m4e_fmi.files.files_read import TooLongError, read_text
from m4e_fmi.files.limits import LARGEST_COEFFICIENTS

SUFFIXES = (".1", ".3", ".hst")
CONTENTS = {
    ".1": "added mass and damping",
    ".3": "excitation",
    ".hst": "hydrostatic stiffness",
}
ROWS = {".1": "PER I J A B", ".3": "PER BETA I MOD PHA RE IM", ".hst": "I J C"}
SAME = 1e-5  # relative difference of periods in two files that are the same
OFF_MODULUS, TRIFLE = 0.01, 1e-5  # of MOD, and of the largest: difference that is of rounding
NEAR, FAR = 0.3, 0.5  # relative errors of forces in long waves, and in waves that are not
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?|[-+]?nan|[-+]?inf", re.IGNORECASE)


@dataclass(frozen=True)
class Rows:
    """Numbers of `path`, row by row; row k stands in line `lines[k]`, from 1, of the `texts`."""

    path: Path
    values: list[list[float]] = field(repr=False)
    lines: list[int] = field(repr=False)
    texts: list[str] = field(repr=False)

    def problem(self, row: int, message: str, remedy: str = "") -> Problem:
        """A problem with a row; −1 is the last."""
        return self.at_line(self.lines[row], message, remedy)

    def at_line(self, line: int, message: str, remedy: str = "") -> Problem:
        """A problem with a line, from 1."""
        text = self.texts[line - 1]
        column, width = len(text) - len(text.lstrip()) + 1, max(1, len(text.strip()))
        return Problem(message, remedy, str(self.path), line, column, text, width)


def read_rows(
    path: Path, names: str, *, shorter: int = 0, finite: bool = False, largest: int
) -> Rows:
    """The rows of a file of up to `largest` bytes, which have a number for each of the `names`.

    The last `shorter` of them may be left out; a title may stand first. InputError with all
    problems: what is no number, or not `finite`, other numbers of numbers, no numbers.
    """
    try:
        texts = read_text(path, largest=largest).splitlines()
    except (TooLongError, UnicodeDecodeError, OSError) as error:
        what = "is not text" if isinstance(error, UnicodeDecodeError) else str(error)
        raise InputError.single(f"cannot be read: {what}", "", str(path)) from None
    rows, problems, most = Rows(path, [], [], texts), list[Problem](), len(names.split())
    for line, text in enumerate(texts, start=1):
        words = text.split()
        wrong = [word for word in words if not _NUMBER.fullmatch(word)]
        if not words or (line == 1 and wrong[:1] == words[:1]):
            continue  # WAMIT's first line is a title
        found = [] if wrong else [float(re.sub("[dD]", "E", word)) for word in words]
        wrong += [w for w, x in zip(words, found, strict=False) if finite and not math.isfinite(x)]
        if wrong:
            text = f"{wrong[0][:30]!r} is not a {'finite ' if finite else ''}number"
            problems.append(rows.at_line(line, text))
        elif not most - shorter <= len(words) <= most:
            counts = f"{most - shorter} or {most}" if shorter else f"{most}"
            text = f"a row has {counts} numbers, {names}, this one {len(words)}"
            remedy = "if it is the last one, the file was cut off: copy it again"
            problems.append(rows.at_line(line, text, remedy))
        else:
            rows.values.append(found)
            rows.lines.append(line)
    if not rows.values and not problems:
        problems.append(Problem("there are no numbers", f"its rows are {names}", str(path), 1))
    InputError.raise_for(shortened(problems))
    return rows


def read_wamit(path: Path) -> FileData:
    """The data of the three files of which `path` is one; InputError with all their problems."""
    problems: list[Problem] = []
    found: dict[str, Rows] = {}
    for suffix in SUFFIXES:
        try:
            found[suffix] = _rows(path.with_suffix(suffix), suffix)
        except InputError as error:
            problems += error.problems
    InputError.raise_for(problems)
    radiation = _radiation(found[".1"], problems)
    excitation = _excitation(found[".3"], problems)
    restoring = _restoring(found[".hst"], problems)
    InputError.raise_for(problems)
    return _assembled(path, found, radiation, excitation, restoring)


@dataclass(frozen=True)
class _Blocks:
    """Values [1] by period (s, −1, 0), n modes: (n, n), or (n,) by period and direction."""

    modes: int
    values: Mapping[tuple[float, ...], np.ndarray]


def _rows(path: Path, suffix: str) -> Rows:
    """The numbers of a file."""
    if is_file(path):
        shorter = 1 if suffix == ".1" else 0
        return read_rows(path, ROWS[suffix], shorter=shorter, largest=LARGEST_COEFFICIENTS)
    remedy = f"WAMIT's {suffix} file has the {CONTENTS[suffix]}: put it beside the others"
    raise refused(f"no such file: {path}", remedy)


def _modes(rows: Rows, columns: tuple[int, ...], problems: list[Problem]) -> int:
    """The number of modes, a multiple of six; 0 with a problem if some are no mode."""
    for k, row in enumerate(rows.values):
        for column in columns:
            if row[column] != int(max(row[column], 1)):
                text = f"mode {row[column]:g} is not a whole number from 1 on"
                problems.append(rows.problem(k, text, "modes are 1 … 6 of each body"))
                return 0
    most = int(max(row[column] for row in rows.values for column in columns))
    return SIX * math.ceil(most / SIX)


def _radiation(rows: Rows, problems: list[Problem]) -> _Blocks:
    """A + iB of each period."""
    modes = _modes(rows, (1, 2), problems)
    blocks: dict[tuple[float, ...], np.ndarray] = {}
    seen: dict[tuple[float, ...], set[tuple[int, ...]]] = {}
    for k, row in enumerate(rows.values if modes else ()):
        period, place = row[0], (int(row[1]) - 1, int(row[2]) - 1)
        key = (period if period > 0 else float(math.copysign(1, period) if period else 0),)
        if period > 0 and len(row) < 5:
            text = f"there is no damping at the period {period:g} s"
            problems.append(rows.problem(k, text, "a row of a period is PER I J A B"))
            return _Blocks(modes, {})
        if not _is_new(rows, k, key, place, seen, problems):
            return _Blocks(modes, {})
        block = blocks.setdefault(key, np.zeros((modes, modes), dtype=complex))
        block[place] = complex(row[3], row[4] if period > 0 else 0.0)
    _check_complete(rows, seen, problems)
    return _Blocks(modes, blocks)


def _excitation(rows: Rows, problems: list[Problem]) -> _Blocks:
    """X of each period and direction [deg], e^{+iωt}."""
    modes = _modes(rows, (2,), problems)
    trifle = TRIFLE * max(abs(row[3]) for row in rows.values)
    blocks: dict[tuple[float, ...], np.ndarray] = {}
    seen: dict[tuple[float, ...], set[tuple[int, ...]]] = {}
    for k, row in enumerate(rows.values if modes else ()):
        key, place = (row[0], row[1]), (int(row[2]) - 1,)
        if not _is_new(rows, k, key, place, seen, problems):
            return _Blocks(modes, {})
        if abs(math.hypot(row[5], row[6]) - row[3]) > OFF_MODULUS * row[3] + trifle:
            text = f"MOD is {row[3]:g}, that of RE and IM is {math.hypot(row[5], row[6]):g}"
            remedy = "a row is PER BETA I MOD PHA RE IM: write the file anew"
            problems.append(rows.problem(k, text, remedy))
            return _Blocks(modes, {})
        block = blocks.setdefault(key, np.zeros(modes, dtype=complex))
        block[place] = complex(row[5], row[6])
    _check_complete(rows, seen, problems)
    return _Blocks(modes, blocks)


def _restoring(rows: Rows, problems: list[Problem]) -> _Blocks:
    modes = _modes(rows, (0, 1), problems)
    block = np.zeros((modes, modes))
    seen: dict[tuple[float, ...], set[tuple[int, ...]]] = {}
    for k, row in enumerate(rows.values if modes else ()):
        place = (int(row[0]) - 1, int(row[1]) - 1)
        if not _is_new(rows, k, (), place, seen, problems):
            break
        block[place] = row[2]
    count = len(rows.values)
    if modes and count not in (modes**2, SIX * modes):
        text = f"the file ends early: of {modes} x {modes} coefficients {count} are there"
        problems.append(rows.problem(-1, text, "copy it again"))
    return _Blocks(modes, {(): block})


def _is_new(
    rows: Rows,
    k: int,
    key: tuple[float, ...],
    place: tuple[int, ...],
    seen: dict[tuple[float, ...], set[tuple[int, ...]]],
    problems: list[Problem],
) -> bool:
    """True for the first row of its period and modes; a second one is a problem."""
    places = seen.setdefault(key, set())
    if place in places:
        modes = ", ".join(str(p + 1) for p in place)
        text = f"a second row of the modes {modes}" + (f" at PER = {key[0]:g}" if key else "")
        problems.append(rows.problem(k, text, "remove one of them"))
        return False
    places.add(place)
    return True


def _check_complete(
    rows: Rows,
    seen: Mapping[tuple[float, ...], set[tuple[int, ...]]],
    problems: list[Problem],
) -> None:
    """A problem if some period lacks rows that others have."""
    every: set[tuple[int, ...]] = set().union(*seen.values())
    for key, places in seen.items():
        if len(places) == len(every):
            continue
        last = list(seen)[-1] == key
        text = f"PER = {key[0]:g} has {len(places)} rows, others have {len(every)}"
        remedy = "the file was cut off: copy it again" if last else "each period has all modes"
        row = max(k for k, values in enumerate(rows.values) if values[0] == key[0] or key[0] < 0)
        problems.append(rows.problem(-1 if last else row, text, remedy))
        return


def _assembled(
    path: Path,
    rows: Mapping[str, Rows],
    radiation: _Blocks,
    excitation: _Blocks,
    restoring: _Blocks,
) -> FileData:
    """One FileData of all; InputError where the files do not go together."""
    modes = {radiation.modes, excitation.modes, restoring.modes}
    if len(modes) > 1:
        shown = ", ".join(
            f"{rows[s].path.name} of {b.modes // SIX}"
            for s, b in zip(SUFFIXES, (radiation, excitation, restoring), strict=True)
        )
        raise refused(f"the files are of different numbers of bodies: {shown}")
    (n,) = modes
    periods = np.array([key[0] for key in radiation.values if key[0] > 0])
    if not len(periods):
        raise InputError([rows[".1"].problem(0, "there are no periods above 0")])
    directions = np.array(sorted({key[1] for key in excitation.values}))
    table = np.full((len(periods), len(directions), n), np.nan, dtype=complex)
    unknown = []
    for (period, beta), values in excitation.values.items():
        near = np.flatnonzero(np.abs(periods / period - 1.0) < SAME) if period > 0 else []
        if not len(near):
            unknown.append(period)
            continue
        table[near[0], int(np.searchsorted(directions, beta))] = values.conj()
    _check_periods(rows[".1"].path, periods, table, restoring.values[()])
    notes = []
    if unknown:
        shown = ", ".join(f"{p:g}" for p in dict.fromkeys(unknown))
        notes.append(
            f"{rows['.3'].path.name} has periods that the .1 file lacks, left out: {shown}"
        )
    omega = 2.0 * math.pi / periods
    blocks = np.array([radiation.values[(p,)] for p in periods.tolist()])
    infinite = radiation.values.get((0.0,))
    stiffness = restoring.values[()]
    return FileData(
        path=path,
        format="WAMIT",
        bodies=tuple(
            FileBody(f"body{k + 1}", stiffness[6 * k : 6 * k + 6, 6 * k : 6 * k + 6])
            for k in range(n // SIX)
        ),
        omega=omega,
        added_mass=np.real(blocks),
        damping=np.imag(blocks) * omega[:, None, None],
        added_mass_inf=None if infinite is None else np.real(infinite),
        directions=directions,
        excitation=table,
        notes=(*notes, "values of WAMIT are taken as those of the length scale ULEN = 1"),
    )


def _check_periods(
    path: Path, periods: np.ndarray, table: np.ndarray, stiffness: np.ndarray
) -> None:
    """InputError if the heave excitation is the stiffness where waves are short: no periods.

    `table` (nω, nβ, n) is X/(ρg) at the `periods` (nω,) [s], `stiffness` (n, n) K/(ρg).
    """
    heave = np.abs(table[:, 0, 2::SIX])
    own = stiffness.diagonal()[2::SIX]
    known = np.flatnonzero(np.isfinite(heave).all(axis=1))
    if not len(known) or not (own > 0).any():
        return
    shortest, longest = (known[pick(periods[known])] for pick in (np.argmin, np.argmax))
    off_short, off_long = (
        np.abs(heave[k, own > 0] / own[own > 0] - 1.0) for k in (shortest, longest)
    )
    if (off_long < NEAR).any() or not ((off_short < NEAR) & (off_long > FAR)).any():
        return
    raise refused(
        f"{path}: the first column is no period: the heave excitation is the hydrostatic stiffness "
        f"at PER = {periods[shortest]:g}, as in long waves, and not at {periods[longest]:g}",
        "it may be the angular frequency or the wavenumber: have WAMIT write periods [s] (IPEROUT "
        "= 1 in its .cfg file), or replace ω in the .1 and .3 files by 2π/ω",
    )
