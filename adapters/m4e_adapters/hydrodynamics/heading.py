"""The heading of hulls in space: axes turned about Z, and vectors and matrices in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import X_Y_PAIRS
from m4e_fmi.program import Scalar, cos, sin

Number = Scalar | float
PER_BODY = 6


@dataclass(frozen=True)
class Heading:
    """`angle` [deg] of the hulls' x axis from +X towards +Y in the reference pose.

    The angle is a parameter, which keeps its value if it is `fixed`.
    """

    angle: float = 0.0
    fixed: bool = False


@dataclass(frozen=True)
class Axes:
    """Axes that are turned about Z by an `angle` [rad], its `cosine` and `sine`."""

    angle: Number
    cosine: Number
    sine: Number

    @classmethod
    def at(cls, angle: Number) -> Axes:
        """Axes turned by `angle` [rad]."""
        return cls(angle, cos(angle), sin(angle))

    def to_world(self, vector: Sequence[Number]) -> list[Number]:
        """World components of a `vector` (6·N,) of motions or forces in these axes."""
        return self._turned(vector, self.sine)

    def from_world(self, vector: Sequence[Number]) -> list[Number]:
        """Components in these axes of a `vector` (6·N,) in world axes."""
        return self._turned(vector, -self.sine)

    def _turned(self, vector: Sequence[Number], sine: Number) -> list[Number]:
        found = list(vector)
        for body in range(0, len(found), PER_BODY):
            for pair in X_Y_PAIRS:
                x, y = vector[body + pair], vector[body + pair + 1]
                found[body + pair] = self.cosine * x - sine * y
                found[body + pair + 1] = sine * x + self.cosine * y
        return found

    def matrix_to_world(self, matrix: np.ndarray) -> list[list[Number]]:
        """World components of a `matrix` (n, n), in any unit, that is in these axes."""
        columns = [self.to_world([float(v) for v in column]) for column in matrix.T]
        return [self.to_world(row) for row in zip(*columns, strict=True)]


def reference_places(centers: np.ndarray, reference: Axes) -> list[tuple[Number, Number]]:
    """Reference places (x, y) [m] of the bodies, turned as one.

    `centers` (N, 3) [m] are those with heading 0. They turn about the vertical through the middle.
    """
    middle = centers[:, :2].mean(axis=0)
    places: list[tuple[Number, Number]] = []
    for dx, dy in (centers[:, :2] - middle).tolist():
        x, y, *_ = reference.to_world([dx, dy, 0.0, 0.0, 0.0, 0.0])
        places.append((float(middle[0]) + x, float(middle[1]) + y))
    return places
