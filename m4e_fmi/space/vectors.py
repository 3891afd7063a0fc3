"""Vectors of space, rotations and moments, over any scalar.

The integer 0 stands for a constant zero, as y in a model of the X–Z plane: nothing is computed
with it, so a planar model costs as much as with formulas of the plane.
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
SPACE = tuple(range(2 * TURN))
"""Components of all motions."""

ZERO: Vector = (0, 0, 0)
UP: Vector = (0, 0, 1)
ABOUT_Y: Vector = (0, 1, 0)
SMALLEST_SQUARE = 1e-300


def is_zero(a: AnyScalar) -> bool:
    """True for the integer 0: a constant zero."""
    return type(a) is int and a == 0


def plus(a: AnyScalar, b: AnyScalar) -> AnyScalar:
    """a + b."""
    if type(a) is int and a == 0:
        return b
    return a if type(b) is int and b == 0 else a + b


def minus(a: AnyScalar, b: AnyScalar) -> AnyScalar:
    """a − b."""
    if type(b) is int and b == 0:
        return a
    return -b if type(a) is int and a == 0 else a - b


def times(a: AnyScalar, b: AnyScalar) -> AnyScalar:
    """a · b."""
    if type(a) is int:
        return 0 if a == 0 else b if a == 1 else a * b
    if type(b) is int:
        return 0 if b == 0 else a if b == 1 else a * b
    return a * b


@dataclass(frozen=True)
class Rotation:
    """A rotation, body axes → world axes, by its matrix.

    `about` is the coordinate axis about which it turns, by `angle` [rad], if it is known to be one.
    """

    rows: tuple[Vector, Vector, Vector] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    about: int | None = None
    angle: AnyScalar = 0

    @classmethod
    def about_axis(cls, axis: int, angle: AnyScalar) -> Rotation:
        """The rotation by `angle` [rad] about +X, +Y or +Z."""
        c, s = cos(angle), sin(angle)
        rows = (
            ((1, 0, 0), (0, c, -s), (0, s, c)),
            ((c, 0, s), ABOUT_Y, (-s, 0, c)),
            ((c, -s, 0), (s, c, 0), UP),
        )
        return cls(rows[axis], axis, angle)

    @classmethod
    def of_quaternion(cls, e: Sequence[AnyScalar]) -> Rotation:
        """The rotation of a quaternion (4,), scalar part first, of any length but 0.

        It is divided by the square of its length, so that the matrix is always orthogonal.
        """
        e0, v = e[0], (e[1], e[2], e[3])
        twice = 2 / (e0 * e0 + dot(v, v))
        w = scaled(twice, v)
        xx, yy, zz = w[0] * v[0], w[1] * v[1], w[2] * v[2]
        xy, yz, zx = w[0] * v[1], w[1] * v[2], w[2] * v[0]
        x0, y0, z0 = w[0] * e0, w[1] * e0, w[2] * e0
        return cls(
            (
                (1 - (yy + zz), xy - z0, zx + y0),
                (xy + z0, 1 - (xx + zz), yz - x0),
                (zx - y0, yz + x0, 1 - (xx + yy)),
            )
        )

    def turned(self, axis: Vector, angle: AnyScalar) -> Rotation:
        """This rotation after one by `angle` [rad] about the unit vector `axis`, in body axes."""
        along = coordinate_axis(axis)
        if along is None:
            c, s = cos(angle), sin(angle)
            rest = scaled(1 - c, axis)
            x, y, z = scaled(s, axis)
            skew = ((0, times(-1, z), y), (z, 0, times(-1, x)), (times(-1, y), x, 0))
            return self._times(
                [
                    [
                        plus(plus(times(rest[i], axis[j]), c if i == j else 0), skew[i][j])
                        for j in range(TURN)
                    ]
                    for i in range(TURN)
                ]
            )
        axis_number, sign = along
        own = angle if sign > 0 else -angle
        if self.about == axis_number:
            return Rotation.about_axis(axis_number, plus(self.angle, own))
        turn = Rotation.about_axis(axis_number, own)
        return turn if self == Rotation() else self._times(turn.rows)

    def _times(self, rows: Sequence[Sequence[AnyScalar]]) -> Rotation:
        columns = list(zip(*rows, strict=True))
        x, y, z = ((dot(r, columns[0]), dot(r, columns[1]), dot(r, columns[2])) for r in self.rows)
        return Rotation((x, y, z))

    def __call__(self, vector: Vector) -> Vector:
        x, y, z = (dot(row, vector) for row in self.rows)
        return x, y, z

    def back(self, vector: Vector) -> Vector:
        """`vector` in body axes, of one in world axes."""
        x, y, z = (dot(column, vector) for column in zip(*self.rows, strict=True))
        return x, y, z

    def tensor(self, local: Matrix) -> Matrix:
        """A symmetric tensor (3, 3) in world axes, of one in body axes."""
        if self.about is not None and all(
            is_zero(local[i][j]) or i == j == self.about for i in range(TURN) for j in range(TURN)
        ):
            return local
        half = [[dot(row, column) for column in local] for row in self.rows]  # R T
        found: Matrix = [[0] * TURN for _ in range(TURN)]
        for i in range(TURN):
            for j in range(i, TURN):
                found[i][j] = found[j][i] = dot(half[i], self.rows[j])
        return found


def coordinate_axis(axis: Vector) -> tuple[int, int] | None:
    """The number of a coordinate axis and the sign, if `axis` is one by structure; else None."""
    if any(not isinstance(part, int) for part in axis) or sum(map(abs, axis)) != 1:
        return None
    number = next(c for c, part in enumerate(axis) if part)
    return number, int(axis[number])


def cross(a: Vector, b: Vector) -> Vector:
    """a × b: the moment of a force b at an arm a, or the velocity of an arm b that turns with a."""
    return swung(ZERO, a, b)


def swung(vector: Vector, rate: Vector, arm: Vector) -> Vector:
    """vector + rate × arm: what turning adds at the end of an arm."""
    x, y, z = vector
    p, q, r = rate
    a, b, c = arm
    return _turned(x, q, c, r, b), _turned(y, r, a, p, c), _turned(z, p, b, q, a)


def _turned(start: AnyScalar, a: AnyScalar, b: AnyScalar, c: AnyScalar, d: AnyScalar) -> AnyScalar:
    """start + a b − c d, without products of constant zeros."""
    if (type(a) is not int or a) and (type(b) is not int or b):
        start = plus(start, times(a, b))
    if (type(c) is not int or c) and (type(d) is not int or d):
        start = minus(start, times(c, d))
    return start


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
    """a · b, without products of constant zeros."""
    result: AnyScalar = 0
    for left, right in zip(a, b, strict=True):
        if (type(left) is not int or left) and (type(right) is not int or right):
            result = plus(result, times(left, right))
    return result


def applied(matrix: Matrix, a: Sequence[AnyScalar]) -> Vector:
    """matrix · a, with three rows."""
    x, y, z = (dot(row, a) for row in matrix)
    return x, y, z


def quadratic(matrix: Matrix, a: Vector) -> AnyScalar:
    """a · matrix · a of a symmetric matrix (3, 3)."""
    total: AnyScalar = 0
    for i in range(TURN):
        total = plus(total, times(matrix[i][i], times(a[i], a[i])))
        for j in range(i):
            total = plus(total, times(matrix[i][j], times(2, times(a[i], a[j]))))
    return total


def shifted(second: Matrix, mass: AnyScalar, arm: Vector, axes: Sequence[int]) -> Matrix:
    """second + m (|arm|² 1 − arm armᵀ): moments of inertia about a point, of those about the CG.

    Those about and between the coordinate `axes` only; the others are zero.
    """
    found: Matrix = [[0] * TURN for _ in range(TURN)]
    for i in axes:
        others = [arm[c] for c in range(TURN) if c != i]
        found[i][i] = plus(second[i][i], times(mass, dot(others, others)))
        for j in axes:
            if j > i:
                product = times(mass, times(arm[i], arm[j]))
                found[i][j] = found[j][i] = minus(second[i][j], product)
    return found


def coupled(arm: Vector, first: Vector, axes: Sequence[int]) -> Matrix:
    """2 (arm · first) 1 − arm firstᵀ − first armᵀ: what a first moment adds at an arm."""
    found: Matrix = [[0] * TURN for _ in range(TURN)]
    for i in axes:
        others = [c for c in range(TURN) if c != i]
        found[i][i] = times(2, dot([arm[c] for c in others], [first[c] for c in others]))
        for j in axes:
            if j > i:
                product = plus(times(arm[i], first[j]), times(first[i], arm[j]))
                found[i][j] = found[j][i] = minus(0, product)
    return found


def summed(a: Matrix, b: Matrix) -> Matrix:
    """a + b of symmetric matrices (3, 3)."""
    found: Matrix = [[0] * TURN for _ in range(TURN)]
    for i in range(TURN):
        for j in range(i, TURN):
            found[i][j] = found[j][i] = plus(a[i][j], b[i][j])
    return found


def unit(a: Vector) -> Vector:
    """a / |a|; a ZeroDivisionError of numbers that are all 0. ±1 of one number among zeros."""
    (x, y, z), others = a, [part for part in a if not is_zero(part)]
    if len(others) == 1 and isinstance(others[0], int | float) and others[0]:
        sign = 1 if others[0] > 0 else -1
        return sign * (not is_zero(x)), sign * (not is_zero(y)), sign * (not is_zero(z))
    length = sqrt(dot(a, a))
    x, y, z = (part if is_zero(part) else part / length for part in a)
    return x, y, z


def norm(a: Vector) -> AnyScalar:
    """|a|; of numbers and on a tape 1e-150 where a is 0, where its derivative is 0.

    So a quotient by it is finite. 1e-300 changes only doubles below 1e-142.
    """
    square = dot(a, a)
    return sqrt(square + SMALLEST_SQUARE if isinstance(square, Scalar | float | int) else square)


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
