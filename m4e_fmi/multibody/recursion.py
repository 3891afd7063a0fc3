"""Joint accelerations by the articulated-body algorithm: a cost that grows with the bodies.

Featherstone, "Rigid Body Dynamics Algorithms", chapter 7, for planar trees in absolute angles and
world axes. What hangs on a link is felt at its origin as H (a, α) − f, the wrench that gives the
origin the acceleration a and the link the angular acceleration α. From the leaves inwards each
joint's own acceleration is eliminated from it and the rest handed to the parent; from the ground
outwards the accelerations follow. A hinge hands on a force only: the acceleration of an absolute
angle is the body's own, so a chain of hinges hands on 2×2 matrices. A relative angle changes
nothing but its own acceleration, which is the difference of two absolute ones.

`factors` is what comes of H alone; `solve` takes it and the loads of a state, or a change of them:
see `sensitivity`. Added mass must not couple bodies.

Gravity is an acceleration of the ground: `a` is the true acceleration plus (0, gravity). Added
mass does not feel gravity and has that difference in its f.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from m4e_fmi.multibody.assembly import Accelerations, Assembly, Matrix
from m4e_fmi.multibody.kinematics import Frame
from m4e_fmi.multibody.space import Pair, added, dot, moment, scaled, subtracted, swung, tilde

X, Z, TURN = 0, 1, 2


@dataclass(frozen=True)
class Loads:
    """What drives a tree, for each link.

    `wrenches` f = (F_x, F_z, M_y) about the origins, `inward` the origins' accelerations against
    their parents that velocities alone cause (see `kinematics`), `efforts` of the joints; and the
    acceleration of the `ground`.
    """

    wrenches: list[list[Any]]
    inward: list[Pair]
    efforts: list[Any]
    ground: Pair


@dataclass
class Inertia:
    """H of one link; of a symmetric H the entries below the diagonal are those above."""

    H: Matrix
    symmetric: bool = True

    def pairs(self, size: int) -> list[tuple[int, int]]:
        """Places of H that have to be computed, in its first `size` rows and columns."""
        first = [(a, a if self.symmetric else 0) for a in range(size)]
        return [(a, b) for a, start in first for b in range(start, size)]

    def set(self, a: int, b: int, value: Any) -> None:
        self.H[a][b] = value
        if self.symmetric:
            self.H[b][a] = value


@dataclass(frozen=True)
class _Elimination:
    """One acceleration of a joint, along `direction` or of the component `direction`.

    It is driven by what acts along it, and is then ( … − `row` · a) of what is left of (a, α); its
    own effect on the link is `column`.
    """

    direction: int | Pair
    pivot: Any
    row: list[Any]
    column: list[Any]

    def along(self, wrench: Sequence[Any]) -> Any:
        if isinstance(self.direction, int):
            return wrench[self.direction]
        return dot(self.direction, (wrench[X], wrench[Z]))

    def value(self, free: Any, acceleration: Sequence[Any]) -> Any:
        for weight, a in zip(self.row, acceleration, strict=False):
            free = free - weight * a
        return free


@dataclass(frozen=True)
class Factors:
    """Articulated inertias as they are handed on, and the eliminations of every link."""

    inertias: list[Inertia]
    eliminations: list[list[_Elimination]]


def factors(assembly: Assembly) -> Factors:
    """Eliminate every joint's acceleration, from the leaves to the ground."""
    links = assembly.tree.links
    inertias = [own_inertia(assembly, k) for k in range(len(links))]
    for k, _ in assembly.added_mass:  # taken as it is given: what it makes unsymmetric …
        while k >= 0:
            inertias[k].symmetric = False
            k = links[k].parent  # … is so up to the ground
    eliminations: list[list[_Elimination]] = [[] for _ in links]
    for k in range(len(links) - 1, -1, -1):
        inertia, link = inertias[k], links[k]
        if link.joint.type == "prismatic":
            eliminations[k] = [_slide(inertia, assembly.frames[k])]
        elif link.joint.type == "revolute":
            eliminations[k] = [_component(inertia, TURN)]
        elif link.joint.type == "floating":
            for c in (TURN, Z, X):
                eliminations[k].append(_component(inertia, c))
                _reduce(inertia, eliminations[k][-1])
        if link.parent >= 0:
            for out in eliminations[k]:
                _reduce(inertia, out)
            _hand_on(inertia, inertias[link.parent], assembly, k)
    return Factors(inertias, eliminations)


