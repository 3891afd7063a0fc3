"""Drift at the frequencies and directions of waves, which may be numbers or recorded scalars.

Over frequency tables are linear. Below their first frequency ω₀ drift falls as (ω/ω₀)⁴; above the
last one it keeps its value, since all of a short wave is reflected. Over direction mean drift is a
sum of harmonics e^{ijβ} through the values at directions all around.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.drift.tables import MeanDrift
from m4e_adapters.hydrodynamics.seas.excitation import multiples
from m4e_fmi.program import Scalar, maximum, minimum

Number = Scalar | float
FALL = 4  # power of the frequency below a table
WIDEST, FINEST = 45.0, 5.0  # deg: steps of directions all around
SAME = 1e-3  # deg


def harmonics(table: MeanDrift) -> np.ndarray | None:
    """g (nω, M + 1, m) [N/m2, N.m/m2] with D = Re Σ_j g_j e^{ijβ}; None: not all around.

    Directions with unequal steps are completed by periodic cubic splines; their steps have a common
    divisor of `FINEST` at least.
    """
    from scipy.interpolate import CubicSpline

    closed = np.append(table.directions, table.directions[0] + 360.0)
    steps = np.diff(closed)
    if steps.max() > WIDEST + SAME:
        return None
    count = next((n for n in _counts() if _divides(360.0 / n, steps)), None)
    if count is None:
        return None
    values = np.concatenate([table.values, table.values[:, :1]], axis=1)
    spline = CubicSpline(closed, values, axis=1, bc_type="periodic")
    even = table.directions[0] + 360.0 / count * np.arange(count)
    found = np.fft.rfft(spline(even), axis=1) / count
    orders = np.arange(found.shape[1])
    found *= np.exp(-1j * math.radians(float(table.directions[0])) * orders)[:, None]
    twice = (orders > 0) & (2 * orders < count)
    return np.where(twice, 2.0, 1.0)[:, None] * found


def _counts() -> range:
    return range(round(360.0 / WIDEST), round(360.0 / FINEST) + 1)


def _divides(step: float, steps: np.ndarray) -> bool:
    return bool(np.all(np.abs(steps - step * np.rint(steps / step)) < SAME))


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
