"""Drift of all bodies of a configuration: read, matched with the waves, recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.drift.files import read_drift
from m4e_adapters.hydrodynamics.drift.recording import (
    WIDEST,
    Directed,
    Drifting,
    FixedDrift,
    Paired,
    drift_forces,
    factorised,
    harmonics,
)
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift, MeanDrift, Qtf
from m4e_adapters.hydrodynamics.geometry.motions import X_Y_PAIRS, Motion
from m4e_adapters.hydrodynamics.load.motions import Motions
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Number, RecordedWaves
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.program import Recorder
from m4e_fmi.shown import first_of

SAME = 1e-3  # deg
MOST_OUTSIDE = 0.1  # of the energy of the waves, beyond the frequencies of a table
Tell = Callable[[str], object]


def matched(
    table: MeanDrift | Qtf,
    systems: Sequence[WaveSystem],
    *,
    heading: float,
    tell: Tell,
) -> Drifting:
    """The drift for the waves of `systems`, for hulls with that `heading` [deg].

    `tell` gets lines on what was done. InputError if the table does not have the directions or the
    frequencies of the waves.
    """
    for note in table.notes:
        tell(f"note: {table.name}: {note}")
    _check_frequencies(table, systems, tell)
    if isinstance(table, Qtf):
        return _paired(table, systems, heading=heading, tell=tell)
    around = harmonics(table)
    if around is not None:
        return Directed(table.omega, table.motions, around)
    tell(
        f"note: {table.name}: its directions are not all around in equal steps of {WIDEST:g} deg "
        "or less: those of the waves are fixed"
    )
    places = [[_row(table, beta) for beta in _directions(own, heading)] for own in systems]
    return FixedDrift(
        table.omega,
        table.motions,
        [[table.values[:, place] for place in own] for own in places],
    )


def _directions(system: WaveSystem, heading: float) -> list[float]:
    """Of each wave, from the hulls' axis [deg]."""
    return (system.direction - heading + np.degrees(system.offsets)).tolist()


def _row(table: MeanDrift | Qtf, direction: float) -> int:
    """Where a direction is in the table; InputError if it is not there."""
    away = [abs(math.remainder(direction - known, 360.0)) for known in table.directions.tolist()]
    place = int(np.argmin(away))
    if away[place] > SAME:
        known = first_of((f"{beta:g}" for beta in table.directions), 12)
        raise InputError.single(
            f"{table.name} has no drift for waves at {direction % 360.0:.6g} deg from the hull's "
            f"axis: it has {known}",
            "compute it for that direction too; in a mean drift table directions all around, in "
            f"equal steps of {WIDEST:g} deg or less, are good for any "
            "(a hull that is symmetric about y = 0 has sway and yaw of the other sign at minus "
            "the direction)",
        )
    return place


def _paired(table: Qtf, systems: Sequence[WaveSystem], *, heading: float, tell: Tell) -> Paired:
    angles = {round(b % 360.0, 3) for own in systems for b in _directions(own, heading)}
    if len(angles) > 1:
        raise InputError.single(
            f"{table.name} has QTFs of pairs in one direction, the waves travel in "
            f"{len(angles)} directions",
            "take a mean drift table (.8, .9 or CSV), or waves without spreading",
        )
    place = _row(table, angles.pop()) if angles else 0
    factors = tuple(factorised(qtf) for qtf in table.values[place])
    for motion, own in zip(table.motions, factors, strict=True):
        tell(
            f"{table.name}: the QTF of {motion.name} has {len(own.values)} factors of "
            f"{len(own.shapes)}"
        )
    return Paired(table.omega, table.motions, factors)


def _check_frequencies(table: MeanDrift | Qtf, systems: Sequence[WaveSystem], tell: Tell) -> None:
    """Tell how much of the waves is beyond the table; InputError if that is much."""
    low, high = float(table.omega[0]), float(table.omega[-1])
    parts = [own.configured() for own in systems]
    omega = np.concatenate([part[0] for part in parts] or [np.zeros(0)])
    energy = np.concatenate([part[1] ** 2 for part in parts] or [np.zeros(0)])
    if not energy.sum():
        return
    below, above = (
        float(energy[beyond].sum() / energy.sum()) for beyond in (omega < low, omega > high)
    )
    span = f"{table.name} has {low:.4g} to {high:.4g} rad/s"
    regular = next((own for own in systems if own.regular and not low <= own.needed <= high), None)
    if regular is not None:
        text = f"{span}, the wave has {regular.needed:.4g} rad/s"
        raise InputError.single(text, "compute its drift too")
    if below + above > MOST_OUTSIDE:
        raise InputError.single(
            f"{span}: {below:.0%} of the waves' energy is below, {above:.0%} above",
            f"compute more frequencies: {1 - MOST_OUTSIDE:.0%} of the energy must be within",
        )
    if below + above > 0.0:
        tell(
            f"note: {span}: {below:.2g} of the waves' energy is below, where drift falls as the "
            f"fourth power of the frequency, {above:.2g} above, where it keeps its last value"
        )


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
    systems: Sequence[WaveSystem],
    heading: float,
    tell: Tell,
) -> dict[str, Drifting]:
    """The drift of each body for the waves of `systems`, for hulls with that `heading` [deg].

    InputError with all problems.
    """
    found, problems = dict[str, Drifting](), list[Problem]()
    for name, own in drift.items():
        try:
            found[name] = matched(own.table, systems, heading=heading, tell=tell)
        except InputError as error:
            problems += _placed(error, name)
    InputError.raise_for(problems)
    return found


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