def own_inertia(assembly: Assembly, k: int) -> Inertia:
    """H of link k alone."""
    frame, (mass, inertia) = assembly.frames[k], assembly.masses[k]
    lever = tilde(scaled(mass, frame.arm))
    about = inertia + mass * dot(frame.local_arm, frame.local_arm)
    own = Inertia([[mass, 0, lever[0]], [0, mass, lever[1]], [lever[0], lever[1], about]])
    if (k, k) not in assembly.added_mass:
        return own
    block, arm = assembly.added_mass[k, k], frame.arm
    columns = [[row[0], row[1], row[2] + moment(arm, (row[0], row[1]))] for row in block]
    for b in range(3):
        own.H[X][b] = own.H[X][b] + columns[X][b]
        own.H[Z][b] = own.H[Z][b] + columns[Z][b]
        turning = columns[TURN][b] + moment(arm, (columns[X][b], columns[Z][b]))
        own.H[TURN][b] = own.H[TURN][b] + turning
    return own


def own_loads(assembly: Assembly) -> Loads:
    """What drives the tree in its state: f of each link alone."""
    wrenches = []
    for k, frame in enumerate(assembly.frames):
        x, z = scaled(frame.omega * frame.omega, scaled(assembly.masses[k][0], frame.arm))
        push_x, push_z, turn = assembly.wrenches[k]
        f = [x + push_x, z + push_z, turn]
        if (k, k) in assembly.added_mass:  # it feels the true acceleration of the CG
            x, z = frame.acceleration_at(frame.arm, (0, -assembly.gravity), 0)
            block = assembly.added_mass[k, k]
            bias = [row[0] * x + row[1] * z for row in block]
            f[X], f[Z] = f[X] - bias[X], f[Z] - bias[Z]
            f[TURN] = f[TURN] - (bias[TURN] + moment(frame.arm, (bias[X], bias[Z])))
        wrenches.append(f)
    inward = [frame.inward for frame in assembly.frames]
    return Loads(wrenches, inward, assembly.efforts, (0, assembly.gravity))


def _component(inertia: Inertia, c: int) -> _Elimination:
    """Eliminate component `c` of (a_x, a_z, α), the last that is left."""
    H = inertia.H
    row = [H[c][b] / H[c][c] for b in range(c)]
    return _Elimination(c, H[c][c], row, [H[a][c] for a in range(c)])


def _slide(inertia: Inertia, frame: Frame) -> _Elimination:
    """Eliminate the acceleration along the direction of a prismatic joint."""
    n, H = frame.direction, inertia.H
    size = 3 if frame.turns else 2
    column = [H[a][X] * n[0] + H[a][Z] * n[1] for a in range(size)]
    row = column
    if not inertia.symmetric:
        row = [n[0] * H[X][b] + n[1] * H[Z][b] for b in range(size)]
    pivot = dot(n, (column[X], column[Z]))
    return _Elimination(n, pivot, [entry / pivot for entry in row], column)


def _reduce(inertia: Inertia, out: _Elimination) -> None:
    """Put an eliminated acceleration into H."""
    for a, b in inertia.pairs(len(out.column)):
        inertia.set(a, b, inertia.H[a][b] - out.column[a] * out.row[b])


