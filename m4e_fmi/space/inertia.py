"""Articulated inertias: what a body and all that hangs on it oppose to accelerations.

Featherstone, "Rigid Body Dynamics Algorithms", chapter 7. An inertia H is felt at the body's origin
in world axes: H (a, α) is the wrench that gives the origin the acceleration a [m/s²] and the body
the angular acceleration α [rad/s²].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.program import AnyScalar
from m4e_fmi.space.freedoms import Freedom
from m4e_fmi.space.vectors import (
    ABOUT_Y,
    TURN,
    UP,
    Matrix,
    Vector,
    cross,
    dot,
    minus,
    plus,
    scaled,
    times,
)


@dataclass(frozen=True)
class Elimination:
    """The acceleration of one coordinate of a joint, eliminated from an inertia.

    It is driven by what acts along its `freedom`, and is then (… − `row` · a) of what is left of
    (a, α); its own effect on the body is `column`. Both are by component.
    """

    freedom: Freedom
    pivot: AnyScalar
    row: dict[int, AnyScalar]
    column: dict[int, AnyScalar]

    def value(self, free: AnyScalar, motion: Sequence[AnyScalar]) -> AnyScalar:
        """The acceleration, with its part `free` of what is left and with the motion (a, α)."""
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
