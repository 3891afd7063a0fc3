"""Drift of all bodies of a configuration: read, matched with the waves, recorded."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.drift.files import read_drift
from m4e_adapters.hydrodynamics.drift.matching import Tell, matched
from m4e_adapters.hydrodynamics.drift.recording import Drifting, drift_forces
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift, MeanDrift
from m4e_adapters.hydrodynamics.geometry.motions import X_Y_PAIRS, Motion
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.motions import Motions
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Number, RecordedWaves
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.program import Recorder

FULL_REFLECTION = 0.5  # mean drift per width of a body that sends all waves back, over ρ g
DOUBTFUL = 20.0  # width of a body over the cube root of its displaced volume


def read_drifts(
    config: HydrodynamicsConfig,
    folder: Path,
    *,
    centers: Mapping[str, tuple[float, ...]],
    water: Water | Coefficients,
) -> dict[str, BodyDrift]:
    """The drift of the bodies that have some; InputError with all problems.

    `centers` of gravity [m] are those of the bodies that move, in `water`; files are in `folder`.
    """
    found, problems = dict[str, BodyDrift](), list[Problem]()
    for name, body in config.bodies.items():
        if body.drift is None or name not in centers:
            continue
        try:
            found[name] = read_drift(body.drift, center=centers[name], water=water, folder=folder)
        except InputError as error:
            problems += _placed(error, name)
    InputError.raise_for(problems)
    return found


def _placed(error: InputError, body: str) -> list[Problem]:
    """The problems of a body's drift, with their place in the configuration if in no other file."""
    return [
        p if p.file else replace(p, keys=("bodies", body, *(p.keys or ("drift", "file"))))
        for p in error.problems
    ]


def matched_drifts(
    drift: Mapping[str, BodyDrift],
    coefficients: Coefficients,
    systems: Sequence[WaveSystem],
    heading: Heading,
    tell: Tell,
) -> dict[str, Drifting]:
    """The drift of each body for the waves of `systems`; InputError with all problems."""
    found, problems = dict[str, Drifting](), list[Problem]()
    for name, own in drift.items():
        _doubt(own, name, coefficients, tell)
        turns = heading.filter_time is not None
        try:
            found[name] = matched(own.table, systems, heading=heading.angle, turns=turns, tell=tell)
        except InputError as error:
            problems += _placed(error, name)
    InputError.raise_for(problems)
    return found


def _doubt(drift: BodyDrift, body: str, coefficients: Coefficients, tell: Tell) -> None:
    """Warn of forces that no body of that size has, as those of another unit or length scale."""
    k = coefficients.bodies.index(body)
    weight = coefficients.density * coefficients.gravity
    heave = coefficients.own(k).start + coefficients.heave
    size = math.cbrt(max(float(coefficients.buoyancy[heave]), 0.0) / weight)
    table = drift.table if isinstance(drift.table, MeanDrift) else drift.table.mean
    forces = [m for m, motion in enumerate(table.motions) if not motion.is_rotation]
    largest = float(np.abs(table.values[:, :, forces]).max(initial=0.0))
    if largest > DOUBTFUL * FULL_REFLECTION * weight * size > 0.0:
        width = largest / (FULL_REFLECTION * weight)
        tell(
            f"warning: {table.name}: the largest mean drift, {largest:.3g} N/m2, is that of a wall "
            f"of {width:.3g} m that reflects all waves; body {body!r} displaces a cube of "
            f"{size:.3g} m: are length_scale (ULEN) and units right?"
        )


def record_drifts(
    recorder: Recorder,
    drift: Mapping[str, BodyDrift],
    drifting: Mapping[str, Drifting],
    waves: Sequence[RecordedWaves],
    coefficients: Coefficients,
    moved: Motions,
) -> list[Number]:
    """Drift force of each motion of all bodies (n,) [N, N.m], in the axes of the heading."""
    forces: list[Number] = [0.0] * len(coefficients.motions)
    for name, own in drifting.items() if waves else ():
        k = coefficients.bodies.index(name)
        place = _place(drift[name].point, coefficients, moved, k)
        heading = moved.axes.angle if moved.axes else 0.0
        found = drift_forces(recorder.time, own, waves, heading=heading, place=place)
        for motion, force in found.items():
            forces[coefficients.own(k).start + coefficients.body_motions.index(motion)] = force
    return forces


def _place(
    point: tuple[float, float], coefficients: Coefficients, moved: Motions, k: int
) -> tuple[Number, Number]:
    """A `point` (x, y) [m] from a body's centre of gravity, in world axes."""
    if moved.axes is None:
        return float(coefficients.centers[k, 0]) + point[0], 0.0
    x, y = moved.places[k]
    along, across, *_ = moved.axes.to_world([*point, 0.0, 0.0, 0.0, 0.0])
    return x + along, y + across


def shown_motions(drift: BodyDrift | None, coefficients: Coefficients) -> list[Motion]:
    """Motions of a body with parts of its drift, in world axes."""
    if drift is None:
        return []
    own, motions = drift.table.motions, coefficients.body_motions
    pairs = [set(motions[k : k + 2]) for k in X_Y_PAIRS] if coefficients.dimensions == 3 else []
    with_others = {m for pair in pairs if pair & set(own) for m in pair} | set(own)
    return [motion for motion in motions if motion in with_others]
