"""Vectors of the X–Z plane, rotations about +Y and moments, over any scalar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.program import AnyScalar, Scalar, cos, sin, sqrt

Vector = tuple[AnyScalar, AnyScalar]
"""(x, z)."""

Wrench = tuple[AnyScalar, AnyScalar, AnyScalar]
"""Force (F_x, F_z) [N] and moment M_y [N·m]."""

Matrix = list[list[AnyScalar]]

X, Z, TURN = 0, 1, 2
"""Places of the components of a motion (v_x, v_z, ω) or of a wrench."""

AXES = "xz"
DOFS = 3
"""Degrees of freedom of a free body."""

ZERO: Vector = (0, 0)
SMALLEST_SQUARE = 1e-300


@dataclass(frozen=True)
class Rotation:
    """The rotation by an absolute angle, body axes → world axes: R = [[c, s], [−s, c]]."""

    c: AnyScalar = 1
    s: AnyScalar = 0

    @classmethod
    def by(cls, angle: AnyScalar) -> Rotation:
        """The rotation by `angle` [rad] about +Y."""
        return cls(cos(angle), sin(angle))

    def __call__(self, vector: Vector) -> Vector:
        x, z = vector
        return self.c * x + self.s * z, self.c * z - self.s * x


def tilde(arm: Vector) -> Vector:
    """d(arm)/dθ of an arm that turns with a body: (x, z) → (z, −x)."""
    x, z = arm
    return z, -x


def swung(vector: Vector, rate: AnyScalar, arm: Vector) -> Vector:
    """vector + rate · tilde(arm): what turning adds at the end of an arm."""
    return vector[0] + rate * arm[1], vector[1] - rate * arm[0]


def moment(arm: Vector, force: Vector) -> AnyScalar:
    """Moment about +Y of a force at an arm: z F_x − x F_z."""
    return arm[1] * force[0] - arm[0] * force[1]


def add_force(wrench: list[AnyScalar], force: Vector, arm: Vector, torque: AnyScalar = 0) -> None:
    """Add a force [N] at `arm` [m] and a moment [N·m] to a wrench (F_x, F_z, M_y)."""
    wrench[X] = wrench[X] + force[0]
    wrench[Z] = wrench[Z] + force[1]
    wrench[TURN] = wrench[TURN] + (torque + moment(arm, force))


def added(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1]


def subtracted(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return a[0] - b[0], a[1] - b[1]


def scaled(factor: AnyScalar, a: Vector) -> Vector:
    """factor · a."""
    return factor * a[0], factor * a[1]


def dot(a: Sequence[AnyScalar], b: Sequence[AnyScalar]) -> AnyScalar:
    """a · b of two vectors."""
    return a[0] * b[0] + a[1] * b[1]


def unit(a: Vector) -> Vector:
    """a / |a|; a ZeroDivisionError of numbers that are all 0."""
    length = sqrt(a[0] * a[0] + a[1] * a[1])
    return a[0] / length, a[1] / length


def norm(a: Vector) -> AnyScalar:
    """|a|; of numbers and on a tape 1e-150 where a is 0, where its derivative is 0.

    So what is divided by it is finite. 1e-300 changes no double but those below 1e-142.
    """
    square = dot(a, a)
    return sqrt(square + SMALLEST_SQUARE if isinstance(square, Scalar | float) else square)
