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
    added,
    cross,
    is_zero,
    minus,
    moment_of,
    plus,
    times,
)


@dataclass(frozen=True)
class Component:
    """Component `index` of the body's own motion (v, ω).

    Its coordinate is the body's, or if `relative` that less the parent's. A joint has its
    components after its twists, in the order of their indices. One that turns is about an axis that
    stands still in the parent and in the world.
    """

    index: int
    relative: bool = True
    direction: ClassVar[Vector] = ZERO

    @property
    def turning(self) -> Vector:
        """The axis about which it turns the body, `ZERO` if it does not."""
        return moment_of(self._motion)

    @property
    def _motion(self) -> list[AnyScalar]:
        motion: list[AnyScalar] = [0] * (2 * TURN)
        motion[self.index] = 1
        return motion

    def along(self, wrench: Sequence[AnyScalar]) -> AnyScalar:
        """The generalized force of a wrench about the body's origin."""
        return wrench[self.index]

    def column(self, lever: Vector, spin: bool) -> list[AnyScalar]:
        """Motion (v, ω) at unit rate of the point at `lever` [m] from the origin.

        Of a body that turns with this one if `spin`, else of any other.
        """
        if self.index < TURN:
            return self._motion
        axis = self.turning
        return [*cross(axis, lever), *(axis if spin else ZERO)]

    def column_rate(self, growth: Vector) -> Wrench | None:
        """Time derivative of `column` for a lever with rate `growth` [m/s]; None if always zero."""
        return None if self.index < TURN else (*cross(self.turning, growth), 0, 0, 0)

    def elimination(
        self, H: Matrix, left: Sequence[int], *, symmetric: bool
    ) -> tuple[AnyScalar, dict[int, AnyScalar], dict[int, AnyScalar]]:
        """Pivot, row and column of the coordinate in the components `left` of an inertia `H`.

        The acceleration along the coordinate is (force − row · a) / pivot with the row divided by
        the pivot; what it does to the body is the column.
        """
        del symmetric
        c = self.index
        rest = [a for a in left if a != c]
        return H[c][c], {b: H[c][b] / H[c][c] for b in rest}, {a: H[a][c] for a in rest}

    def move(self, motion: list[AnyScalar], rate: AnyScalar) -> None:
        """Turn the motion (a, α) of a body fixed to the parent into the child's, by its `rate`."""
        motion[self.index] = plus(motion[self.index], rate) if self.relative else rate

    def set(self, motion: list[AnyScalar], value: AnyScalar) -> None:
        """The same by the `value` that an elimination gives."""
        motion[self.index] = value

    def rate(self, value: AnyScalar, fixed: Sequence[AnyScalar]) -> AnyScalar:
        """The rate of the coordinate's velocity, from that value.

        `fixed` is the motion (a, α) of a body fixed to the parent.
        """
        return minus(value, fixed[self.index]) if self.relative else value


@dataclass(frozen=True)
class Twist:
    """A motion against the parent: along `direction`, and about `turning` by 1 rad.

    `omega` [rad/s] is that of the axes in which both are fixed: the parent's.
    """

    direction: Vector
    omega: Vector
    turning: Vector = ZERO

    @property
    def _parts(self) -> list[tuple[int, AnyScalar]]:
        motion = enumerate((*self.direction, *self.turning))
        return [(c, part) for c, part in motion if not is_zero(part)]

    def along(self, wrench: Sequence[AnyScalar]) -> AnyScalar:
        """The generalized force of a wrench about the body's origin."""
        total: AnyScalar = 0
        for c, part in self._parts:
            total = plus(total, times(part, wrench[c]))
        return total

    def column(self, lever: Vector, spin: bool) -> list[AnyScalar]:
        """Motion (v, ω) at unit rate of the point at `lever` [m] from the origin."""
        return [
            *added(self.direction, cross(self.turning, lever)),
            *(self.turning if spin else ZERO),
        ]

    def column_rate(self, growth: Vector) -> Wrench | None:
        """Time derivative of `column` for a lever with rate `growth` [m/s]."""
        rate = added(cross(self.omega, self.direction), cross(self.turning, growth))
        return (*rate, *cross(self.omega, self.turning))

    def elimination(
        self, H: Matrix, left: Sequence[int], *, symmetric: bool
    ) -> tuple[AnyScalar, dict[int, AnyScalar], dict[int, AnyScalar]]:
        """Pivot, row and column of the coordinate in the components `left` of an inertia `H`."""
        column = {a: self.along(H[a]) for a in left}
        row = column
        if not symmetric:
            row = {b: self.along([line[b] for line in H]) for b in left}
        pivot = self.along([column.get(c, 0) for c in range(2 * TURN)])
        return pivot, {b: entry / pivot for b, entry in row.items()}, column

    def move(self, motion: list[AnyScalar], rate: AnyScalar) -> None:
        """Turn the motion (a, α) of a body fixed to the parent into the child's, by its `rate`."""
        for c, part in self._parts:
            motion[c] = plus(motion[c], times(rate, part))

    def set(self, motion: list[AnyScalar], value: AnyScalar) -> None:
        """The same by the `value` that an elimination gives."""
        self.move(motion, value)

    def rate(self, value: AnyScalar, fixed: Sequence[AnyScalar]) -> AnyScalar:
        """The rate of the coordinate's velocity: that value itself."""
        del fixed
        return value


Freedom = Component | Twist
"""The motion (v, ω) of a body at unit rate of one coordinate of its joint.

`direction` is its part that depends on the configuration (1, or m/rad); `ZERO` if it has none.
"""
