"""What knows that the world has two dimensions: rotation, arms, moments.

World frame X right, Z up; θ > 0 turns +Z towards +X (about +Y). All functions work over any scalar.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from m4e_fmi.program import Scalar, cos, sin, sqrt

Pair = tuple[Any, Any]
SMALLEST_SQUARE = 1e-300


@dataclass(frozen=True)
class Rotation:
    """The rotation by an absolute angle, body axes → world axes: R = [[c, s], [−s, c]]."""

    c: Any = 1
    s: Any = 0

    @classmethod
    def by(cls, angle: Any) -> Rotation:
        return cls(cos(angle), sin(angle))

    def __call__(self, vector: Pair) -> Pair:
        x, z = vector
        return self.c * x + self.s * z, self.c * z - self.s * x


def tilde(arm: Pair) -> Pair:
    """d(arm)/dθ of an arm that turns with a body: (x, z) → (z, −x)."""
    x, z = arm
    return z, -x


def swung(vector: Pair, rate: Any, arm: Pair) -> Pair:
    """vector + rate · tilde(arm): what turning adds at the end of an arm."""
    return vector[0] + rate * arm[1], vector[1] - rate * arm[0]


def moment(arm: Pair, force: Pair) -> Any:
    """Moment about +Y of a force at an arm: z F_x − x F_z."""
    return arm[1] * force[0] - arm[0] * force[1]


def added(a: Pair, b: Pair) -> Pair:
    return a[0] + b[0], a[1] + b[1]


def subtracted(a: Pair, b: Pair) -> Pair:
    return a[0] - b[0], a[1] - b[1]


def scaled(factor: Any, a: Pair) -> Pair:
    return factor * a[0], factor * a[1]


def dot(a: Pair, b: Pair) -> Any:
    return a[0] * b[0] + a[1] * b[1]


def norm(a: Pair) -> Any:
    """|a|; of numbers and on a tape 1e-150 where a is 0, where its derivative is 0.

    So what is divided by it is finite. 1e-300 changes no double but those below 1e-142.
    """
    square = dot(a, a)
    return sqrt(square + SMALLEST_SQUARE if isinstance(square, Scalar | float) else square)
