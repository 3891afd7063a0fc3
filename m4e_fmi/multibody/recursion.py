"""Joint accelerations by the articulated-body algorithm: a cost that grows with the bodies.

Featherstone, "Rigid Body Dynamics Algorithms", chapter 7, in world axes and, where hinges are
parallel, absolute angles. What hangs on a link is felt at its origin as H (a, α) − f, the wrench
that gives the origin the acceleration a and the link the angular acceleration α. From the leaves
inwards each joint's own acceleration is eliminated from it and the rest handed to the parent; from
the ground outwards the accelerations follow. A hinge hands on no moment about its axis: the
acceleration of an absolute angle is the body's own, so a chain of hinges in the plane hands on 2×2
matrices. A relative angle changes nothing but its own acceleration, which is the difference of two
absolute ones.

Motions have six components; only those that bodies can have are computed, which are three in the
plane.

`factors` come of H alone; `solve` takes them and the loads of a state, or a change of them: see
`sensitivity`. Added mass must not couple bodies.

Gravity is an acceleration of the ground: `a` is the true acceleration plus gravity (upwards). Added
mass does not feel gravity and has that difference in its f.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Elimination,
    Inertia,
    Vector,
    Wrench,
    add_force,
    applied,
    cross,
    dot,
    force_of,
    minus,
    moment_of,
    outward,
    plus,
    scaled,
    subtracted,
    swung,
    times,
)


@dataclass(frozen=True)
class Loads:
    """The loads that drive a tree, for each link.

    `wrenches` f = (F [N], M [N·m]) about the origins, `inward` the links' accelerations
    (a, α) against their parents that velocities alone cause (see `joints/frame.py`),
    `generalized_forces` along the coordinates of each joint [N, N·m]; and the acceleration of the
    `ground` [m/s²].
    """

    wrenches: list[list[AnyScalar]]
    inward: list[Wrench]
    generalized_forces: list[list[AnyScalar]]
    ground: Vector


@dataclass(frozen=True)
class Factors:
    """Articulated inertias as they are handed on, and the eliminations of every link.

    `handed_on` are the components of the motion of each link that are left after them.
    """

    inertias: list[Inertia]
    eliminations: list[list[Elimination]]
    handed_on: list[Sequence[int]]


def factors(assembly: Assembly) -> Factors:
    """Eliminate every joint's acceleration, from the leaves to the ground."""
    links = assembly.tree.links
    inertias = [own_inertia(assembly, k) for k in range(len(links))]
    for k, _ in assembly.added_mass:  # taken as it is given: what it makes unsymmetric …
        while k >= 0:
            inertias[k].symmetric = False
            k = links[k].parent  # … is so up to the ground
    eliminations: list[list[Elimination]] = [[] for _ in links]
    handed_on: list[Sequence[int]] = [() for _ in links]
    for k in range(len(links) - 1, -1, -1):
        inertia, link, frame = inertias[k], links[k], assembly.frames[k]
        left: Sequence[int] = [c for c in assembly.tree.components if frame.rotates or c < TURN]
        outs: list[Elimination] = []
        for freedom in frame.freedoms[::-1]:
            for out in outs[-1:]:
                inertia.reduce(out)
            outs.append(inertia.eliminate(freedom, left))
            left = tuple(outs[-1].column)
        eliminations[k], handed_on[k] = outs[::-1], left
        if link.parent >= 0:
            for out in outs[-1:]:
                inertia.reduce(out)
            rotates = assembly.frames[link.parent].rotates
            inertias[link.parent].add_child(inertia, frame.reach, left, rotates=rotates)
    return Factors(inertias, eliminations, handed_on)


def own_inertia(assembly: Assembly, k: int) -> Inertia:
    """H of link k alone."""
    frame, (mass, _) = assembly.frames[k], assembly.masses[k]
    own = Inertia.rigid(mass, assembly.seconds[k], frame.arm, assembly.tree.components)
    if (k, k) in assembly.added_mass:
        own.add_at(assembly.added_mass[k, k], frame.arm)
    return own


