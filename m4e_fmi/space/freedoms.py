"""Columns of a joint's motion subspace: the motion of its child at unit rate of a coordinate.

In world axes, at the origin of the child. A `Twist` is a motion against the parent; a `Component`
is one of the child's own motion, which the parent's does not enter: its elimination is cheaper,
see `multibody/recursion.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from m4e_fmi.program import AnyScalar
from m4e_fmi.space.vectors import (
    TURN,
    ZERO,
    Matrix,
    Vector,
    Wrench,
    X,
    Z,
    added,
    dot,
    scaled,
    tilde,
)


@dataclass(frozen=True)
class Component:
    """Component `index` of the body's own motion (v_x, v_z, ω).

    Its coordinate is the body's, or if `relative` that less the parent's. A joint has its
    components after its twists, in the order of their indices.
    """

    index: int
    relative: bool = True
    direction: ClassVar[Vector] = ZERO

    def along(self, wrench: Sequence[AnyScalar]) -> AnyScalar:
        """The generalized force of a wrench (F_x, F_z, M_y) about the body's origin."""
        return wrench[self.index]

    def momentum(
        self, mass: AnyScalar, lever: Vector, second: AnyScalar
    ) -> tuple[Vector, AnyScalar]:
        """Linear and angular momentum about the origin at unit rate.

        Of a body with mass [kg], tilde of the first moment [kg·m] and second moment [kg·m²].
        """
        if self.index == TURN:
            return lever, second
        return ((mass, 0), (0, mass))[self.index], lever[self.index]

    def column(self, lever: Vector, turning: AnyScalar) -> Wrench:
        """Velocities (v_x, v_z, ω) at unit rate of the point at `lever` [m] from the origin.

        `turning` is 1 for a body that turns with this one, 0 for any other.
        """
        if self.index == TURN:
            return (*tilde(lever), turning)
        return (1, 0, 0) if self.index == X else (0, 1, 0)

    def column_rate(self, growth: Vector) -> Wrench | None:
        """Time derivative of `column` for a lever with rate `growth` [m/s]; None if always zero."""
        return (*tilde(growth), 0) if self.index == TURN else None

    def elimination(
        self, H: Matrix, size: int, *, symmetric: bool
    ) -> tuple[AnyScalar, list[AnyScalar], list[AnyScalar]]:
        """Pivot, row and column of the coordinate in the first `size` rows of an inertia `H`.

        The acceleration along the coordinate is (force − row · a) / pivot with the row divided by
        the pivot; what it does to the body is `column`.
        """
        del size, symmetric
        c = self.index
        row = [H[c][b] / H[c][c] for b in range(c)]
        return H[c][c], row, [H[a][c] for a in range(c)]

    def move(self, motion: list[AnyScalar], rate: AnyScalar) -> None:
        """Turn (a_x, a_z, α) of a body fixed to the parent into the child's, by its own `rate`."""
        motion[self.index] = motion[self.index] + rate if self.relative else rate

    def set(self, motion: list[AnyScalar], value: AnyScalar) -> None:
        """The same by the `value` that an elimination gives."""
        motion[self.index] = value

    def rate(self, value: AnyScalar, fixed: Sequence[AnyScalar]) -> AnyScalar:
        """The rate of the coordinate's velocity, from that value.

        `fixed` is (a_x, a_z, α) of a body fixed to the parent.
        """
        return value - fixed[self.index] if self.relative else value


@dataclass(frozen=True)
class Twist:
    """A motion against the parent: along `direction`, and `turning` by 1 rad or not.

    `omega` [rad/s] is that of the axes in which the direction is fixed: the parent's.
    """

    direction: Vector
    omega: AnyScalar
    turning: bool = False

    def along(self, wrench: Sequence[AnyScalar]) -> AnyScalar:
        """Force along the direction, and the moment if it turns."""
        force = dot(self.direction, wrench)
        return force + wrench[TURN] if self.turning else force

    def momentum(
        self, mass: AnyScalar, lever: Vector, second: AnyScalar
    ) -> tuple[Vector, AnyScalar]:
        """Linear and angular momentum about the origin at unit rate."""
        linear = scaled(mass, self.direction)
        if not self.turning:
            return linear, dot(lever, self.direction)
        return added(linear, lever), dot(lever, self.direction) + second

    def column(self, lever: Vector, turning: AnyScalar) -> Wrench:
        """Velocities (v_x, v_z, ω) at unit rate of the point at `lever` [m] from the origin."""
        if not self.turning:
            return (*self.direction, 0)
        return (*added(self.direction, tilde(lever)), turning)

    def column_rate(self, growth: Vector) -> Wrench | None:
        """Time derivative of `column` for a lever with rate `growth` [m/s]."""
        rate = scaled(self.omega, tilde(self.direction))
        return (*added(rate, tilde(growth)), 0) if self.turning else (*rate, 0)

    def elimination(
        self, H: Matrix, size: int, *, symmetric: bool
    ) -> tuple[AnyScalar, list[AnyScalar], list[AnyScalar]]:
        """Pivot, row and column of the coordinate in the first `size` rows of an inertia `H`."""
        n = self.direction
        column = [H[a][X] * n[0] + H[a][Z] * n[1] for a in range(size)]
        if self.turning:
            column = [part + H[a][TURN] for a, part in enumerate(column)]
        row = column
        if not symmetric:
            row = [n[0] * H[X][b] + n[1] * H[Z][b] for b in range(size)]
            if self.turning:
                row = [part + H[TURN][b] for b, part in enumerate(row)]
        pivot = self.along(column)
        return pivot, [entry / pivot for entry in row], column

    def move(self, motion: list[AnyScalar], rate: AnyScalar) -> None:
        """Turn (a_x, a_z, α) of a body fixed to the parent into the child's, by its own `rate`."""
        motion[:TURN] = added((motion[X], motion[Z]), scaled(rate, self.direction))
        if self.turning:
            motion[TURN] = motion[TURN] + rate

    def set(self, motion: list[AnyScalar], value: AnyScalar) -> None:
        """The same by the `value` that an elimination gives."""
        self.move(motion, value)

    def rate(self, value: AnyScalar, fixed: Sequence[AnyScalar]) -> AnyScalar:
        """The rate of the coordinate's velocity: that value itself."""
        del fixed
        return value


Freedom = Component | Twist
"""The motion (v_x, v_z, ω) of a body at unit rate of one coordinate of its joint.

`direction` is its part that depends on the configuration (1, or m/rad); `ZERO` if it has none.
"""
