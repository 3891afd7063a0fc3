"""Excitation of each wave component: from the coefficients' splines, for any direction.

In space the direction β that a wave travels to is a parameter. With h the heading, X is the sum of
harmonics e^{ij(β − h)} of the wave at the body's centre, times the phase of the wave's way from
x = y = 0 to the reference place of that centre. Components that all travel to β have the sums at
the splines' knots in common: recorded are these, and for each component the spline between its two
knots. For a frequency that is a parameter the splines are
recorded, in Hermite's form: with s the place between two knots, 0 below and 1 above them, each
interval adds what the spline gains in it, so that no branch is needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedWaves
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.program import Scalar, cos, maximum, minimum, sin

Number = Scalar | float
Pair = tuple[Number, Number]
NEGLIGIBLE = 1e-7  # harmonic of the excitation over the largest of its motion


def excitation_of(
    coefficients: Coefficients,
    waves: RecordedWaves,
    *,
    heading: Number,
    places: Sequence[tuple[Number, Number]],
) -> list[list[Pair]]:
    """Real and imaginary parts of the excitation of each component [N/m, N.m/m], and motion.

    In space for a `heading` [rad] and reference `places` (x, y) [m] of the bodies, in the axes of
    the heading. With the phase of a crest at x = y = 0.
    """
    if coefficients.dimensions == 2 and not _changes(waves):
        table = coefficients.excitation_at(np.array(waves.omega, dtype=float))
        return [[(float(x.real), float(x.imag)) for x in row] for row in table]
    if coefficients.dimensions == 2:
        places = [(float(x), 0.0) for x, _ in coefficients.centers]
        turns = [(1.0, 0.0)]
    else:
        most = coefficients.harmonics.shape[1] // 2
        turns = multiples(waves.direction - heading, most)
    if not _changes(waves) and not waves.offsets.any():
        at_centers = _between_knots(coefficients, np.array(waves.omega, dtype=float), turns)
    else:
        table = _harmonics(coefficients, waves)
        at_centers = ([_sum(column, turns) for column in own] for own in table)
    rows = []
    for k, own in enumerate(at_centers):
        c, s = waves.along(k)
        ways = [waves.number[k] * (x * c + y * s) for x, y in places]
        phases = [(cos(way), sin(way)) for way in ways]
        row = []
        for i, (real, imaginary) in enumerate(own):
            c, s = phases[i // coefficients.per_body]
            row.append((real * c - imaginary * s, real * s + imaginary * c))
        rows.append(row)
    return rows


def _between_knots(
    coefficients: Coefficients, omega: np.ndarray, turns: Sequence[Pair]
) -> Iterator[list[Pair]]:
    """Excitation of each component and motion by the wave at the bodies' centres.

    `turns` are cos jb and sin jb of the angle b between waves and hulls. For `omega` (k,) [rad/s]
    values and slopes at knots, and splines between. Above the last knot as
    `Coefficients.harmonics_at`.
    """
    knots, values, slopes = coefficients.excitation_knots()
    width = np.diff(knots)
    largest = np.abs(values).max(axis=(0, 1))
    swing = np.abs(slopes) * width.max()
    tables = np.where(np.maximum(np.abs(values), swing) > NEGLIGIBLE * largest, (values, slopes), 0)

    @cache
    def at(of: int, knot: int) -> list[Pair]:
        columns = tables[of, knot].T
        return [_sum([(x.real, x.imag) for x in column.tolist()], turns) for column in columns]

    for w in omega.tolist():
        low = min(int(np.searchsorted(knots, w, side="right")) - 1, len(width) - 1)
        s = min((w - knots[low]) / width[low], 1.0)
        fallen = min(knots[-1] / w, 1.0) ** 3
        gain, rest = s * s * (3.0 - 2.0 * s), 1.0 - s
        weights = np.array([1.0 - gain, gain, width[low] * s * rest**2, -width[low] * s * s * rest])
        parts = [at(0, low), at(0, low + 1), at(1, low), at(1, low + 1)]
        yield [_mean(own, (fallen * weights).tolist()) for own in zip(*parts, strict=True)]


def _mean(pairs: Sequence[Pair], weights: Sequence[float]) -> Pair:
    """Σ weights · pairs."""
    real: Number = 0.0
    imaginary: Number = 0.0
    for weight, (a, b) in zip(weights, pairs, strict=True):
        real, imaginary = real + weight * a, imaginary + weight * b
    return real, imaginary


def towards_each(
    coefficients: Coefficients, waves: Sequence[WaveSystem], *, heading: float
) -> list[Coefficients]:
    """The coefficients with the excitation for each of the systems of `waves`.

    `heading` [deg] is that of the hulls. InputError with all that the excitation is not known for.
    """
    found, problems = list[Coefficients](), list[Problem]()
    for k, system in enumerate(waves):
        place = ("waves", k) if len(waves) > 1 else ("waves",)
        if system.offsets.any() and not coefficients.has_harmonics:
            text = f"the waves of {system.name!r} travel in several directions, the coefficients "
            text += "are not for all"
            remedy = "let them travel in one, or compute the excitation for directions all around"
            problems.append(Problem(text, remedy, keys=place))
        try:
            found.append(coefficients.towards(system.direction - heading))
        except InputError as error:
            problems += [replace(p, keys=(*place, "direction")) for p in error.problems]
    InputError.raise_for(problems)
    return found


def _changes(waves: RecordedWaves) -> bool:
    return any(isinstance(omega, Scalar) for omega in waves.omega)


def _harmonics(coefficients: Coefficients, waves: RecordedWaves) -> Iterator[list[list[Pair]]]:
    """Of each component and motion the harmonics, real and imaginary, j = −M … M.

    Those of a component that travels beside the mean direction are turned by that angle.
    """
    if _changes(waves):
        yield from (_recorded(coefficients, omega) for omega in waves.omega)
        return
    table = _counted(coefficients.harmonics_at(np.array(waves.omega, dtype=float)))
    order = np.arange(table.shape[1]) - table.shape[1] // 2
    table = table * np.exp(1j * np.outer(waves.offsets, order))[:, :, None]
    for own in table:
        yield [[(float(x.real), float(x.imag)) for x in column] for column in own.T]


def _counted(harmonics: np.ndarray) -> np.ndarray:
    """`harmonics` (k, 2M + 1, n) without those that are negligible."""
    negligible = NEGLIGIBLE * np.abs(harmonics).max(axis=(0, 1))
    return np.where(np.abs(harmonics) > negligible, harmonics, 0.0)


def _recorded(coefficients: Coefficients, omega: Number) -> list[list[Pair]]:
    """Harmonics of each motion at a frequency that is a scalar, by recorded splines."""
    knots, values, slopes = coefficients.excitation_knots()
    kept = np.any(_counted(values) != 0.0, axis=0)
    of_values, of_slopes = _hermite(omega, knots.tolist())
    weights = [*of_values, *of_slopes]
    table = np.concatenate([values, slopes])

    def spline(column: np.ndarray) -> Pair:
        real: Number = 0.0
        imaginary: Number = 0.0
        for weight, x in zip(weights, column.tolist(), strict=True):
            real, imaginary = real + weight * x.real, imaginary + weight * x.imag
        return real, imaginary

    motions, orders = range(table.shape[2]), range(table.shape[1])
    return [[spline(table[:, j, i]) if kept[j, i] else (0.0, 0.0) for j in orders] for i in motions]


def _hermite(omega: Number, knots: Sequence[float]) -> tuple[list[Number], list[Number]]:
    """Weights of the values and slopes at `knots` [rad/s] in the cubic spline at `omega`."""
    values: list[Number] = [1.0, *[0.0] * (len(knots) - 1)]
    slopes: list[Number] = [0.0] * len(knots)
    for k, (low, high) in enumerate(pairwise(knots)):
        width = high - low
        s = minimum(maximum((omega - low) * (1.0 / width), 0.0), 1.0)
        rest = 1.0 - s
        gain = s * s * (3.0 - 2.0 * s)
        values[k] = values[k] - gain
        values[k + 1] = gain
        slopes[k] = slopes[k] + width * (s * rest * rest)
        slopes[k + 1] = -width * (s * s * rest)
    return values, slopes


def multiples(angle: Number, most: int) -> list[Pair]:
    """cos jb and sin jb of an angle b, j = 0 … `most`."""
    first: Pair = (cos(angle), sin(angle))
    found: list[Pair] = [(1.0, 0.0)]
    for _ in range(most):
        c, s = found[-1]
        found.append((c * first[0] - s * first[1], s * first[0] + c * first[1]))
    return found


def _sum(harmonics: Sequence[Pair], turns: Sequence[Pair]) -> Pair:
    """Real and imaginary part of Σ harmonics[M + j] e^{ijb}."""
    middle = len(harmonics) // 2
    real, imaginary = harmonics[middle]
    for j in range(1, middle + 1):
        after, before = harmonics[middle + j], harmonics[middle - j]
        c, s = turns[j]
        real = real + (after[0] + before[0]) * c - (after[1] - before[1]) * s
        imaginary = imaginary + (after[1] + before[1]) * c + (after[0] - before[0]) * s
    return real, imaginary
