"""Joint accelerations by the articulated-body algorithm: a cost that grows with the bodies.

Featherstone, "Rigid Body Dynamics Algorithms", chapter 7, for planar trees in absolute angles and
world axes. What hangs on a link is felt at its origin as H (a, α) − f, the wrench that gives the
origin the acceleration a and the link the angular acceleration α. From the leaves inwards each
joint's own acceleration is eliminated from it and the rest handed to the parent; from the ground
outwards the accelerations follow. A hinge hands on a force only: the acceleration of an absolute
angle is the body's own, so a chain of hinges hands on 2×2 matrices.

Gravity is an acceleration of the ground: `a` is the true acceleration plus (0, gravity). Added
mass does not feel gravity and has that difference in its f.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from m4e_fmi.multibody.assembly import Accelerations, Assembly, Matrix
from m4e_fmi.multibody.kinematics import Frame
from m4e_fmi.multibody.planar import Pair, added, dot, moment, scaled, subtracted, swung, tilde

X, Z, TURN = 0, 1, 2


@dataclass
class _Felt:
    """H and f of one link; of a symmetric H the entries below the diagonal are those above."""

    H: Matrix
    f: list[Any]
    symmetric: bool

    def pairs(self, size: int) -> list[tuple[int, int]]:
        """Places of H that have to be computed, in its first `size` rows and columns."""
        first = [(a, a if self.symmetric else 0) for a in range(size)]
        return [(a, b) for a, start in first for b in range(start, size)]

    def set(self, a: int, b: int, value: Any) -> None:
        self.H[a][b] = value
        if self.symmetric:
            self.H[b][a] = value


@dataclass(frozen=True)
class _Solved:
    """The eliminated acceleration: `free` − `row` · (what it still depends on)."""

    free: Any
    row: list[Any]

    def value(self, acceleration: Sequence[Any]) -> Any:
        result = self.free
        for weight, a in zip(self.row, acceleration, strict=False):
            result = result - weight * a
        return result


def accelerations(assembly: Assembly) -> Accelerations:
    """u̇ and the accelerations of all bodies. Added mass must not couple bodies."""
    tree = assembly.tree
    felt = [_own(assembly, k) for k in range(len(tree.links))]
    _mark_unsymmetric(assembly, felt)
    solved: list[list[_Solved]] = [[] for _ in felt]
    for k in range(len(felt) - 1, -1, -1):
        link, frame, effort = tree.links[k], assembly.frames[k], assembly.efforts[k]
        on_ground = link.parent < 0
        if link.joint.type == "prismatic":
            solved[k] = [_eliminate_slide(felt[k], frame, effort, last=on_ground)]
        elif link.joint.type == "revolute":
            solved[k] = [_eliminate(felt[k], TURN, effort, last=on_ground)]
        else:
            solved[k] = [_eliminate(felt[k], c, 0) for c in (TURN, Z)]
            solved[k].append(_eliminate(felt[k], X, 0, last=True))
        if not on_ground:
            _hand_on(felt[k], felt[link.parent], assembly, k)
    return _outwards(assembly, solved)


def _own(assembly: Assembly, k: int) -> _Felt:
    """H and f of link k alone."""
    frame, (mass, inertia) = assembly.frames[k], assembly.masses[k]
    push_x, push_z, turn = assembly.wrenches[k]
    first = scaled(mass, frame.arm)
    lever = tilde(first)
    about = inertia + mass * dot(frame.local_arm, frame.local_arm)
    x, z = scaled(frame.omega * frame.omega, first)
    felt = _Felt(
        [[mass, 0, lever[0]], [0, mass, lever[1]], [lever[0], lever[1], about]],
        [x + push_x, z + push_z, turn],
        symmetric=True,
    )
    if (k, k) in assembly.added_mass:
        _add_water(felt, assembly.added_mass[k, k], frame, assembly.gravity)
    return felt


def _add_water(felt: _Felt, block: Matrix, frame: Frame, gravity: Any) -> None:
    """Add an added mass about the centre of gravity, which feels the true acceleration there."""
    arm = frame.arm
    x, z = frame.acceleration_at(frame.arm, (0, -gravity), 0)
    columns = [[row[0], row[1], row[2] + moment(arm, (row[0], row[1]))] for row in block]
    bias = [row[0] * x + row[1] * z for row in block]
    for b in range(3):
        felt.H[X][b] = felt.H[X][b] + columns[X][b]
        felt.H[Z][b] = felt.H[Z][b] + columns[Z][b]
        turning = columns[TURN][b] + moment(arm, (columns[X][b], columns[Z][b]))
        felt.H[TURN][b] = felt.H[TURN][b] + turning
    felt.f[X] = felt.f[X] - bias[X]
    felt.f[Z] = felt.f[Z] - bias[Z]
    felt.f[TURN] = felt.f[TURN] - (bias[TURN] + moment(arm, (bias[X], bias[Z])))


def _mark_unsymmetric(assembly: Assembly, felt: list[_Felt]) -> None:
    """An added mass is taken as it is given; what it makes unsymmetric is so up to the ground."""
    for k, _ in assembly.added_mass:
        while k >= 0:
            felt[k].symmetric = False
            k = assembly.tree.links[k].parent


def _eliminate(felt: _Felt, c: int, effort: Any, *, last: bool = False) -> _Solved:
    """Eliminate component `c` of (a_x, a_z, α), the last that is left, driven by `effort`."""
    pivot = felt.H[c][c]
    solved = _Solved((effort + felt.f[c]) / pivot, [felt.H[c][b] / pivot for b in range(c)])
    if not last:
        _reduce(felt, [felt.H[a][c] for a in range(c)], solved)
    return solved


def _eliminate_slide(felt: _Felt, frame: Frame, effort: Any, *, last: bool) -> _Solved:
    """Eliminate the acceleration along the direction of a prismatic joint."""
    n, H = frame.direction, felt.H
    size = 3 if frame.turns else 2
    column = [H[a][X] * n[0] + H[a][Z] * n[1] for a in range(size)]
    row = column
    if not felt.symmetric:
        row = [n[0] * H[X][b] + n[1] * H[Z][b] for b in range(size)]
    pivot = dot(n, (column[X], column[Z]))
    free = (effort + dot(n, (felt.f[X], felt.f[Z]))) / pivot
    solved = _Solved(free, [entry / pivot for entry in row])
    if not last:
        _reduce(felt, column, solved)
    return solved


def _reduce(felt: _Felt, column: list[Any], solved: _Solved) -> None:
    """Put an eliminated acceleration, which acts through `column`, into H and f."""
    for a, b in felt.pairs(len(column)):
        felt.set(a, b, felt.H[a][b] - column[a] * solved.row[b])
    for a, entry in enumerate(column):
        felt.f[a] = felt.f[a] - entry * solved.free


def _hand_on(felt: _Felt, parent: _Felt, assembly: Assembly, k: int) -> None:
    """Add to the parent's H and f what it feels of link `k` through its joint."""
    link, frame, H = assembly.tree.links[k], assembly.frames[k], felt.H
    f = [felt.f[a] + dot((H[a][X], H[a][Z]), frame.inward) for a in (X, Z)]
    for a, b in parent.pairs(2):
        parent.set(a, b, parent.H[a][b] + H[a][b])
    parent.f[X] = parent.f[X] + f[X]
    parent.f[Z] = parent.f[Z] + f[Z]
    if not assembly.frames[link.parent].turns:
        return
    reach = frame.reach
    column = [moment(reach, (H[a][X], H[a][Z])) for a in (X, Z)]
    row = column if felt.symmetric else [moment(reach, (H[X][b], H[Z][b])) for b in (X, Z)]
    turn, push = moment(reach, (column[X], column[Z])), moment(reach, (f[X], f[Z]))
    if link.joint.type == "prismatic":  # a slider turns with its parent, a hinge does not
        turn = turn + (moment(reach, (H[X][TURN], H[Z][TURN])) + H[TURN][TURN])
        turn = turn + moment(reach, (H[TURN][X], H[TURN][Z]))
        push = push + (felt.f[TURN] + dot((H[TURN][X], H[TURN][Z]), frame.inward))
        column = [column[a] + H[a][TURN] for a in (X, Z)]
        row = [row[b] + H[TURN][b] for b in (X, Z)]
    else:
        push = push - assembly.efforts[k]
    for a in (X, Z):
        parent.set(a, TURN, parent.H[a][TURN] + column[a])
        if not parent.symmetric:
            parent.set(TURN, a, parent.H[TURN][a] + row[a])
    parent.H[TURN][TURN] = parent.H[TURN][TURN] + turn
    parent.f[TURN] = parent.f[TURN] + push