def _hand_on(inertia: Inertia, parent: Inertia, assembly: Assembly, k: int) -> None:
    """Add to the parent's H what it feels of link `k` through its joint."""
    link, H, reach = assembly.tree.links[k], inertia.H, assembly.frames[k].reach
    for a, b in parent.pairs(2):
        parent.set(a, b, parent.H[a][b] + H[a][b])
    if not assembly.frames[link.parent].turns:
        return
    column = [moment(reach, (H[a][X], H[a][Z])) for a in (X, Z)]
    row = column if inertia.symmetric else [moment(reach, (H[X][b], H[Z][b])) for b in (X, Z)]
    turn = moment(reach, (column[X], column[Z]))
    if link.rigid:  # what turns with its parent hands on its turning, a hinge does not
        turn = turn + (moment(reach, (H[X][TURN], H[Z][TURN])) + H[TURN][TURN])
        turn = turn + moment(reach, (H[TURN][X], H[TURN][Z]))
        column = [column[a] + H[a][TURN] for a in (X, Z)]
        row = [row[b] + H[TURN][b] for b in (X, Z)]
    for a in (X, Z):
        parent.set(a, TURN, parent.H[a][TURN] + column[a])
        if not parent.symmetric:
            parent.set(TURN, a, parent.H[TURN][a] + row[a])
    parent.H[TURN][TURN] = parent.H[TURN][TURN] + turn


def solve(assembly: Assembly, factors: Factors, loads: Loads) -> Accelerations:
    """The accelerations that `loads` cause. Links on which nothing acts (zeros) cost nothing."""
    wrenches = [list(wrench) for wrench in loads.wrenches]
    free: list[list[Any]] = [[0] * len(outs) for outs in factors.eliminations]
    for k in range(len(wrenches) - 1, -1, -1):
        f, effort, inward = wrenches[k], loads.efforts[k], loads.inward[k]
        if all(isinstance(part, int) for part in (*f, effort, *inward)):
            continue
        for index, out in enumerate(factors.eliminations[k]):
            free[k][index] = (effort + out.along(f)) / out.pivot
            for a, entry in enumerate(out.column):
                f[a] = f[a] - entry * free[k][index]
        parent = assembly.tree.links[k].parent
        if parent >= 0:
            _push_on(wrenches[parent], factors.inertias[k], assembly, k, f, effort, inward)
    return _outwards(assembly, factors, loads, free)


def _push_on(
    parent: list[Any],
    inertia: Inertia,
    assembly: Assembly,
    k: int,
    f: list[Any],
    effort: Any,
    inward: Pair,
) -> None:
    """Add to the parent's f what it feels of that of link `k` through its joint."""
    H, link = inertia.H, assembly.tree.links[k]
    force = [f[a] + dot((H[a][X], H[a][Z]), inward) for a in (X, Z)]
    parent[X] = parent[X] + force[X]
    parent[Z] = parent[Z] + force[Z]
    if assembly.frames[link.parent].turns:
        push = moment(assembly.frames[k].reach, (force[X], force[Z]))
        if link.rigid:
            push = push + (f[TURN] + dot((H[TURN][X], H[TURN][Z]), inward))
        else:
            push = push - effort
        parent[TURN] = parent[TURN] + push


def _outwards(
    assembly: Assembly, factors: Factors, loads: Loads, free: list[list[Any]]
) -> Accelerations:
    """Accelerations from the ground to the leaves."""
    tree = assembly.tree
    rates: list[Any] = [0] * len(tree.coordinate_names)
    origins: list[Pair] = []
    alphas: list[Any] = []
    for k, link in enumerate(tree.links):
        origin, alpha = loads.ground, 0
        if link.parent >= 0:
            origin, alpha = origins[link.parent], alphas[link.parent]
        # what is known before α comes first: this is where everything waits
        origin = swung(subtracted(origin, loads.inward[k]), alpha, assembly.frames[k].reach)
        outs = factors.eliminations[k]
        if link.joint.type == "floating":
            x = outs[2].value(free[k][2], ())
            z = outs[1].value(free[k][1], (x,))
            origin, alpha = (x, z), outs[0].value(free[k][0], (x, z))
            new = [x, z - loads.ground[1], alpha]
        elif link.joint.type == "revolute":
            parent_alpha, alpha = alpha, outs[0].value(free[k][0], origin)
            new = [alpha - parent_alpha if link.follows else alpha]
        elif link.joint.type == "fixed":
            new = []
        else:
            new = [outs[0].value(free[k][0], (*origin, alpha))]
            origin = added(origin, scaled(new[0], assembly.frames[k].direction))
        for coordinate, rate in zip(link.coordinates, new, strict=True):
            rates[coordinate] = rate
        origins.append(origin)
        alphas.append(alpha)
    return Accelerations(rates, origins, alphas, loads.ground[1])
