"""The course of an input during a step, through its values at the start, in the middle, at the end.

Through three values u₀, u½, u₁ goes a parabola:

    u(s) = c₀ + c₁ s + c₂ s²,   s = (t − tₙ)/H,   c₁ = −3u₀ + 4u½ − u₁,   c₂ = 2u₀ − 4u½ + 2u₁.

Straight lines from u₀ over u½ to u₁ (`Way.LINES`) are of second order, and stable where a parabola,
solved for its values, is not.

An FMU that holds its inputs gets values that act like the course. A held value with the right mean
gives a velocity that a force drives, but not the displacement: that is off by H³/96 of the force's
rate in a half step, and lets an undamped pair gain energy. Two values one after the other, with the
right first moment besides, ∫u ds and ∫s u ds, act to the fourth order like the course itself, at
their end. For a course a + bσ + cσ² over both, they are

    a + b/6   and   a + 5b/6 + 2c/3.

Everything here is a row of three weights: of u₀, u½ and u₁.
"""

from __future__ import annotations

from enum import Enum

import numpy as np

PARABOLA = np.array([[1.0, 0.0, 0.0], [-3.0, 4.0, -1.0], [2.0, -4.0, 2.0]])
"""Coefficients c₀, c₁, c₂ of the three values."""


class Way(Enum):
    """How inputs pass through their three values."""

    PARABOLA = "parabola"
    LINES = "straight lines"

    @property
    def mean(self) -> np.ndarray:
        """The mean over the step: Simpson's rule, or the trapezoid."""
        weight = 4.0 if self is Way.PARABOLA else 2.0
        return np.array([1.0, weight, 1.0]) / (2.0 + weight)

    def at(self, s: float) -> np.ndarray:
        """The value at s."""
        return self.expansion(s)[0]

    def expansion(self, s: float) -> np.ndarray:
        """Value, first and half of the second derivative by s, at s and after it."""
        if self is Way.PARABOLA:
            start, slope, bend = PARABOLA
            return np.array([start + s * slope + s * s * bend, slope + 2 * s * bend, bend])
        if s < 0.5:
            return np.array([[1 - 2 * s, 2 * s, 0.0], [-2.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
        return np.array([[0.0, 2 - 2 * s, 2 * s - 1], [0.0, -2.0, 2.0], [0.0, 0.0, 0.0]])

    @property
    def held_pieces(self) -> int:
        """How many values are held in a step, at least."""
        return 4 if self is Way.PARABOLA else 2

    def held(self, piece: int, pieces: int) -> np.ndarray:
        """What is held in one of so many pieces, a multiple of `held_pieces`."""
        if self is Way.LINES:
            a, b, _ = self.expansion(piece / pieces)
            return a + b / (2 * pieces)
        second = piece % 2
        a, b, c = self.expansion((piece - second) / pieces)
        both = 2 / pieces
        return a + b * both * 5 / 6 + c * both**2 * 2 / 3 if second else a + b * both / 6
