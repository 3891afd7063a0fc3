"""Trajectory of an input during a step, through its values at the start, in the middle, at the end.

Through three values u₀, u½, u₁ goes a parabola:

    u(s) = c₀ + c₁ s + c₂ s²,   s = (t − tₙ)/H,   c₁ = −3u₀ + 4u½ − u₁,   c₂ = 2u₀ − 4u½ + 2u₁.

Straight lines from u₀ over u½ to u₁ (`InputInterpolation.LINES`) are of second order, and stable
where a parabola, solved for its values, is not.

An FMU that holds its inputs gets values that act like the trajectory. A held value with the right
mean gives a velocity that a force drives, but not the displacement: that is off by H³/96 of the
force's rate in a half step, and lets an undamped pair gain energy. Two values one after the other,
with the right first moment besides, ∫u ds and ∫s u ds, act to the fourth order like the trajectory
itself, at their end; three have the right second moment too. For a trajectory a + bσ + cσ² over
such a *group* of pieces, σ from 0 to 1, they are

==============  ==================================================
one value       a + b/2 + c/3
two values      a + b/6,  a + 5b/6 + 2c/3
three values    a + b/8 + c/30,  a + b/2 + 11c/60,  a + 7b/8 + 47c/60
==============  ==================================================

Pieces are grouped in pairs, and the last three together where their number is odd. Within a group
outputs are off by O(H²), so that they are *known* at its ends only.

Where no such end is in the middle of the step, the value there is that of the cubic through the
four nearest, or of the parabola through three. If only both ends of the step are known, it is that
of the cubic with the output's declared derivatives there, y½ = (y₀ + y₁)/2 + H (y₀′ − y₁′)/8, and
where none are declared of the parabola through these and the start of the step before. Cubics are
off by O(H⁴), parabolas by O(H³), which leaves the coupling at third order.

Everything here is a row of three weights: of u₀, u½ and u₁.
"""

from __future__ import annotations

from enum import Enum
from itertools import pairwise

import numpy as np

PARABOLA = np.array([[1.0, 0.0, 0.0], [-3.0, 4.0, -1.0], [2.0, -4.0, 2.0]])
"""Coefficients c₀, c₁, c₂ of the three values."""


HELD = {
    1: ((1 / 2, 1 / 3),),
    2: ((1 / 6, 0.0), (5 / 6, 2 / 3)),
    3: ((1 / 8, 1 / 30), (1 / 2, 11 / 60), (7 / 8, 47 / 60)),
}
"""Shares of b and c in the values of a group."""


class InputInterpolation(Enum):
    """Curve of inputs through their three values; weights (3,) are those of u₀, u½ and u₁."""

    PARABOLA = "parabola"
    LINES = "straight lines"

    @property
    def mean(self) -> np.ndarray:
        """Weights (3,) [1] of the mean over the step: Simpson's rule, or the trapezoid."""
        weight = 4.0 if self is InputInterpolation.PARABOLA else 2.0
        return np.array([1.0, weight, 1.0]) / (2.0 + weight)

    def at(self, s: float) -> np.ndarray:
        """Weights (3,) [1] of the value at the share `s` of the step."""
        return self.expansion(s)[0]

    def known(self, pieces: int, *, held: bool) -> list[int]:
        """Ends of pieces at which outputs are known, from 0 on; inputs are `held` or not."""
        if not held or self is InputInterpolation.LINES:
            return list(range(pieces + 1))
        return [*range(0, max(1, pieces - 1), 2), pieces]

    def expansion(self, s: float) -> np.ndarray:
        """Weights (3, 3) [1] of value, first and half second derivative by s, at s and after it."""
        if self is InputInterpolation.PARABOLA:
            start, slope, bend = PARABOLA
            return np.array([start + s * slope + s * s * bend, slope + 2 * s * bend, bend])
        if s < 0.5:
            return np.array([[1 - 2 * s, 2 * s, 0.0], [-2.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
        return np.array([[0.0, 2 - 2 * s, 2 * s - 1], [0.0, -2.0, 2.0], [0.0, 0.0, 0.0]])

    @property
    def held_pieces(self) -> int:
        """Least number of values that are held in a step."""
        return 4 if self is InputInterpolation.PARABOLA else 2

    def lost(self, pieces: int) -> float:
        """Share of the first moment about the mean that is lost in so many pieces that are held."""
        return 1 / pieces**2 if self is InputInterpolation.LINES or pieces == 1 else 0.0

    def held(self, piece: int, pieces: int) -> np.ndarray:
        """Weights (3,) [1] of the value that is held in one of so many pieces."""
        if self is InputInterpolation.LINES:
            start, end = self.at(piece / pieces), self.at((piece + 1) / pieces)
            if 2 * piece + 1 == pieces:
                return (start + 2 * self.at(0.5) + end) / 4
            return (start + end) / 2
        bounds = self.known(pieces, held=True)
        first, last = next((a, b) for a, b in pairwise(bounds) if a <= piece < b)
        a, b, c = self.expansion(first / pieces)
        both = (last - first) / pieces
        of_b, of_c = HELD[last - first][piece - first]
        return a + of_b * both * b + of_c * both**2 * c

    @property
    def most_points(self) -> int:
        """Largest number of known values from which the one in the middle is taken."""
        return 4 if self is InputInterpolation.PARABOLA else 2
