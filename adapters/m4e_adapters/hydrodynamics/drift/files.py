"""Files of drift, of any format: for a body of the configuration, about its centre of gravity.

WAMIT's second-order files: mean drift (.7, .8, .9) and difference-frequency QTFs (.10d … .12d).

Rows are PER BETA1 BETA2 I MOD PHA RE IM, and PER1 PER2 BETA1 BETA2 I MOD PHA RE IM. Forces are
over ρ g L A², moments over ρ g L² A², with the length scale L; phases are those of e^{+iωt}, so
that QTFs are conjugated here. Motions 6 (N − 1) + 1 … 6 N are those of body N. A pair of periods
may stand in one order only: the other is its complex conjugate. (WAMIT User Manual, "Output files
in numeric form"; for the second order the manual of WAMIT V2.)
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.wamit import Rows, read_rows
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Drift, Water
from m4e_adapters.hydrodynamics.drift.tables import (
    SAME_DIRECTION,
    VERTICAL,
    BodyDrift,
    Entry,
    MeanDrift,
    Qtf,
    about,
    gridded,
    mean_table,
    of_motions,
    wrapped,
)
from m4e_adapters.hydrodynamics.geometry.motions import (
    MOTIONS,
    SPACE,
    SURGE,
    SWAY,
    YAW,
    Motion,
    point_in_space,
)
from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.files.csv_columns import read_columns, shortened
from m4e_fmi.files.limits import LARGEST_QTF

MEAN_SUFFIXES = (".7", ".8", ".9")
QTF_SUFFIXES = (".10d", ".11d", ".12d")
MEAN_ROW = "PER BETA1 BETA2 I MOD PHA RE IM"
QTF_ROW = "PER1 PER2 BETA1 BETA2 I MOD PHA RE IM"
UNLIKE = 2e-3  # of the largest value of a motion: rounding of files is below
_TAIL = 7  # BETA1 BETA2 I MOD PHA RE IM


def read_mean(path: Path, *, body: int, scale: float, weight: float) -> MeanDrift:
    """Mean drift in surge, sway and yaw of the `body`, from 1.

    `scale` is L [m], `weight` ρ g [N/m3]. InputError with all problems of the file.
    """
    rows = _read(path, MEAN_ROW)
    entries, notes = _entries(rows, body=body, scale=scale, weight=weight)
    kept = [entry for entry in entries if entry.motion not in VERTICAL]
    if len(kept) < len(entries):
        notes.append("its heave, roll and pitch are left out: means do not tell how they vary")
    return replace(mean_table(path.name, kept, rows.problem), notes=tuple(notes))


def read_qtf(path: Path, *, body: int, scale: float, weight: float) -> Qtf:
    """QTFs of all motions of the `body` in the file, as `read_mean`."""
    rows = _read(path, QTF_ROW)
    entries, notes = _entries(rows, body=body, scale=scale, weight=weight)
    omega, directions, motions, values = gridded(entries, rows.problem)
    values = np.moveaxis(values.conj(), (2, 3), (0, 1))
    mirrored = values.conj().swapaxes(2, 3)
    both = np.where(np.isnan(values), mirrored, values)
    missing = np.argwhere(np.isnan(both))
    if len(missing):
        b, m, i, j = missing[0]
        text = (
            f"{len(missing)} of {both.size} pairs are missing: the first is {motions[m].name} at "
            f"{omega[i]:.6g} and {omega[j]:.6g} rad/s, {directions[b]:g} deg"
        )
        remedy = "a QTF needs all pairs of its periods, in one order; was the file cut off?"
        raise InputError([rows.problem(-1, text, remedy)])
    _check_hermitian(rows, entries, both, (omega, directions, motions))
    hermitian = 0.5 * (both + both.conj().swapaxes(2, 3))
    return Qtf(path.name, omega, directions, motions, hermitian, tuple(notes))


def _read(path: Path, names: str) -> Rows:
    if not is_file(path):
        raise InputError.single(*missing_file(path, "file of drift forces"))
    return read_rows(path, names, finite=True, largest=LARGEST_QTF)


def _check_hermitian(
    rows: Rows,
    entries: Sequence[Entry],
    both: np.ndarray,
    axes: tuple[np.ndarray, np.ndarray, tuple[Motion, ...]],
) -> None:
    """InputError if a pair is not the conjugate of the same pair in the other order."""
    omega, directions, motions = axes
    largest = np.abs(both).max(axis=(2, 3), keepdims=True)
    apart = np.abs(both - both.conj().swapaxes(2, 3)) > UNLIKE * largest
    if not apart.any():
        return
    b, m, i, j = np.argwhere(apart)[0]
    entry = next(
        entry
        for entry in entries
        if np.searchsorted(omega, entry.omega).tolist() in ([i, j], [j, i])
        and entry.motion is motions[m]
        and wrapped(entry.direction) == directions[b]
    )
    text = f"{motions[m].name} at {omega[i]:.6g} and {omega[j]:.6g} rad/s "
    if i == j:
        text += f"has the imaginary part {-complex(both[b, m, i, i]).imag:.4g}: mean drift is real"
    else:
        text += "is not the complex conjugate of the pair in the other order"
    remedy = "a difference-frequency QTF is Hermitian: is it a file of differences, and undamaged?"
    raise InputError([rows.problem(entry.row, text, remedy)])


def _entries(
    rows: Rows, *, body: int, scale: float, weight: float
) -> tuple[list[Entry], list[str]]:
    """Values of the body with equal directions, in SI units, and what is told of the others."""
    problems = [problem for k in range(len(rows.values)) for problem in _wrong(rows, k)]
    if problems:
        raise InputError(shortened(problems))
    first = 6 * (body - 1) + 1
    found, crossed, modes = list[Entry](), 0, set[int]()
    for k, row in enumerate(rows.values):
        *periods, one, other, mode, _, _, real, imaginary = row
        modes.add(int(mode))
        if not first <= mode <= first + 5:
            continue
        if abs(math.remainder(one - other, 360.0)) > SAME_DIRECTION:
            crossed += 1
            continue
        motion = SPACE[int(mode) - first]
        unit = weight * (scale**2 if motion.is_rotation else scale)
        omega = tuple(2.0 * math.pi / period for period in periods)
        found.append(Entry(k, omega, one, motion, unit * complex(real, imaginary)))
    if not found:
        raise _nothing(rows, body, modes, crossed)
    notes = [f"{crossed} rows of pairs of directions are left out"] if crossed else []
    return found, notes


def _nothing(rows: Rows, body: int, modes: set[int], crossed: int) -> InputError:
    if crossed:
        text = "no row has BETA1 = BETA2"
        return InputError([rows.problem(0, text, "compute pairs of one direction")])
    bodies = sorted({(mode - 1) // 6 + 1 for mode in modes})
    text = f"no row is of body {body}: the file has motions of {', '.join(map(str, bodies))}"
    return InputError([rows.problem(0, text, "correct drift.body")])


def _wrong(rows: Rows, k: int) -> Iterator[Problem]:
    """Problems of the values of a row."""
    row = rows.values[k]
    _, _, mode, modulus, _, real, imaginary = row[-_TAIL:]
    for period in row[:-_TAIL]:
        if period <= 0:
            text = f"the period {period:g} s is not positive"
            yield rows.problem(k, text, "WAMIT writes periods [s]: leave limiting ones out")
            return
    if mode < 1 or mode != int(mode):
        text = f"motion {mode:g} is not a whole number from 1 on"
        yield rows.problem(k, text, f"rows are {MEAN_ROW}, of pairs with two periods")
    elif abs(abs(modulus) - math.hypot(real, imaginary)) > UNLIKE * abs(modulus) + 1e-6:
        text = f"MOD {modulus:g} is not the modulus of RE {real:g} and IM {imaginary:g}"
        yield rows.problem(k, text, "the row is damaged, or its columns are others")


FORMATS = "formats: CSV, WAMIT's .7, .8, .9 (mean drift), .10d, .11d, .12d (QTFs of differences)"
UNITS = {"omega": "rad/s", "direction": "deg", "surge": "N/m2", "sway": "N/m2", "yaw": "N.m/m2"}
"""Of the numbers in columns whose names say none, and of those that are read."""


def read_drift(
    section: Drift, *, center: tuple[float, ...], water: Water | Coefficients, folder: Path
) -> BodyDrift:
    """The drift of a body about its `center` of gravity [m]; its file is in `folder`.

    InputError with all problems of the file.
    """
    path = folder / section.file
    motions = MOTIONS[len(center)]
    suffix = path.suffix.lower()
    if suffix == ".csv":
        for key in sorted({"body", "length_scale"} & section.model_fields_set):
            text = f"'{key}' has no effect on a CSV file, which is of one body and in SI units"
            raise InputError.single(text, "remove it", keys=("drift", key))
        table = _read_csv(path, [m.name for m in (SURGE, SWAY, YAW) if m in motions])
    elif suffix in (*MEAN_SUFFIXES, *QTF_SUFFIXES):
        read = read_mean if suffix in MEAN_SUFFIXES else read_qtf
        weight = water.density * water.gravity
        table = read(path, body=section.body, scale=section.length_scale, weight=weight)
    else:
        text = f"{path.name}: the suffix {suffix!r} is not one of drift forces"
        raise InputError.single(text, FORMATS, keys=("drift", "file"))
    point = point_in_space(section.reference_point or center)
    arm = np.subtract(point, point_in_space(center)).tolist()
    return BodyDrift(of_motions(about(table, arm), motions), (arm[0], arm[1]))


def _read_csv(path: Path, names: list[str]) -> MeanDrift:
    columns = read_columns(path, [(name, UNITS[name]) for name in ("omega", "direction", *names)])
    omega, directions, *values = columns.values
    problems = list[Problem]()
    for row, value in enumerate(omega):
        if value <= 0:
            text = f"omega {value:g} rad/s is not positive"
            problems.append(columns.problem(row, text, "leave the row out"))
    if not omega:
        remedy = "write omega, direction and forces"
        problems.append(Problem("has no rows", remedy, str(columns.path)))
    if problems:
        raise InputError(shortened(problems))
    by_name = {motion.name: motion for motion in (SURGE, SWAY, YAW)}
    entries = [
        Entry(row, (omega[row],), directions[row], by_name[name], value)
        for name, column in zip(names, values, strict=True)
        for row, value in enumerate(column)
    ]
    return mean_table(path.name, entries, columns.problem)
