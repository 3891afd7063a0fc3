"""Drift forces, recorded: for each term λ the square of a sum over all waves.

    F = Σ λ |Σ_i r_i a_i u_i e^{−iθ_i}|²        r_i the ramp, θ_i at the point that phases are of

with the u below: for mean drift √D and √−D, for full QTFs the factors between which they are
linear. A force costs 4 operations of each wave and sign of its mean drift in a step, or 8 of each
wave and factor; the factors a u depend on parameters only.

Sums over pairs of waves as squares of sums over waves.

A Hermitian matrix of QTFs is Q = Σ_r λ_r u_r u_rᴴ, so that the force is

    F = Σ_r λ_r |Σ_i a_i u_r(ω_i) e^{−iθ_i}|²

with as many terms r as Q has eigenvalues that matter. Between the frequencies of the file the u_r
are linear, Q bilinear. Small QTFs count as large ones: eigenvalues are those of Q_ij/(s_i s_j),
with s_i² the largest modulus in row i, and the rest that is left out is below `LEFT_OUT` of it
(Frobenius norms).

Newman's approximation Q_ij = ±√(D_i D_j), 0 where the signs differ, has one term for each sign.

Drift at the frequencies and directions of waves, which may be numbers or recorded scalars.

Over frequency tables are linear. Below their first frequency ω₀ drift falls as (ω/ω₀)⁴; above the
last one it keeps its value, since all of a short wave is reflected. Over direction mean drift is a
sum of harmonics e^{ijβ} through the values at directions all around.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.drift.tables import MeanDrift
from m4e_adapters.hydrodynamics.geometry.motions import Motion
from m4e_adapters.hydrodynamics.seas.excitation import multiples
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedWaves
from m4e_fmi.program import Scalar, cos, maximum, minimum, sin, sqrt

Number = Scalar | float
FALL = 4  # power of the frequency below a table
WIDEST = 45.0  # deg: steps of directions all around
SAME = 1e-3  # deg


def harmonics(table: MeanDrift) -> np.ndarray | None:
    """g (nω, M + 1, m) [N/m2, N.m/m2] with D = Re Σ_j g_j e^{ijβ}.

    None if its directions do not go all around in equal steps of `WIDEST` or less.
    """
    steps = np.diff(table.directions, append=table.directions[0] + 360.0)
    if steps.max() > WIDEST + SAME or np.ptp(steps) > SAME:
        return None
    found = np.fft.rfft(table.values, axis=1) / len(steps)
    orders = np.arange(found.shape[1])
    found *= np.exp(-1j * math.radians(float(table.directions[0])) * orders)[:, None]
    twice = (orders > 0) & (2 * orders < len(steps))
    return np.where(twice, 2.0, 1.0)[:, None] * found


def at_frequency(omega: Number, knots: np.ndarray, columns: np.ndarray) -> list[Number]:
    """Values of `columns` (nω, q) at `omega` [rad/s], linear between `knots` (nω,) [rad/s].

    In the units of the columns; beyond the knots those at the ends.
    """
    if not isinstance(omega, Scalar):
        return [float(np.interp(omega, knots, column)) for column in columns.T]
    found: list[Number] = columns[0].tolist()
    for k, (low, high) in enumerate(pairwise(knots.tolist())):
        share = minimum(maximum((omega - low) * (1.0 / (high - low)), 0.0), 1.0)
        gains = (columns[k + 1] - columns[k]).tolist()
        found = [value + share * gain for value, gain in zip(found, gains, strict=True)]
    return found


def fall(omega: Number, first: float) -> Number:
    """The factor of drift at `omega` [rad/s] below the `first` of a table [rad/s], 1 above."""
    if not isinstance(omega, Scalar):
        return min(omega / first, 1.0) ** FALL
    return minimum(omega * (1.0 / first), 1.0) ** FALL


def at_direction(
    table: np.ndarray, angle: Number, offsets: np.ndarray, rows: Sequence[Sequence[Number]]
) -> Iterator[list[Number]]:
    """Mean drift of each wave and motion, for harmonics of waves, real parts first, in `rows`.

    Waves travel to `angle` + `offsets` (k,) [rad] from the hull's axis; `table` (nω, M + 1, m) is
    what the rows are of, in N/m2 and N.m/m2.
    """
    _, orders, motions = table.shape
    turns = multiples(angle, orders - 1)
    half = orders * motions
    for row, offset in zip(rows, offsets.tolist(), strict=True):
        drift: list[Number] = [0.0] * motions
        for j, (c, s) in enumerate(turns):
            cosine, sine = math.cos(j * offset), math.sin(j * offset)
            for m in range(motions):
                real, imaginary = row[j * motions + m], row[half + j * motions + m]
                even = cosine * real - sine * imaginary
                odd = sine * real + cosine * imaginary
                drift[m] = drift[m] + even * c - odd * s
        yield drift


LEFT_OUT = 1e-3  # of the norm of the scaled QTFs
SMALLEST = 1e-3  # scale of a row over the largest


@dataclass(frozen=True)
class Factors:
    """`values` λ (r,) [1] and `shapes` u (nω, r) [√(N/m2), √(N.m/m2)] of one QTF."""

    values: np.ndarray
    shapes: np.ndarray = field(repr=False)


def factorised(qtf: np.ndarray) -> Factors:
    """Factors of a Hermitian `qtf` (nω, nω) [N/m2, N.m/m2], without `LEFT_OUT` of it."""
    squares = np.abs(qtf).max(axis=1)
    if not squares.any():
        return Factors(np.zeros(0), np.zeros((len(qtf), 0), dtype=complex))
    scales = np.sqrt(np.maximum(squares, SMALLEST**2 * squares.max()))
    values, shapes = np.linalg.eigh(qtf / np.outer(scales, scales))
    order = np.argsort(-np.abs(values))
    values, shapes = values[order], shapes[:, order]
    rest = np.sqrt(np.maximum(np.cumsum(values[::-1] ** 2)[::-1], 0.0))
    kept = int(np.sum(rest > LEFT_OUT * rest[0]))
    return Factors(values[:kept], scales[:, None] * shapes[:, :kept])


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