def _outwards(assembly: Assembly, solved: list[list[_Solved]]) -> Accelerations:
    """Accelerations from the ground to the leaves."""
    tree, gravity = assembly.tree, assembly.gravity
    rates: list[Any] = [0] * len(tree.coordinate_names)
    origins: list[Pair] = []
    alphas: list[Any] = []
    for k, link in enumerate(tree.links):
        frame = assembly.frames[k]
        origin, alpha = (0, gravity), 0
        if link.parent >= 0:
            origin, alpha = origins[link.parent], alphas[link.parent]
            origin = subtracted(swung(origin, alpha, frame.reach), frame.inward)
        if link.joint.type == "floating":
            x = solved[k][2].value(())
            z = solved[k][1].value((x,))
            origin, alpha = (x, z), solved[k][0].value((x, z))
            new = [x, z - gravity, alpha]
        elif link.joint.type == "revolute":
            alpha = solved[k][0].value(origin)
            new = [alpha]
        else:
            new = [solved[k][0].value((*origin, alpha))]
            origin = added(origin, scaled(new[0], frame.direction))
        for coordinate, rate in zip(link.coordinates, new, strict=True):
            rates[coordinate] = rate
        origins.append(origin)
        alphas.append(alpha)
    return Accelerations(rates, origins, alphas, gravity)
