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
    TURN,
    Matrix,
    Vector,
    X,
    Z,
    dot,
    moment,
    scaled,
    tilde,
)


@dataclass(frozen=True)
class Elimination:
    """The acceleration of one coordinate of a joint, eliminated from an inertia.

    It is driven by what acts along its `freedom`, and is then (… − `row` · a) of what is left of
    (a, α); its own effect on the body is `column`.
    """

    freedom: Freedom
    pivot: AnyScalar
    row: list[AnyScalar]
    column: list[AnyScalar]

    def value(self, free: AnyScalar, acceleration: Sequence[AnyScalar]) -> AnyScalar:
        """The acceleration, with its part `free` of what is left and with (a_x, a_z, α)."""
        for weight, a in zip(self.row, acceleration, strict=False):
            free = free - weight * a
        return free


@dataclass
class Inertia:
    """H (3, 3) in kg, kg·m, kg·m²; of a symmetric one the entries below the diagonal are copies."""

    H: Matrix
    symmetric: bool = True

    @classmethod
    def rigid(cls, mass: AnyScalar, inertia: AnyScalar, arm: Vector, local_arm: Vector) -> Inertia:
        """Of a rigid body with its centre of gravity at `arm` [m] from the origin.

        `inertia` [kg·m²] is about the centre of gravity, `local_arm` is the arm in body axes.
        """
        lever = tilde(scaled(mass, arm))
        about = inertia + mass * dot(local_arm, local_arm)
        return cls([[mass, 0, lever[0]], [0, mass, lever[1]], [lever[0], lever[1], about]])

    def add_at(self, block: Matrix, arm: Vector) -> None:
        """Add an inertia (3, 3) that is about the point at `arm` [m], such as added mass."""
        H = self.H
        columns = [[row[0], row[1], row[2] + moment(arm, (row[0], row[1]))] for row in block]
        for b in range(3):
            H[X][b] = H[X][b] + columns[X][b]
            H[Z][b] = H[Z][b] + columns[Z][b]
            turning = columns[TURN][b] + moment(arm, (columns[X][b], columns[Z][b]))
            H[TURN][b] = H[TURN][b] + turning

    def eliminate(self, freedom: Freedom, size: int) -> Elimination:
        """The elimination of a freedom from the first `size` rows and columns; H stays as it is."""
        return Elimination(freedom, *freedom.elimination(self.H, size, symmetric=self.symmetric))

    def reduce(self, out: Elimination) -> None:
        """Put an eliminated acceleration into H."""
        for a, b in self._places(len(out.column)):
            self._set(a, b, self.H[a][b] - out.column[a] * out.row[b])

    def add_child(self, child: Inertia, reach: Vector, *, rotates: bool, with_moment: bool) -> None:
        """Add a reduced inertia whose origin is at `reach` [m].

        `rotates`: this body ever turns; `with_moment`: the joint hands on the child's moment.
        """
        H = child.H
        for a, b in self._places(2):
            self._set(a, b, self.H[a][b] + H[a][b])
        if not rotates:
            return
        column = [moment(reach, (H[a][X], H[a][Z])) for a in (X, Z)]
        row = column if child.symmetric else [moment(reach, (H[X][b], H[Z][b])) for b in (X, Z)]
        turn = moment(reach, (column[X], column[Z]))
        if with_moment:
            turn = turn + (moment(reach, (H[X][TURN], H[Z][TURN])) + H[TURN][TURN])
            turn = turn + moment(reach, (H[TURN][X], H[TURN][Z]))
            column = [column[a] + H[a][TURN] for a in (X, Z)]
            row = [row[b] + H[TURN][b] for b in (X, Z)]
        for a in (X, Z):
            self._set(a, TURN, self.H[a][TURN] + column[a])
            if not self.symmetric:
                self.H[TURN][a] = self.H[TURN][a] + row[a]
        self.H[TURN][TURN] = self.H[TURN][TURN] + turn

    def felt(self, wrench: Sequence[AnyScalar], inward: Vector) -> Vector:
        """The force [N] of a wrench, and of an acceleration `inward` [m/s²] of the origin."""
        return wrench[X] + dot(self.H[X], inward), wrench[Z] + dot(self.H[Z], inward)

    def felt_moment(self, wrench: Sequence[AnyScalar], inward: Vector) -> AnyScalar:
        """The moment [N·m] of the same."""
        return wrench[TURN] + dot(self.H[TURN], inward)

    def _places(self, size: int) -> list[tuple[int, int]]:
        """Entries to be computed in the first `size` rows and columns."""
        first = [(a, a if self.symmetric else 0) for a in range(size)]
        return [(a, b) for a, start in first for b in range(start, size)]

    def _set(self, a: int, b: int, value: AnyScalar) -> None:
        self.H[a][b] = value
        if self.symmetric:
            self.H[b][a] = value
