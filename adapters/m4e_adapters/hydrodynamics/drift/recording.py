"""Drift forces, recorded: for each term λ the square of a sum over all waves.

    F = Σ λ |Σ_i r_i a_i u_i e^{−iθ_i}|²        r_i the ramp, θ_i at the point that phases are of

with the u of `factors`: for mean drift √D and √−D, for full QTFs the factors between which they are
linear. A force costs 4 operations of each wave and sign of its mean drift in a step, or 8 of each
wave and factor; the factors a u depend on parameters only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_adapters.hydrodynamics.drift.factors import Factors
from m4e_adapters.hydrodynamics.drift.interpolation import (
    Number,
    at_direction,
    at_frequency,
    fall,
)
from m4e_adapters.hydrodynamics.geometry.motions import Motion
from m4e_adapters.hydrodynamics.seas.recorded_waves import RecordedWaves
from m4e_fmi.program import Scalar, cos, maximum, sin, sqrt

Pair = tuple[Number, Number]
FLOOR = 1e-14  # of the largest mean drift: at √0 there is no derivative


@dataclass(frozen=True)
class Term:
    """λ = `value` and u, real and imaginary part, of each wave of each system, for a `motion`."""

    motion: Motion
    value: float
    weights: list[list[Pair]] = field(repr=False)


@dataclass(frozen=True)
class Directed:
    """Mean drift in any direction: `harmonics` (nω, M + 1, m) [N/m2, N.m/m2] of m `motions`."""

    omega: np.ndarray = field(repr=False)
    motions: tuple[Motion, ...]
    harmonics: np.ndarray = field(repr=False)

    def terms(self, waves: Sequence[RecordedWaves], heading: Number) -> list[Term]:
        """Terms of all motions, for hulls with that `heading` [rad]."""
        drift = [list(self._drift(own, heading)) for own in waves]
        largest = np.abs(self.harmonics).max(axis=(0, 1))
        return list(_newman(self.motions, drift, largest))

    def _drift(self, waves: RecordedWaves, heading: Number) -> Iterator[list[Number]]:
        table = self.harmonics
        flat = table.reshape(len(table), -1)
        columns = np.concatenate([np.real(flat), np.imag(flat)], axis=1)
        rows = [_fallen(omega, self.omega, columns) for omega in waves.omega]
        return at_direction(table, waves.direction - heading, waves.offsets, rows)


@dataclass(frozen=True)
class FixedDrift:
    """Mean drift (nω, m) [N/m2, N.m/m2] of m `motions`, for each wave of each system.

    `tables` are by system and wave, for the direction of that wave.
    """

    omega: np.ndarray = field(repr=False)
    motions: tuple[Motion, ...]
    tables: Sequence[Sequence[np.ndarray]] = field(repr=False)

    def terms(self, waves: Sequence[RecordedWaves], heading: Number) -> list[Term]:
        """Terms of all motions; the `heading` [rad] is that of the tables."""
        del heading
        drift = [
            [_fallen(w, self.omega, table) for w, table in zip(own.omega, tables, strict=True)]
            for own, tables in zip(waves, self.tables, strict=True)
        ]
        largest = np.max([np.abs(t).max(axis=0) for tables in self.tables for t in tables], axis=0)
        return list(_newman(self.motions, drift, largest))


@dataclass(frozen=True)
class Paired:
    """Full QTFs of m `motions` for waves in one direction, as `factors` at `omega` [rad/s]."""

    omega: np.ndarray = field(repr=False)
    motions: tuple[Motion, ...]
    factors: tuple[Factors, ...] = field(repr=False)

    def terms(self, waves: Sequence[RecordedWaves], heading: Number) -> list[Term]:
        """Terms of all motions; the `heading` [rad] is that of the QTFs."""
        del heading
        return [
            Term(motion, float(value), [self._weights(own, shape) for own in waves])
            for motion, own in zip(self.motions, self.factors, strict=True)
            for value, shape in zip(own.values, own.shapes.T, strict=True)
        ]

    def _weights(self, waves: RecordedWaves, shape: np.ndarray) -> list[Pair]:
        columns = np.stack([np.real(shape), np.imag(shape)], axis=1)
        found = []
        for omega in waves.omega:
            real, imaginary = at_frequency(omega, self.omega, columns)
            factor = sqrt(fall(omega, float(self.omega[0])))
            found.append((factor * real, factor * imaginary))
        return found


Drifting = Directed | FixedDrift | Paired


def _fallen(omega: Number, knots: np.ndarray, columns: np.ndarray) -> list[Number]:
    factor = fall(omega, float(knots[0]))
    return [factor * value for value in at_frequency(omega, knots, columns)]


def _newman(
    motions: Sequence[Motion], drift: Sequence[Sequence[Sequence[Number]]], largest: np.ndarray
) -> Iterator[Term]:
    """Terms of mean `drift` by system, wave and motion, whose `largest` are (m,) [N/m2, N.m/m2]."""
    for m, motion in enumerate(motions):
        floor = FLOOR * float(largest[m])
        for sign in (1.0, -1.0):
            roots = [[_root(sign * row[m], floor) for row in rows] for rows in drift]
            if any(isinstance(x, Scalar) or x for own in roots for x in own):
                yield Term(motion, sign, [[(x, 0.0) for x in own] for own in roots])


def _root(value: Number, floor: float) -> Number:
    """Root of a value, or of the `floor` if it is a scalar that may come close to 0."""
    if isinstance(value, Scalar):
        return sqrt(maximum(value, floor))
    return sqrt(max(value, 0.0))


def drift_forces(
    time: Scalar,
    drifting: Drifting,
    waves: Sequence[RecordedWaves],
    *,
    heading: Number,
    place: tuple[Number, Number],
) -> dict[Motion, Number]:
    """Force of each motion [N, N.m], in axes of the `heading` [rad].

    `place` (x, y) [m] is the point that phases are of, in world axes.
    """
    phases = [list(_phases(time, own, place)) for own in waves]
    forces: dict[Motion, Number] = dict.fromkeys(drifting.motions, 0.0)
    for term in drifting.terms(waves, heading):
        real: Number = 0.0
        imaginary: Number = 0.0
        for own, weights, angles in zip(waves, term.weights, phases, strict=True):
            p, q = _sum(own.amplitude, weights, angles)
            real, imaginary = real + own.ramp * p, imaginary + own.ramp * q
        square = real * real + imaginary * imaginary
        forces[term.motion] = forces[term.motion] + term.value * square
    return forces


def _phases(time: Scalar, waves: RecordedWaves, place: tuple[Number, Number]) -> Iterator[Pair]:
    """cos θ and sin θ of each wave at `place` (x, y) [m]."""
    x, y = place
    for k, omega in enumerate(waves.omega):
        angle = omega * time + waves.phase[k]
        cosine, sine = cos(angle), sin(angle)
        c, s = waves.along(k)
        way = waves.number[k] * (x * c + y * s)
        turn, lift = cos(way), sin(way)
        yield cosine * turn + sine * lift, sine * turn - cosine * lift


def _sum(amplitudes: Sequence[Number], weights: Sequence[Pair], angles: Sequence[Pair]) -> Pair:
    """Real and imaginary part of Σ a u e^{−iθ}."""
    real: Number = 0.0
    imaginary: Number = 0.0
    for a, (p, q), (c, s) in zip(amplitudes, weights, angles, strict=True):
        p, q = a * p, a * q
        real = real + p * c + q * s
        imaginary = imaginary + q * c - p * s
    return real, imaginary
