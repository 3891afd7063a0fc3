"""Derivatives of the accelerations of the recursion.

Every link obeys, with its origin's acceleration a, its angular acceleration α and the force R and
moment that its joint exerts on it at the origin,

    H (a, α) − f = joint wrench − Σ over children (R, moment + moment of R at `reach`)
    a = a_parent + α_parent tilde(reach) + s̈ direction − inward,    direction · R = effort

with H and f of the link alone. The effect of a change of H, f, reach, direction, inward or effort,
while a, α, s̈ and R stand still, is local to a link and its parent; a, α and s̈ follow from it as
from any loads, with the factors at hand.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
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
    DOFS,
    TURN,
    ZERO,
    Vector,
    X,
    Z,
    added,
    dot,
    moment,
    scaled,
    subtracted,
    swung,
)

NUMBERS = 25
"""Of each link in a balance: H, f, reach, up to three directions, inward, generalized forces."""

DRIVES = 8
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
        """(a_x, a_z, α) and rates of twists of each link, 0 for those that it does not have."""
        result: list[AnyScalar] = []
        for k, link in enumerate(self.assembly.tree.links):
            alpha = solved.alphas[k] if link.joint.joint_type.rotates else 0
            rates = (solved.rates[coordinate] for coordinate, _ in self._directed(k))
            result += [*solved.origins[k], alpha, *rates]
        return result

    def _directed(self, k: int) -> list[tuple[int, Vector]]:
        """The coordinates of link `k` that move it along a direction, and this."""
        link, frame = self.assembly.tree.links[k], self.assembly.frames[k]
        pairs = zip(link.coordinates, frame.freedoms, strict=True)
        return [(k, freedom.direction) for k, freedom in pairs if freedom.direction is not ZERO]

    def balance(self) -> Sequence[Scalar]:
        """The scalars that the unknowns depend on: `NUMBERS` of each link, the ground's two."""
        balance: list[AnyScalar] = []
        for k, frame in enumerate(self.assembly.frames):
            for row in own_inertia(self.assembly, k).H:
                balance += row
            balance += [*self.loads.wrenches[k], *frame.reach, *frame.inward]
            balance += _filled(self.loads.generalized_forces[k])
            for freedom in frame.freedoms:
                balance += freedom.direction
            balance += [0] * (NUMBERS * (k + 1) - len(balance))
        balance += self.loads.ground
        zero = self.unknowns[0].tape.constant(0.0)
        return [value if isinstance(value, Scalar) else zero for value in balance]

    @cached_property
    def _pulls(self) -> list[Vector]:
        """−R of each link: what hangs on its joint, f − H (a, α) added up to the leaves."""
        links, solved = self.assembly.tree.links, self.accelerations
        pulls: list[Vector] = []
        for k, f in enumerate(self.loads.wrenches):
            needed = _times(own_inertia(self.assembly, k).H, solved.origins[k], solved.alphas[k])
            pulls.append((f[X] - needed[X], f[Z] - needed[Z]))
        for k in range(len(links) - 1, -1, -1):
            if links[k].parent >= 0:
                pulls[links[k].parent] = added(pulls[links[k].parent], pulls[k])
        return pulls

    def drive(self, change: Mapping[int, Scalar]) -> Mapping[int, Scalar]:
        """The loads that are equivalent to a change: `DRIVES` of each link, and of the ground."""
        size = len(self.assembly.frames)
        drive: dict[int, AnyScalar] = defaultdict(int)
        for k in sorted({place // NUMBERS for place in change}):
            numbers = [change.get(place, 0) for place in range(NUMBERS * k, NUMBERS * (k + 1))]
            if k < size:
                self._add(drive, k, numbers)
            else:
                drive[DRIVES * size], drive[DRIVES * size + 1] = numbers[:2]
        return {place: value for place, value in drive.items() if isinstance(value, Scalar)}

    def _add(self, drive: dict[int, AnyScalar], k: int, change: Sequence[AnyScalar]) -> None:
        """Add a change of link `k`."""
        link, solved = self.assembly.tree.links[k], self.accelerations
        H, f = [change[0:3], change[3:6], change[6:9]], change[9:12]
        reach, inward = (change[12], change[13]), (change[14], change[15])
        along, directions = list(change[16:19]), change[19:]
        needed = _times(H, solved.origins[k], solved.alphas[k])
        if reach != ZERO and link.parent >= 0:
            drive[DRIVES * link.parent + TURN] += moment(reach, self._pulls[k])
            inward = swung(inward, -solved.alphas[link.parent], reach)
        for index, coordinate in enumerate(link.coordinates):
            direction = (directions[2 * index], directions[2 * index + 1])
            if direction != ZERO:
                inward = subtracted(inward, scaled(solved.rates[coordinate], direction))
                along[index] = along[index] + dot(direction, self._pulls[k])
        wrench = [a - b for a, b in zip(f, needed, strict=True)]
        for place, value in enumerate((*wrench, *inward, *along), start=DRIVES * k):
            drive[place] += value

    def response(self, drive: Mapping[int, Scalar]) -> Sequence[Scalar | int]:
        """Change of the unknowns for a drive."""
        size = len(self.assembly.frames)
        numbers = [drive.get(place, 0) for place in range(DRIVES * size + 2)]
        loads = Loads([], [], [], ground=(numbers[-2], numbers[-1]))
        for k, link in enumerate(self.assembly.tree.links):
            x, z, turn, *inward = numbers[DRIVES * k : DRIVES * k + 5]
            along = numbers[DRIVES * k + 5 : DRIVES * (k + 1)]
            loads.wrenches.append([x, z, turn])
            loads.inward.append((inward[X], inward[Z]))
            loads.generalized_forces.append(along[: len(link.coordinates)])
        everything = self._per_link(solve(self.assembly, self.factors, loads))
        return [everything[k] for k in self._places]


def _filled(forces: list[AnyScalar]) -> list[AnyScalar]:
    """Generalized forces of a joint, with zeros for the coordinates that it does not have."""
    return forces + [0] * (DOFS - len(forces))


def _times(H: Sequence[Sequence[AnyScalar]], a: Vector, alpha: AnyScalar) -> list[AnyScalar]:
    """H (a, α); entries that are the integer 0 cost nothing."""
    motion = (*a, alpha)
    return [
        sum(entry * m for entry, m in zip(row, motion, strict=True) if not isinstance(entry, int))
        for row in H
    ]
