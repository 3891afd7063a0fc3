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

`factors` come of H alone; `solve` takes them and the loads of a state, or a change of them. Added
mass must not couple bodies.

Gravity is an acceleration of the ground: `a` is the true acceleration plus gravity (upwards). Added
mass does not feel gravity and has that difference in its f.

Derivatives: every link obeys, with its origin's acceleration a, its angular acceleration α and the
force R and moment that its joint exerts on it at the origin,

    H (a, α) − f = joint wrench − Σ over children (R, moment + reach × R)
    (a, α) = (a_parent + α_parent × reach, α_parent) + s̈ twist − inward,
    twist · (R, moment) = effort

with H and f of the link alone. The effect of a change of H, f, reach, twist, inward or effort,
while a, α, s̈ and R stand still, is local to a link and its parent; a, α and s̈ follow from it as
from any loads, with the factors at hand.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.program import AnyScalar, Scalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Elimination,
    Inertia,
    Twist,
    Vector,
    Wrench,
    add_force,
    added,
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

SIZE = 2 * TURN
"""Of a motion or wrench."""
MOST, TWISTS = SIZE, 3
"""Velocities of a joint, and those of them along or about axes that move, at most."""
NUMBERS = SIZE * SIZE + SIZE + TURN + SIZE + MOST + SIZE * TWISTS
"""Of each link in a balance: H, f, reach, inward, generalized forces, twists."""
DRIVES = SIZE + SIZE + MOST
"""Of each link in a drive: a wrench at its origin, an acceleration inward, generalized forces."""


@dataclass(frozen=True)
class _Loads:
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
class _Factors:
    """Articulated inertias as they are handed on, and the eliminations of every link.

    `handed_on` are the components of the motion of each link that are left after them.
    """

    inertias: list[Inertia]
    eliminations: list[list[Elimination]]
    handed_on: list[Sequence[int]]


def factors(assembly: Assembly) -> _Factors:
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
            parts = freedom.elimination(inertia.H, left, symmetric=inertia.symmetric)
            outs.append(Elimination(freedom, *parts))
            left = tuple(outs[-1].column)
        eliminations[k], handed_on[k] = outs[::-1], left
        if link.parent >= 0:
            for out in outs[-1:]:
                inertia.reduce(out)
            rotates = assembly.frames[link.parent].rotates
            inertias[link.parent].add_child(inertia, frame.reach, left, rotates=rotates)
    return _Factors(inertias, eliminations, handed_on)


def own_inertia(assembly: Assembly, k: int) -> Inertia:
    """H of link k alone."""
    frame, (mass, _) = assembly.frames[k], assembly.masses[k]
    own = Inertia.rigid(mass, assembly.seconds[k], frame.arm, assembly.tree.components)
    if (k, k) in assembly.added_mass:
        own.add_at(assembly.added_mass[k, k], frame.arm)
    return own


def own_loads(assembly: Assembly) -> _Loads:
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
    return _Loads(wrenches, inward, assembly.generalized_forces, assembly.gravity)


def solve(assembly: Assembly, factors: _Factors, loads: _Loads) -> Accelerations:
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
    assembly: Assembly, factors: _Factors, loads: _Loads, k: int, wrenches: list[list[AnyScalar]]
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
    assembly: Assembly, factors: _Factors, loads: _Loads, free: list[list[AnyScalar]]
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


