"""Files of drift, of any format: for a body of the configuration, about its centre of gravity."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import Drift, Water
from m4e_adapters.hydrodynamics.drift.tables import (
    BodyDrift,
    Entry,
    MeanDrift,
    about,
    mean_table,
    of_motions,
)
from m4e_adapters.hydrodynamics.drift.wamit_files import (
    MEAN_SUFFIXES,
    QTF_SUFFIXES,
    read_mean,
    read_qtf,
)
from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, SURGE, SWAY, YAW, point_in_space
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.csv_columns import Columns, read_columns, shortened

FORMATS = "formats: CSV, WAMIT's .7, .8, .9 (mean drift), .10d, .11d, .12d (QTFs of differences)"
UNITS = {"omega": "rad/s", "direction": "deg", "surge": "N/m2", "sway": "N/m2", "yaw": "N.m/m2"}
"""Of the numbers in columns whose names say none, and of those that are read."""


def read_drift(
    section: Drift, *, center: tuple[float, ...], water: Water, folder: Path
) -> BodyDrift:
    """The drift of a body about its `center` of gravity [m]; its file is in `folder`.

    InputError with all problems of the file.
    """
    path = folder / section.file
    motions = MOTIONS[len(center)]
    suffix = path.suffix.lower()
    if suffix == ".csv":
        _check_plain(section)
        table = _read_csv(path, [m.name for m in (SURGE, SWAY, YAW) if m in motions])
    elif suffix in (*MEAN_SUFFIXES, *QTF_SUFFIXES):
        read = read_mean if suffix in MEAN_SUFFIXES else read_qtf
        weight = water.density * water.gravity
        table = read(path, body=section.body, scale=section.length_scale, weight=weight)
    else:
        raise InputError.single(*_refused(path.name, suffix), keys=("drift", "file"))
    point = point_in_space(section.reference_point or center)
    arm = np.subtract(point, point_in_space(center)).tolist()
    return BodyDrift(of_motions(about(table, arm), motions), (arm[0], arm[1]))


def _refused(name: str, suffix: str) -> tuple[str, str]:
    if suffix in (".10s", ".11s", ".12s"):
        text = f"{name}: forces of sums of frequencies are not computed"
        return text, f"name the file of differences, {suffix[:-1]}d"
    return f"{name}: the suffix {suffix!r} is not one of drift forces", FORMATS


def _check_plain(section: Drift) -> None:
    for key in ("body", "length_scale"):
        if key in section.model_fields_set:
            text = f"'{key}' has no effect on a CSV file, which is of one body and in SI units"
            raise InputError.single(text, "remove it", keys=("drift", key))


def _read_csv(path: Path, names: list[str]) -> MeanDrift:
    columns = read_columns(path, [(name, UNITS[name]) for name in ("omega", "direction", *names)])
    omega, directions, *values = columns.values
    problems = list[Problem]()
    for row, value in enumerate(omega):
        if value <= 0:
            text = f"omega {value:g} rad/s is not positive"
            problems.append(columns.problem(row, text, "leave the row out"))
    if not omega:
        problems.append(_empty(columns))
    if problems:
        raise InputError(shortened(problems))
    by_name = {motion.name: motion for motion in (SURGE, SWAY, YAW)}
    entries = [
        Entry(row, (omega[row],), directions[row], by_name[name], value)
        for name, column in zip(names, values, strict=True)
        for row, value in enumerate(column)
    ]
    return mean_table(path.name, entries, columns.problem)


def _empty(columns: Columns) -> Problem:
    return Problem("has no rows", "write omega, direction and forces", str(columns.path))
