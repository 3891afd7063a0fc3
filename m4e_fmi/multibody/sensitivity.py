"""How the accelerations of the recursion change with what they depend on.

Every link obeys, with its origin's acceleration a, its angular acceleration α and the force R and
moment that its joint exerts on it at the origin,

    H (a, α) − f = joint wrench − Σ over children (R, moment + moment of R at `reach`)
    a = a_parent + α_parent tilde(reach) + s̈ direction − inward,    direction · R = effort

with H and f of the link alone. What changes of H, f, reach, direction, inward and effort do while
a, α, s̈ and R stand still is local to a link and its parent; a, α and s̈ follow from it as from any
loads, with the factors at hand.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.multibody.kinematics import ZERO
from m4e_fmi.multibody.recursion import (
    TURN,
    Factors,
    Loads,
    X,
    Z,
    factors,
    own_inertia,
    own_loads,
    solve,
)
from m4e_fmi.multibody.space import Pair, added, dot, moment, scaled, subtracted, swung
from m4e_fmi.program import Scalar

NUMBERS = 19
"""Of each link in a balance: H, f, reach, direction, inward, effort."""

DRIVES = 6
"""Of each link in a drive: a wrench at its origin, an acceleration inward, an effort."""


class Recursion:
    """The recursion as the `Solution` of a program."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.factors: Factors = factors(assembly)
        self.loads: Loads = own_loads(assembly)
        self.accelerations: Accelerations = solve(assembly, self.factors, self.loads)

    @property
    def unknowns(self) -> Sequence[Scalar]:
        """Acceleration of every link's origin, and its α or s̈ if its joint gives it one."""
        everything = self._per_link(self.accelerations)
        return [everything[k] for k in self._places]

    @cached_property
    def _places(self) -> list[int]:
        """Where the unknowns are among the four numbers of each link."""
        values = enumerate(self._per_link(self.accelerations))
        return [k for k, value in values if isinstance(value, Scalar)]

    def _per_link(self, solved: Accelerations) -> list[Any]:
        """(a_x, a_z, α, s̈) of each link one after the other, 0 for what it does not have."""
        result: list[Any] = []
        for k, link in enumerate(self.assembly.tree.links):
            slides = link.joint.type == "prismatic"
            s = solved.rates[link.coordinates[0]] if slides else 0
            result += [*solved.origins[k], 0 if link.rigid else solved.alphas[k], s]
        return result

    def balance(self) -> Sequence[Scalar]:
        """What the unknowns depend on: `NUMBERS` of each link, and the ground's acceleration."""
        balance: list[Any] = []
        for k, frame in enumerate(self.assembly.frames):
            for row in own_inertia(self.assembly, k).H:
                balance += row
            balance += self.loads.wrenches[k]
            balance += [*frame.reach, *frame.direction, *frame.inward, self.assembly.efforts[k]]
        balance += self.loads.ground
        zero = self.unknowns[0].tape.constant(0.0)
        return [value if isinstance(value, Scalar) else zero for value in balance]

    @cached_property
    def _pulls(self) -> list[Pair]:
        """−R of each link: what hangs on its joint, f − H (a, α) added up to the leaves."""
        links, solved = self.assembly.tree.links, self.accelerations
        pulls: list[Pair] = []
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
        drive: dict[int, Any] = defaultdict(int)
        for k in sorted({place // NUMBERS for place in change}):
            numbers = [change.get(place, 0) for place in range(NUMBERS * k, NUMBERS * (k + 1))]
            if k < size:
                self._add(drive, k, numbers)
            else:
                drive[DRIVES * size], drive[DRIVES * size + 1] = numbers[:2]
        return {place: value for place, value in drive.items() if isinstance(value, Scalar)}

    def _add(self, drive: dict[int, Any], k: int, change: Sequence[Any]) -> None:
        """Add a change of link `k`."""
        link, solved = self.assembly.tree.links[k], self.accelerations
        H, f = [change[0:3], change[3:6], change[6:9]], change[9:12]
        reach, direction = (change[12], change[13]), (change[14], change[15])
        inward, effort = (change[16], change[17]), change[18]
        needed = _times(H, solved.origins[k], solved.alphas[k])
        if reach != ZERO and link.parent >= 0:
            drive[DRIVES * link.parent + TURN] += moment(reach, self._pulls[k])
            inward = swung(inward, -solved.alphas[link.parent], reach)
        if direction != ZERO:
            inward = subtracted(inward, scaled(solved.rates[link.coordinates[0]], direction))
            effort = effort + dot(direction, self._pulls[k])
        wrench = [a - b for a, b in zip(f, needed, strict=True)]
        for place, value in enumerate((*wrench, *inward, effort), start=DRIVES * k):
            drive[place] += value

    def response(self, drive: Mapping[int, Scalar]) -> Sequence[Scalar | int]:
        """Change of the unknowns for a drive."""
        size = len(self.assembly.frames)
        numbers = [drive.get(place, 0) for place in range(DRIVES * size + 2)]
        loads = Loads([], [], [], ground=(numbers[-2], numbers[-1]))
        for k in range(size):
            *wrench, x, z, effort = numbers[DRIVES * k : DRIVES * (k + 1)]
            loads.wrenches.append(wrench)
            loads.inward.append((x, z))
            loads.efforts.append(effort)
        everything = self._per_link(solve(self.assembly, self.factors, loads))
        return [everything[k] for k in self._places]


def _times(H: Sequence[Sequence[Any]], a: Pair, alpha: Any) -> list[Any]:
    """H (a, α); entries that are the integer 0 cost nothing."""
    motion = (*a, alpha)
    return [
        sum(entry * m for entry, m in zip(row, motion, strict=True) if not isinstance(entry, int))
        for row in H
    ]