class Recursion:
    """The recursion as the `Solution` of a program."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.factors = factors(assembly)
        self.loads = own_loads(assembly)
        self.accelerations = solve(assembly, self.factors, self.loads)

    @property
    def unknowns(self) -> Sequence[Scalar]:
        """Acceleration of every link's origin, and its α and s̈ if its joint gives it one."""
        everything = self._per_link(self.accelerations)
        return [everything[k] for k in self._places]

    @cached_property
    def _places(self) -> list[int]:
        """Places of the unknowns among the numbers of `_per_link`."""
        values = enumerate(self._per_link(self.accelerations))
        return [k for k, value in values if isinstance(value, Scalar)]

    def _per_link(self, solved: Accelerations) -> list[AnyScalar]:
        """(a, α) and rates of twists of each link, 0 for those that it does not have."""
        result: list[AnyScalar] = []
        for k, link in enumerate(self.assembly.tree.links):
            alpha = solved.alphas[k] if link.joint_type.rotates else ZERO
            rates = (solved.rates[speed] for _, speed, _ in self._twists(k))
            result += [*solved.origins[k], *alpha, *rates]
        return result

    def _twists(self, k: int) -> list[tuple[int, int, Twist]]:
        """Number in the joint, index in u, and twist of what moves link `k` along or about an axis
        that may move."""
        pairs = zip(
            self.assembly.tree.links[k].speeds, self.assembly.frames[k].freedoms, strict=True
        )
        return [(n, j, twist) for n, (j, twist) in enumerate(pairs) if isinstance(twist, Twist)]

    def balance(self) -> Sequence[Scalar]:
        """The scalars that the unknowns depend on: `NUMBERS` of each link, the ground's three."""
        balance: list[AnyScalar] = []
        for k, frame in enumerate(self.assembly.frames):
            for row in own_inertia(self.assembly, k).H:
                balance += row
            balance += [*self.loads.wrenches[k], *frame.reach, *frame.inward]
            efforts = self.loads.generalized_forces[k]
            balance += [*efforts, *([0] * (MOST - len(efforts)))]
            for _, _, twist in self._twists(k):
                balance += [*twist.direction, *twist.turning]
            balance += [0] * (NUMBERS * (k + 1) - len(balance))
        balance += self.loads.ground
        zero = self.unknowns[0].tape.constant(0.0)
        return [value if isinstance(value, Scalar) else zero for value in balance]

    @cached_property
    def _own_pulls(self) -> list[list[AnyScalar]]:
        """f − H (a, α) of each link alone."""
        solved, pulls = self.accelerations, []
        for k, f in enumerate(self.loads.wrenches):
            needed = _times(own_inertia(self.assembly, k).H, solved.origins[k], solved.alphas[k])
            pulls.append([*map(minus, f, needed)])
        return pulls

    @cached_property
    def _pulls(self) -> list[Vector]:
        """−R of each link: what hangs on its joint, f − H (a, α) added up to the leaves."""
        links, pulls = self.assembly.tree.links, [force_of(pull) for pull in self._own_pulls]
        for k in range(len(links) - 1, -1, -1):
            if links[k].parent >= 0:
                pulls[links[k].parent] = added(pulls[links[k].parent], pulls[k])
        return pulls

    @cached_property
    def _moments(self) -> list[Vector]:
        """The moments about the origins that go with the pulls."""
        links, moments = self.assembly.tree.links, [moment_of(pull) for pull in self._own_pulls]
        for k in range(len(links) - 1, -1, -1):
            if links[k].parent >= 0:
                lever = cross(self.assembly.frames[k].reach, self._pulls[k])
                handed = added(moments[k], lever)
                moments[links[k].parent] = added(moments[links[k].parent], handed)
        return moments

    def drive(self, change: Mapping[int, Scalar]) -> Mapping[int, Scalar]:
        """The loads that are equivalent to a change: `DRIVES` of each link, and of the ground."""
        size = len(self.assembly.frames)
        drive: dict[int, AnyScalar] = defaultdict(int)
        for k in sorted({place // NUMBERS for place in change}):
            numbers = [change.get(place, 0) for place in range(NUMBERS * k, NUMBERS * (k + 1))]
            if k < size:
                self._add(drive, k, numbers)
            else:
                for axis in range(TURN):
                    drive[DRIVES * size + axis] = numbers[axis]
        return {place: value for place, value in drive.items() if isinstance(value, Scalar)}

    def _add(self, drive: dict[int, AnyScalar], k: int, change: Sequence[AnyScalar]) -> None:
        """Add a change of link `k`."""
        link, solved = self.assembly.tree.links[k], self.accelerations
        parts = iter(change)
        H = [[next(parts) for _ in range(SIZE)] for _ in range(SIZE)]
        f = [next(parts) for _ in range(SIZE)]
        reach, inward = _vector(parts), [next(parts) for _ in range(SIZE)]
        along = [next(parts) for _ in range(MOST)]
        needed = _times(H, solved.origins[k], solved.alphas[k])
        if reach != ZERO and link.parent >= 0:
            for place, part in enumerate(cross(reach, self._pulls[k]), DRIVES * link.parent + TURN):
                drive[place] = plus(drive[place], part)
            swing = cross(solved.alphas[link.parent], reach)
            inward[:TURN] = subtracted(force_of(inward), swing)
        for number, speed, _ in self._twists(k):
            direction, turning = _vector(parts), _vector(parts)
            moved = [times(solved.rates[speed], part) for part in (*direction, *turning)]
            inward = [*map(minus, inward, moved)]
            if direction != ZERO:
                along[number] = plus(along[number], dot(direction, self._pulls[k]))
            if turning != ZERO:
                along[number] = plus(along[number], dot(turning, self._moments[k]))
        wrench = [*map(minus, f, needed)]
        for place, value in enumerate((*wrench, *inward, *along), start=DRIVES * k):
            drive[place] = plus(drive[place], value)

    def response(self, drive: Mapping[int, Scalar]) -> Sequence[Scalar | int]:
        """Change of the unknowns for a drive."""
        size = len(self.assembly.frames)
        numbers = [drive.get(place, 0) for place in range(DRIVES * size + TURN)]
        loads = _Loads([], [], [], ground=_vector(iter(numbers[-TURN:])))
        for k, link in enumerate(self.assembly.tree.links):
            own = iter(numbers[DRIVES * k : DRIVES * (k + 1)])
            loads.wrenches.append([next(own) for _ in range(SIZE)])
            loads.inward.append((*_vector(own), *_vector(own)))
            loads.generalized_forces.append([next(own) for _ in link.speeds])
        everything = self._per_link(solve(self.assembly, self.factors, loads))
        return [everything[k] for k in self._places]


def _vector(parts: Iterator[AnyScalar]) -> Vector:
    """The next three."""
    return next(parts), next(parts), next(parts)


def _times(H: Sequence[Sequence[AnyScalar]], a: Vector, alpha: Vector) -> list[AnyScalar]:
    """H (a, α)."""
    motion = (*a, *alpha)
    return [dot(row, motion) for row in H]
