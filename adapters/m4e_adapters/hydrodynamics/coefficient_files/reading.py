"""Reading of a file of any format, and its data put in order."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.bemio import read_bemio
from m4e_adapters.hydrodynamics.coefficient_files.capytaine_file import NEMOH, read_capytaine
from m4e_adapters.hydrodynamics.coefficient_files.file_data import FileData, refused
from m4e_adapters.hydrodynamics.coefficient_files.wamit import SUFFIXES, read_wamit
from m4e_adapters.hydrodynamics.memory.soundness import FEWEST
from m4e_fmi.errors import is_file, missing_file
from m4e_fmi.shown import first_of

READERS = {**dict.fromkeys(SUFFIXES, read_wamit), ".h5": read_bemio, ".nc": read_capytaine}
FORMATS = "formats: WAMIT (.1 with .3 and .hst beside it), BEMIO (.h5), Capytaine (.nc)"
SAME = 1e-9  # relative difference of frequencies that are the same
SAME_DIRECTION = 1e-3  # deg


def read_coefficient_file(path: Path) -> FileData:
    """The data of a file, its frequencies increasing, those without complete data left out.

    InputError with all problems of the file.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        text = f"{path}: the suffix {path.suffix!r} is not one of coefficients"
        raise refused(text, f"{FORMATS}; {NEMOH}")
    if not is_file(path):
        message, remedy = missing_file(path, "file of coefficients")
        where = "the name is relative to the system file's folder"
        raise refused(message, "; ".join(filter(None, (where, remedy))))
    return _in_order(reader(path))


def _in_order(data: FileData) -> FileData:
    """The data at finite positive frequencies, increasing; A∞ taken from ω = ∞ if it is there."""
    infinite = np.isposinf(data.omega)
    if infinite.any():
        row = data.added_mass[infinite][0]
        data = data.chosen(~infinite)
        if data.added_mass_inf is None and np.isfinite(row).all():
            data = replace(data, added_mass_inf=row)
    data = _without_twins(data)
    positive = np.flatnonzero(data.omega > 0)
    if len(positive) < len(data.omega):
        data = data.chosen(positive).with_notes("left out the values at frequency 0")
    data = _without_gaps(data)
    order = np.argsort(data.omega)
    if np.any(np.diff(order) < 0) and np.any(np.diff(order) > 0):
        data = data.with_notes("the frequencies were not in order and have been sorted")
    data = data.chosen(order)
    close = np.flatnonzero(np.diff(data.omega) <= SAME * data.omega[1:])
    if len(close):
        text = f"{data.path}: the frequency {data.omega[close[0]]:.6g} rad/s is there twice"
        raise refused(text, "remove one of them: which is meant cannot be known")
    if len(data.omega) < FEWEST:
        text = (
            f"{data.path}: {len(data.omega)} frequencies above 0 have data, a radiation memory "
            f"needs {FEWEST} or more"
        )
        raise refused(text, "compute more frequencies")
    return data


def _without_gaps(data: FileData) -> FileData:
    """The data at the frequencies that are complete: a NaN takes its frequency with it."""
    count = len(data.omega)
    radiation = (data.added_mass + data.damping).reshape(count, -1)
    every = np.concatenate([radiation, data.excitation.reshape(count, -1)], axis=1)
    complete = np.array([np.isfinite(row).all() for row in every], dtype=bool)
    if complete.all():
        return data
    shown = first_of((f"{w:.4g}" for w in data.omega[~complete]), 4)
    return data.chosen(complete).with_notes(
        f"left out frequencies without complete data: {shown} rad/s"
    )


def _without_twins(data: FileData) -> FileData:
    """The data with directions from 0 to 360 deg, increasing, none twice."""
    if not len(data.directions) or not np.isfinite(data.directions).all():
        raise refused(f"{data.path}: there are no wave directions", "the excitation needs some")
    angles = np.mod(data.directions, 360.0)
    angles[360.0 - angles < SAME_DIRECTION] = 0.0
    order = np.argsort(angles, kind="stable")
    kept = [int(order[0])]
    for k in order[1:].tolist():
        if angles[k] - angles[kept[-1]] > SAME_DIRECTION:
            kept.append(k)
            continue
        one, other = data.excitation[:, k], data.excitation[:, kept[-1]]
        apart = np.nanmax(np.abs(one - other), initial=0.0)
        if apart > 1e-6 * np.nanmax(np.abs(one), initial=0.0):
            text = f"{data.path}: the wave direction {angles[k]:g} deg is there twice"
            raise refused(f"{text}, with different excitation", "remove one of them")
    return replace(data, directions=angles[kept], excitation=data.excitation[:, kept])
