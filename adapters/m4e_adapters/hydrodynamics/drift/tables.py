"""Drift of a body: mean forces by frequency and direction, or quadratic transfer functions (QTFs).

Waves of amplitudes a_i and phases θ_i = ω_i t + φ_i make the force

    F = Re Σ_ij a_i a_j Q_ij e^{−i(θ_i − θ_j)}        Q_ji = conj(Q_ij)

so that one wave makes the mean force a² D with D = Q_ii. Forces are in the axes that the hull is
drawn in, directions those that waves travel to, from +X towards +Y.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import HEAVE, PITCH, ROLL, SPACE, Motion
from m4e_fmi.errors import InputError, Problem

SAME_DIRECTION = 1e-3  # deg
TellProblem = Callable[[int, str, str], Problem]
"""From the index of a row, a message and a remedy to the problem of that row."""
_FULL = 360.0


@dataclass(frozen=True)
class _Table:
    """Values at `omega` (nω,) [rad/s] and `directions` (nβ,) [deg] from 0 to 360, increasing.

    For m `motions`. `name` is the file's. `notes` are lines on how it was read.
    """

    name: str
    omega: np.ndarray = field(repr=False)
    directions: np.ndarray = field(repr=False)
    motions: tuple[Motion, ...]
    values: np.ndarray = field(repr=False)
    notes: tuple[str, ...] = ()


class MeanDrift(_Table):
    """Mean drift per squared wave amplitude, `values` (nω, nβ, m) [N/m2, N.m/m2]."""


class Qtf(_Table):
    """Difference-frequency QTFs, `values` (nβ, m, nω, nω) [N/m2, N.m/m2], each Hermitian.

    For pairs of waves in one direction.
    """

    @property
    def mean(self) -> MeanDrift:
        """The mean drift on the diagonal."""
        diagonal = np.real(np.diagonal(self.values, axis1=2, axis2=3))
        values = np.moveaxis(diagonal, 2, 0)
        return MeanDrift(self.name, self.omega, self.directions, self.motions, values, self.notes)


@dataclass(frozen=True)
class BodyDrift:
    """The drift of a body about its centre of gravity, which the `point` (x, y) [m] is away from.

    Phases are those of waves at that point.
    """

    table: MeanDrift | Qtf
    point: tuple[float, float] = (0.0, 0.0)


class Entry(NamedTuple):
    """A value of a file: index of its row, ω [rad/s], direction [deg], motion, value."""

    row: int
    omega: tuple[float, ...]
    direction: float
    motion: Motion
    value: complex


def gridded(
    entries: Sequence[Entry], problem: TellProblem
) -> tuple[np.ndarray, np.ndarray, tuple[Motion, ...], np.ndarray]:
    """ω (nω,) [rad/s], directions (nβ,) [deg], motions, and values (nω, …, nβ, m), SI.

    There are as many axes of ω as each entry has. Values that are not there are NaN. InputError for
    a value that is there twice.
    """
    omega = np.unique([w for entry in entries for w in entry.omega])
    turned = [wrapped(entry.direction) for entry in entries]
    directions = np.unique(turned)
    motions = tuple(m for m in SPACE if any(entry.motion is m for entry in entries))
    axes = len(entries[0].omega)
    values = np.full((*[len(omega)] * axes, len(directions), len(motions)), complex(np.nan))
    of_omega, of_direction = (
        {value: k for k, value in enumerate(axis.tolist())} for axis in (omega, directions)
    )
    for entry, direction in zip(entries, turned, strict=True):
        of_pair = tuple(of_omega[w] for w in entry.omega)
        place = (*of_pair, of_direction[direction], motions.index(entry.motion))
        if not np.isnan(values[place]):
            pair = " and ".join(f"{w:.6g}" for w in entry.omega)
            text = f"{entry.motion.name} at {pair} rad/s, {direction:g} deg stands twice"
            raise InputError([problem(entry.row, text, "leave one of the rows out")])
        values[place] = entry.value
    return omega, directions, motions, values


def wrapped(direction: float) -> float:
    """From 0 to 360 deg, 360 not included."""
    found = round(direction % _FULL, 6)
    return 0.0 if found >= _FULL - SAME_DIRECTION else found


def mean_table(name: str, entries: Sequence[Entry], problem: TellProblem) -> MeanDrift:
    """The table of `entries`; InputError if it is not complete."""
    omega, directions, motions, values = gridded(entries, problem)
    missing = np.argwhere(np.isnan(values))
    if len(missing):
        i, j, m = missing[0]
        text = (
            f"{len(missing)} of {values.size} values are missing: the first is {motions[m].name} "
            f"at {omega[i]:.6g} rad/s, {directions[j]:g} deg"
        )
        remedy = "each frequency has all directions and motions; was the file cut off?"
        raise InputError([problem(-1, text, remedy)])
    return MeanDrift(name, omega, directions, motions, np.real(values))


def about(table: MeanDrift | Qtf, arm: Sequence[float]) -> MeanDrift | Qtf:
    """The drift about a point that the `table`'s own point is away from by `arm` (x, y, z) [m]."""
    axis = 2 if isinstance(table, MeanDrift) else 1
    values = np.moveaxis(table.values.copy(), axis, 0)
    before = {motion: values[k].copy() for k, motion in enumerate(table.motions)}
    for k, motion in enumerate(table.motions):
        if not motion.is_rotation:
            continue
        turn = SPACE.index(motion) - 3
        one, other = (turn + 1) % 3, (turn + 2) % 3
        for place, force, sign in ((one, SPACE[other], 1.0), (other, SPACE[one], -1.0)):
            if arm[place] == 0.0:
                continue
            if force not in before:
                raise InputError.single(
                    f"{table.name}: {motion.name} about another point needs {force.name}, which "
                    "the file does not have",
                    "compute it too, or all moments about the centre of gravity",
                )
            values[k] += sign * arm[place] * before[force]
    return replace(table, values=np.moveaxis(values, 0, axis))


def of_motions(table: MeanDrift | Qtf, motions: Sequence[Motion]) -> MeanDrift | Qtf:
    """The table with those of its motions only that are among `motions`."""
    kept = [k for k, motion in enumerate(table.motions) if motion in motions]
    named = tuple(table.motions[k] for k in kept)
    axis = 2 if isinstance(table, MeanDrift) else 1
    return replace(table, motions=named, values=np.take(table.values, kept, axis=axis))


VERTICAL = (HEAVE, ROLL, PITCH)
"""Motions whose slow forces the mean drift does not tell."""