def own_loads(assembly: Assembly) -> Loads:
    """The loads of the tree in its state: f of each link alone."""
    wrenches: list[list[AnyScalar]] = []
    for k, frame in enumerate(assembly.frames):
        f = [*assembly.wrenches[k]]
        thrown = outward(frame.omega, scaled(assembly.masses[k][0], frame.arm))
        spun = cross(applied(assembly.seconds[k], frame.omega), frame.omega)
        add_force(f, thrown, ZERO, spun)
        if (k, k) in assembly.added_mass:  # it feels the true acceleration of the CG
            sunk = subtracted(ZERO, assembly.gravity)
            motion = (*frame.acceleration_at(frame.arm, sunk, ZERO), *ZERO)
            bias = [-dot(row, motion) for row in assembly.added_mass[k, k]]
            add_force(f, force_of(bias), frame.arm, moment_of(bias))
        wrenches.append(f)
    inward = [frame.inward for frame in assembly.frames]
    return Loads(wrenches, inward, assembly.generalized_forces, assembly.gravity)


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
            free[k][index] = plus(along[index], out.freedom.along(f)) / out.pivot
            for a, entry in out.column.items():
                f[a] = minus(f[a], times(entry, free[k][index]))
        if assembly.tree.links[k].parent >= 0:
            _push_on(assembly, factors, loads, k, wrenches)
    return _outwards(assembly, factors, loads, free)


def _push_on(
    assembly: Assembly, factors: Factors, loads: Loads, k: int, wrenches: list[list[AnyScalar]]
) -> None:
    """Add to the parent's f what it feels of that of link `k` through its joint."""
    frame, left, link = assembly.frames[k], factors.handed_on[k], assembly.tree.links[k]
    felt = factors.inertias[k].felt(wrenches[k], loads.inward[k], left)
    for out, effort in zip(factors.eliminations[k], loads.generalized_forces[k], strict=True):
        for c, part in enumerate(out.freedom.turning, start=TURN):
            if c not in left:  # an angle of its own: the parent feels its effort alone
                felt[c] = minus(felt[c], times(effort, part))
    if assembly.frames[link.parent].rotates:
        add_force(wrenches[link.parent], force_of(felt), frame.reach, moment_of(felt))
    else:
        add_force(wrenches[link.parent], force_of(felt), ZERO)


def _outwards(
    assembly: Assembly, factors: Factors, loads: Loads, free: list[list[AnyScalar]]
) -> Accelerations:
    """Accelerations from the ground to the leaves."""
    tree = assembly.tree
    rates: list[AnyScalar] = [0] * len(tree.velocity_names)
    motions: list[list[AnyScalar]] = []
    for k, link in enumerate(tree.links):
        motion: list[AnyScalar] = [*loads.ground, *ZERO]
        if link.parent >= 0:
            motion = [*motions[link.parent]]
        # what is known before α comes first: this is where everything waits
        inward = loads.inward[k]
        origin = subtracted(force_of(motion), force_of(inward))
        motion[:TURN] = swung(origin, moment_of(motion), assembly.frames[k].reach)
        motion[TURN:] = subtracted(moment_of(motion), moment_of(inward))
        fixed, values = [*motion], list[AnyScalar]()
        for out, part in zip(factors.eliminations[k], free[k], strict=True):
            values.append(out.value(part, motion))
            out.freedom.set(motion, values[-1])
        for coordinate, out, value in zip(
            link.speeds, factors.eliminations[k], values, strict=True
        ):
            rates[coordinate] = out.freedom.rate(value, fixed)
        motions.append(motion)
    origins, alphas = ([part(m) for m in motions] for part in (force_of, moment_of))
    return Accelerations(rates, origins, alphas, loads.ground)
