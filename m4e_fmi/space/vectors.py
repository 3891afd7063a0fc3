"""Vectors of space, rotations and moments, over any scalar.

The integer 0 stands for what is always zero, as y in a model of the X–Z plane: nothing is computed
with it, so a planar model costs what it would cost by formulas of the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.program import AnyScalar, Scalar, cos, sin, sqrt

Vector = tuple[AnyScalar, AnyScalar, AnyScalar]
"""(x, y, z)."""

Wrench = tuple[AnyScalar, AnyScalar, AnyScalar, AnyScalar, AnyScalar, AnyScalar]
"""Force (F_x, F_y, F_z) [N] and moment (M_x, M_y, M_z) [N·m]; or a motion (v, ω)."""

Matrix = list[list[AnyScalar]]

X, Y, Z = 0, 1, 2
TURN = 3
"""Place of the first component of an angular velocity in a motion (v, ω), of a moment in a wrench.

`TURN + Y` is that about the Y axis."""

AXES = "xyz"
PLANE = (X, Z, TURN + Y)
"""Components of the motions in the X–Z plane."""

ZERO: Vector = (0, 0, 0)
UP: Vector = (0, 0, 1)
ABOUT_Y: Vector = (0, 1, 0)
SMALLEST_SQUARE = 1e-300


def is_zero(a: AnyScalar) -> bool:
    """True of the integer 0: what is always zero."""
    return isinstance(a, int) and a == 0


def plus(a: AnyScalar, b: AnyScalar) -> AnyScalar:
    """a + b."""
    if isinstance(a, int) and a == 0:
        return b
    return a if isinstance(b, int) and b == 0 else a + b


def minus(a: AnyScalar, b: AnyScalar) -> AnyScalar:
    """a − b."""
    if isinstance(b, int) and b == 0:
        return a
    return -b if isinstance(a, int) and a == 0 else a - b


def times(a: AnyScalar, b: AnyScalar) -> AnyScalar:
    """a · b."""
    if isinstance(a, int):
        return 0 if a == 0 else b if a == 1 else a * b
    if isinstance(b, int):
        return 0 if b == 0 else a if b == 1 else a * b
    return a * b


@dataclass(frozen=True)
class Rotation:
    """A rotation, body axes → world axes, by its matrix."""

    rows: tuple[Vector, Vector, Vector] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))

    @classmethod
    def about_y(cls, angle: AnyScalar) -> Rotation:
        """The rotation by `angle` [rad] about +Y."""
        c, s = cos(angle), sin(angle)
        return cls(((c, 0, s), ABOUT_Y, (-s, 0, c)))

    def __call__(self, vector: Vector) -> Vector:
        x, y, z = (dot(row, vector) for row in self.rows)
        return x, y, z


def cross(a: Vector, b: Vector) -> Vector:
    """a × b: the moment of a force b at an arm a, or the velocity of an arm b that turns with a."""
    return (
        minus(times(a[1], b[2]), times(a[2], b[1])),
        minus(times(a[2], b[0]), times(a[0], b[2])),
        minus(times(a[0], b[1]), times(a[1], b[0])),
    )


def swung(vector: Vector, rate: Vector, arm: Vector) -> Vector:
    """vector + rate × arm: what turning adds at the end of an arm."""
    x, y, z = vector
    return (
        minus(plus(x, times(rate[1], arm[2])), times(rate[2], arm[1])),
        minus(plus(y, times(rate[2], arm[0])), times(rate[0], arm[2])),
        minus(plus(z, times(rate[0], arm[1])), times(rate[1], arm[0])),
    )


def outward(omega: Vector, arm: Vector) -> Vector:
    """ω² arm − ω (ω · arm) = −ω × (ω × arm), what turning would throw out at the end of an arm."""
    square, along = dot(omega, omega), dot(omega, arm)
    return subtracted(scaled(square, arm), scaled(along, omega))


def added(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return plus(a[0], b[0]), plus(a[1], b[1]), plus(a[2], b[2])


def subtracted(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return minus(a[0], b[0]), minus(a[1], b[1]), minus(a[2], b[2])


def scaled(factor: AnyScalar, a: Vector) -> Vector:
    """factor · a."""
    return times(factor, a[0]), times(factor, a[1]), times(factor, a[2])


def dot(a: Sequence[AnyScalar], b: Sequence[AnyScalar]) -> AnyScalar:
    """a · b."""
    result: AnyScalar = 0
    for left, right in zip(a, b, strict=True):
        result = plus(result, times(left, right))
    return result


def unit(a: Vector) -> Vector:
    """a / |a|; a ZeroDivisionError of numbers that are all 0."""
    length = sqrt(dot(a, a))
    x, y, z = (part if is_zero(part) else part / length for part in a)
    return x, y, z


def norm(a: Vector) -> AnyScalar:
    """|a|; of numbers and on a tape 1e-150 where a is 0, where its derivative is 0.

    So what is divided by it is finite. 1e-300 changes no double but those below 1e-142.
    """
    square = dot(a, a)
    return sqrt(square + SMALLEST_SQUARE if isinstance(square, Scalar | float) else square)


def force_of(wrench: Sequence[AnyScalar]) -> Vector:
    """The force of a wrench, or the linear part of a motion."""
    return wrench[0], wrench[1], wrench[2]


def moment_of(wrench: Sequence[AnyScalar]) -> Vector:
    """The moment of a wrench, or the angular part of a motion."""
    return wrench[3], wrench[4], wrench[5]


def add_force(wrench: list[AnyScalar], force: Vector, arm: Vector, torque: Vector = ZERO) -> None:
    """Add a force [N] at `arm` [m] and a moment [N·m] to a wrench."""
    wrench[:TURN] = added(force_of(wrench), force)
    wrench[TURN:] = added(moment_of(wrench), added(torque, cross(arm, force)))
