"""Columns of a joint's motion subspace, and articulated inertias, from which they are eliminated.

A column is the motion of a joint's child at unit rate of a coordinate, in world axes, at the origin
of the child. A `Twist` is a motion against the parent; a `MotionComponent` is one of the child's
own motion, which the parent's does not enter: its elimination is cheaper, see
`multibody/recursion.py`.

An articulated inertia is what a body and all that hangs on it oppose to accelerations
(Featherstone, "Rigid Body Dynamics Algorithms", chapter 7). It is felt at the body's origin in
world axes: H (a, α) is the wrench that gives the origin the acceleration a [m/s²] and the body the
angular acceleration α [rad/s²].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from m4e_fmi.program import AnyScalar
from m4e_fmi.space.vectors import (
    ABOUT_Y,
    TURN,
    UP,
    ZERO,
    Matrix,
    Vector,
    Wrench,
    added,
    cross,
    dot,
    is_zero,
    minus,
    moment_of,
    plus,
    scaled,
    times,
)


@dataclass(frozen=True)
class MotionComponent:
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


Freedom = MotionComponent | Twist
"""The motion (v, ω) of a body at unit rate of one coordinate of its joint.

`direction` is its part that depends on the configuration (1, or m/rad); `ZERO` if it has none.
"""


@dataclass(frozen=True)
class Elimination:
    """The acceleration of one coordinate of a joint, eliminated from an inertia.

    It is a part driven by the effort along its `freedom`, minus `row` · (a, α), the remaining
    motion; its own effect on the body is `column`. Both are by component.
    """

    freedom: Freedom
    pivot: AnyScalar
    row: dict[int, AnyScalar]
    column: dict[int, AnyScalar]

    def value(self, free: AnyScalar, motion: Sequence[AnyScalar]) -> AnyScalar:
        """The acceleration from its driven part `free` and the remaining `motion` (a, α)."""
        for c, weight in self.row.items():
            free = minus(free, times(weight, motion[c]))
        return free


@dataclass
class Inertia:
    """H (6, 6) in kg, kg·m, kg·m², in the `components` of the motions that there are.

    Of a symmetric one the entries below the diagonal are copies; those of other components are 0.
    """

    H: Matrix
    components: Sequence[int]
    symmetric: bool = True

    @classmethod
    def rigid(
        cls, mass: AnyScalar, second: Matrix, arm: Vector, components: Sequence[int]
    ) -> Inertia:
        """Of a rigid body with its centre of gravity at `arm` [m] from the origin.

        `second` [kg·m²] (3, 3) is about the origin, in world axes.
        """
        H: Matrix = [[0] * (2 * TURN) for _ in range(2 * TURN)]
        first = scaled(mass, arm)
        axes = ((1, 0, 0), ABOUT_Y, UP)
        pushes = [cross(axis, first) for axis in axes]  # for each angular acceleration
        for a in components:
            for b in components:
                if a < TURN and b < TURN:
                    H[a][b] = mass if a == b else 0
                elif a >= TURN and b >= TURN:
                    H[a][b] = second[a - TURN][b - TURN]
                else:
                    H[a][b] = pushes[max(a, b) - TURN][min(a, b)]
        return cls(H, components)

    def add_at(self, block: Matrix, arm: Vector) -> None:
        """Add an inertia (6, 6) that is about the point at `arm` [m], such as added mass."""
        columns = [[*row[:TURN], *_sum(row[TURN:], _about(arm, row))] for row in block]
        for b in self.components:
            column = [row[b] for row in columns]
            column[TURN:] = _sum(column[TURN:], _about(arm, column))
            for a in self.components:
                self.H[a][b] = plus(self.H[a][b], column[a])

    def reduce(self, out: Elimination) -> None:
        """Put an eliminated acceleration into H."""
        for a, b in self._places(tuple(out.column)):
            self._set(a, b, minus(self.H[a][b], times(out.column[a], out.row[b])))

    def add_child(
        self, child: Inertia, reach: Vector, left: Sequence[int], *, rotates: bool
    ) -> None:
        """Add a reduced inertia whose origin is at `reach` [m].

        `left` are the components that its joint hands on; `rotates`: this body ever turns.
        """
        pushes = [c for c in left if c < TURN]
        turns = [c for c in left if c >= TURN]
        for a, b in self._places(pushes):
            self._set(a, b, plus(self.H[a][b], child.H[a][b]))
        if not rotates:
            return
        own = [c for c in self.components if c >= TURN]

        def row(a: int, parts: Sequence[int]) -> list[AnyScalar]:
            return [child.H[a][b] if b in parts else 0 for b in range(2 * TURN)]

        def column(b: int, parts: Sequence[int]) -> list[AnyScalar]:
            return [child.H[a][b] if a in parts else 0 for a in range(2 * TURN)]

        by_turning = {a: _about(reach, row(a, pushes)) for a in pushes}
        for b in own:
            moved = [by_turning[a][b - TURN] if a in by_turning else 0 for a in range(TURN)]
            turn = _about(reach, moved)
            if b in turns:
                handed = column(b, left)
                moved = _sum(moved, handed[:TURN])
                turn = _sum(turn, _sum(_about(reach, handed), handed[TURN:]))
            for a in pushes:
                self._set(a, b, plus(self.H[a][b], moved[a]))
            for a in own:
                if a > b and self.symmetric:
                    continue
                more = turn[a - TURN]
                if a in turns:
                    more = plus(more, _about(reach, row(a, pushes))[b - TURN])
                self._set(a, b, plus(self.H[a][b], more))
        if not self.symmetric:
            for b in pushes:
                handed = column(b, left)
                turn = _sum(_about(reach, handed), handed[TURN:])
                for a in own:
                    self.H[a][b] = plus(self.H[a][b], turn[a - TURN])

    def felt(
        self, wrench: Sequence[AnyScalar], inward: Sequence[AnyScalar], left: Sequence[int]
    ) -> list[AnyScalar]:
        """The wrench in the components `left`, with that for an acceleration `inward` (a, α)."""
        found: list[AnyScalar] = [0] * (2 * TURN)
        for c in left:
            found[c] = plus(wrench[c], dot(self.H[c], inward))
        return found

    def _places(self, components: Sequence[int]) -> list[tuple[int, int]]:
        """Entries to be computed in these rows and columns."""
        return [
            (a, b)
            for k, a in enumerate(components)
            for b in components[k if self.symmetric else 0 :]
        ]

    def _set(self, a: int, b: int, value: AnyScalar) -> None:
        self.H[a][b] = value
        if self.symmetric:
            self.H[b][a] = value


def _about(arm: Vector, motion: Sequence[AnyScalar]) -> list[AnyScalar]:
    """arm × the linear part of a wrench or of a row of an inertia."""
    return list(cross(arm, (motion[0], motion[1], motion[2])))


def _sum(a: Sequence[AnyScalar], b: Sequence[AnyScalar]) -> list[AnyScalar]:
    return [plus(left, right) for left, right in zip(a, b, strict=True)]
