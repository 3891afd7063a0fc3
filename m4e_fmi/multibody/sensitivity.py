"""Derivatives of the accelerations of the recursion.

Every link obeys, with its origin's acceleration a, its angular acceleration α and the force R and
moment that its joint exerts on it at the origin,

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
from functools import cached_property

from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.multibody.recursion import (
    Factors,
    Loads,
    factors,
    own_inertia,
    own_loads,
    solve,
)
from m4e_fmi.program import AnyScalar, Scalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Twist,
    Vector,
    added,
    cross,
    dot,
    force_of,
    minus,
    moment_of,
    plus,
    subtracted,
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


class Recursion:
    """The recursion as the `Solution` of a program."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.factors: Factors = factors(assembly)
        self.loads: Loads = own_loads(assembly)
        self.accelerations: Accelerations = solve(assembly, self.factors, self.loads)

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
            balance += _filled(self.loads.generalized_forces[k])
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
        loads = Loads([], [], [], ground=_vector(iter(numbers[-TURN:])))
        for k, link in enumerate(self.assembly.tree.links):
            own = iter(numbers[DRIVES * k : DRIVES * (k + 1)])
            loads.wrenches.append([next(own) for _ in range(SIZE)])
            loads.inward.append((*_vector(own), *_vector(own)))
            loads.generalized_forces.append([next(own) for _ in link.speeds])
        everything = self._per_link(solve(self.assembly, self.factors, loads))
        return [everything[k] for k in self._places]


def _filled(forces: list[AnyScalar]) -> list[AnyScalar]:
    """Generalized forces of a joint, with zeros for the coordinates that it does not have."""
    return forces + [0] * (MOST - len(forces))


def _vector(parts: Iterator[AnyScalar]) -> Vector:
    """The next three."""
    return next(parts), next(parts), next(parts)


def _times(H: Sequence[Sequence[AnyScalar]], a: Vector, alpha: Vector) -> list[AnyScalar]:
    """H (a, α)."""
    motion = (*a, *alpha)
    return [dot(row, motion) for row in H]
