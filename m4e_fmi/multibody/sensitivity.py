"""Derivatives of the accelerations of the recursion.

Every link obeys, with its origin's acceleration a, its angular acceleration α and the force R and
moment that its joint exerts on it at the origin,

    H (a, α) − f = joint wrench − Σ over children (R, moment + reach × R)
    a = a_parent + α_parent × reach + s̈ direction − inward,    direction · R = effort

with H and f of the link alone. The effect of a change of H, f, reach, direction, inward or effort,
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
    PLANE,
    TURN,
    ZERO,
    Vector,
    added,
    cross,
    dot,
    force_of,
    minus,
    plus,
    scaled,
    subtracted,
)

SIZE = 2 * TURN
"""Of a motion or wrench."""
MOST = len(PLANE)
"""Coordinates of a joint, at most."""
NUMBERS = SIZE * SIZE + SIZE + TURN + TURN + MOST + TURN * MOST
"""Of each link in a balance: H, f, reach, inward, generalized forces, directions."""
DRIVES = SIZE + TURN + MOST
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
            alpha = solved.alphas[k] if link.joint.joint_type.rotates else ZERO
            rates = (solved.rates[coordinate] for coordinate, _ in self._directed(k))
            result += [*solved.origins[k], *alpha, *rates]
        return result

    def _directed(self, k: int) -> list[tuple[int, Vector]]:
        """The coordinates of link `k` that move it along a direction, and this."""
        link, frame = self.assembly.tree.links[k], self.assembly.frames[k]
        pairs = zip(link.coordinates, frame.freedoms, strict=True)
        return [(k, freedom.direction) for k, freedom in pairs if freedom.direction is not ZERO]

    def balance(self) -> Sequence[Scalar]:
        """The scalars that the unknowns depend on: `NUMBERS` of each link, the ground's three."""
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
            pulls.append(subtracted(force_of(f), force_of(needed)))
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
                for axis in range(TURN):
                    drive[DRIVES * size + axis] = numbers[axis]
        return {place: value for place, value in drive.items() if isinstance(value, Scalar)}

    def _add(self, drive: dict[int, AnyScalar], k: int, change: Sequence[AnyScalar]) -> None:
        """Add a change of link `k`."""
        link, solved = self.assembly.tree.links[k], self.accelerations
        parts = iter(change)
        H = [[next(parts) for _ in range(SIZE)] for _ in range(SIZE)]
        f = [next(parts) for _ in range(SIZE)]
        reach, inward = _vector(parts), _vector(parts)
        along = [next(parts) for _ in range(MOST)]
        needed = _times(H, solved.origins[k], solved.alphas[k])
        if reach != ZERO and link.parent >= 0:
            for place, part in enumerate(cross(reach, self._pulls[k]), DRIVES * link.parent + TURN):
                drive[place] = plus(drive[place], part)
            inward = subtracted(inward, cross(solved.alphas[link.parent], reach))
        for index, coordinate in enumerate(link.coordinates):
            direction = _vector(parts)
            if direction != ZERO:
                inward = subtracted(inward, scaled(solved.rates[coordinate], direction))
                along[index] = plus(along[index], dot(direction, self._pulls[k]))
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
            loads.inward.append(_vector(own))
            loads.generalized_forces.append([next(own) for _ in link.coordinates])
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
