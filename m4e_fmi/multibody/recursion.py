"""Joint accelerations by the articulated-body algorithm: a cost that grows with the bodies.

Featherstone, "Rigid Body Dynamics Algorithms", chapter 7, for planar trees in absolute angles and
world axes. What hangs on a link is felt at its origin as H (a, α) − f, the wrench that gives the
origin the acceleration a and the link the angular acceleration α. From the leaves inwards each
joint's own acceleration is eliminated from it and the rest handed to the parent; from the ground
outwards the accelerations follow. A hinge hands on a force only: the acceleration of an absolute
angle is the body's own, so a chain of hinges hands on 2×2 matrices. A relative angle changes
nothing but its own acceleration, which is the difference of two absolute ones.

`factors` come of H alone; `solve` takes them and the loads of a state, or a change of them: see
`sensitivity`. Added mass must not couple bodies.

Gravity is an acceleration of the ground: `a` is the true acceleration plus (0, gravity). Added
mass does not feel gravity and has that difference in its f.
"""

from __future__ import annotations

from dataclasses import dataclass

from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import (
    DOFS,
    TURN,
    Elimination,
    Inertia,
    Vector,
    X,
    Z,
    moment,
    scaled,
    subtracted,
    swung,
)

NOT_ROTATING = TURN
"""Components that matter of the motion of a body that never rotates."""


@dataclass(frozen=True)
class Loads:
    """The loads that drive a tree, for each link.

    `wrenches` f = (F_x, F_z [N], M_y [N·m]) about the origins, `inward` the origins' accelerations
    against their parents that velocities alone cause [m/s²] (see `joints/frame.py`),
    `generalized_forces` along the coordinates of each joint [N, N·m]; and the acceleration of the
    `ground` [m/s²].
    """

    wrenches: list[list[AnyScalar]]
    inward: list[Vector]
    generalized_forces: list[list[AnyScalar]]
    ground: Vector


@dataclass(frozen=True)
class Factors:
    """Articulated inertias as they are handed on, and the eliminations of every link."""

    inertias: list[Inertia]
    eliminations: list[list[Elimination]]


def factors(assembly: Assembly) -> Factors:
    """Eliminate every joint's acceleration, from the leaves to the ground."""
    links = assembly.tree.links
    inertias = [own_inertia(assembly, k) for k in range(len(links))]
    for k, _ in assembly.added_mass:  # taken as it is given: what it makes unsymmetric …
        while k >= 0:
            inertias[k].symmetric = False
            k = links[k].parent  # … is so up to the ground
    eliminations: list[list[Elimination]] = [[] for _ in links]
    for k in range(len(links) - 1, -1, -1):
        inertia, link, frame = inertias[k], links[k], assembly.frames[k]
        size = DOFS if frame.rotates else NOT_ROTATING
        outs = [inertia.eliminate(freedom, size) for freedom in frame.freedoms[-1:]]
        for freedom in frame.freedoms[-2::-1]:
            inertia.reduce(outs[-1])
            outs.append(inertia.eliminate(freedom, len(outs[-1].column)))
        eliminations[k] = outs[::-1]
        if link.parent >= 0:
            for out in outs[-1:]:
                inertia.reduce(out)
            inertias[link.parent].add_child(
                inertia,
                frame.reach,
                rotates=assembly.frames[link.parent].rotates,
                with_moment=not link.joint.joint_type.frees_rotation,
            )
    return Factors(inertias, eliminations)


def own_inertia(assembly: Assembly, k: int) -> Inertia:
    """H of link k alone."""
    frame, (mass, inertia) = assembly.frames[k], assembly.masses[k]
    own = Inertia.rigid(mass, inertia, frame.arm, frame.local_arm)
    if (k, k) in assembly.added_mass:
        own.add_at(assembly.added_mass[k, k], frame.arm)
    return own


def own_loads(assembly: Assembly) -> Loads:
    """The loads of the tree in its state: f of each link alone."""
    wrenches: list[list[AnyScalar]] = []
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
    forces = zip(assembly.tree.links, assembly.generalized_forces, strict=True)
    along = [[force] * len(link.coordinates) for link, force in forces]
    return Loads(wrenches, inward, along, (0, assembly.gravity))


def solve(assembly: Assembly, factors: Factors, loads: Loads) -> Accelerations:
    """The accelerations that `loads` cause. Links on which nothing acts (zeros) cost nothing."""
    wrenches = [list(wrench) for wrench in loads.wrenches]
    free: list[list[AnyScalar]] = [[0] * len(outs) for outs in factors.eliminations]
    for k in range(len(wrenches) - 1, -1, -1):
        f, along, inward = wrenches[k], loads.generalized_forces[k], loads.inward[k]
        if all(isinstance(part, int) for part in (*f, *along, *inward)):
            continue
        outs = factors.eliminations[k]
        for index in range(len(outs) - 1, -1, -1):
            out = outs[index]
            free[k][index] = (along[index] + out.freedom.along(f)) / out.pivot
            for a, entry in enumerate(out.column):
                f[a] = f[a] - entry * free[k][index]
        if assembly.tree.links[k].parent >= 0:
            _push_on(assembly, factors.inertias[k], loads, k, wrenches)
    return _outwards(assembly, factors, loads, free)


def _push_on(
    assembly: Assembly, inertia: Inertia, loads: Loads, k: int, wrenches: list[list[AnyScalar]]
) -> None:
    """Add to the parent's f what it feels of that of link `k` through its joint."""
    link, f, inward = assembly.tree.links[k], wrenches[k], loads.inward[k]
    parent, force = wrenches[link.parent], inertia.felt(f, inward)
    parent[X] = parent[X] + force[X]
    parent[Z] = parent[Z] + force[Z]
    if assembly.frames[link.parent].rotates:
        push = moment(assembly.frames[k].reach, force)
        if link.joint.joint_type.frees_rotation:
            push = push - loads.generalized_forces[k][-1]
        else:
            push = push + inertia.felt_moment(f, inward)
        parent[TURN] = parent[TURN] + push


def _outwards(
    assembly: Assembly, factors: Factors, loads: Loads, free: list[list[AnyScalar]]
) -> Accelerations:
    """Accelerations from the ground to the leaves."""
    tree = assembly.tree
    rates: list[AnyScalar] = [0] * len(tree.coordinate_names)
    origins: list[Vector] = []
    alphas: list[AnyScalar] = []
    for k, link in enumerate(tree.links):
        origin, alpha = loads.ground, 0
        if link.parent >= 0:
            origin, alpha = origins[link.parent], alphas[link.parent]
        # what is known before α comes first: this is where everything waits
        origin = swung(subtracted(origin, loads.inward[k]), alpha, assembly.frames[k].reach)
        fixed = (*origin, alpha)
        motion = [*fixed]
        values: list[AnyScalar] = []
        for out, part in zip(factors.eliminations[k], free[k], strict=True):
            values.append(out.value(part, motion))
            out.freedom.set(motion, values[-1])
        for coordinate, out, value in zip(
            link.coordinates, factors.eliminations[k], values, strict=True
        ):
            rates[coordinate] = out.freedom.rate(value, fixed)
        origins.append((motion[X], motion[Z]))
        alphas.append(motion[TURN])
    return Accelerations(rates, origins, alphas, loads.ground[1])
