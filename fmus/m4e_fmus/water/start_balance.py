"""Unbalanced forces at the start on floating bodies that joints connect, within one component.

The accelerations a of the bodies (three motions each in a planar model, six in space) follow from
the forces by the mobility Y = ∂a/∂F_water: a = Y (F_water + F). F is the load: weight, the model's
own loads and all other connected forces. The range of Y holds the motions that the joints allow;
bodies whose blocks in the projector on it are coupled are joined by joints. Joint reactions do no
work in an allowed motion δ, so c = Y⁺ δ gives the generalised load δ·F = c·a − δ·F_water.

The motions δ that are looked at are heave, and the turns in a vertical plane: that of a planar
model, or in space the planes ahead and across, by the heading. In them all joined bodies move as
one, those outside of the water as well: so their weights count at their heights. Where a joint
forbids that, as one to the ground may, the hulls move, and the others as they must.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.wiring.added_mass import added_mass_bodies, in_order
from m4e_fmi.cosim.wiring.added_mass import group as connector
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmus.water.hulls import FORCES, WRENCH, AtStart, FloatingHull, Plane

ACCELERATIONS: dict[str, str] = dict(
    zip(FORCES, ("ax", "ay", "az", "alpha_x", "alpha", "alpha_z"), strict=True)
)
"""Of a body's centre of gravity, by the components of the force that are along them."""
MATRIX = "added_mass["
RANK = 1e-9
"""Eigenvalue of the mobility, over the largest, below which joints forbid a motion."""
COUPLED = 1e-6
"""Share of a motion that counts as rounding."""


@dataclass(frozen=True)
class BodyBalance:
    """A free body, or bodies that joints join, at the start.

    `force` and `moment` are out of balance [N, N.m]: load and buoyancy in the reference pose, in
    heave and in the turn of all bodies as one, the moment about their middle and in the water's
    sense. They are None where joints forbid that motion. `carried` are the bodies outside of the
    water that move with the hulls. `top_weight` is the sum of all masses times their heights over
    the middle of the hulls [kg.m]; None if unknown.
    `is_shared` if other components, as members, add to the forces of the water on them.
    """

    hulls: tuple[FloatingHull, ...]
    force: float | None = None
    moment: float | None = None
    carried: tuple[str, ...] = ()
    top_weight: float | None = None
    is_shared: bool = False

    @property
    def is_single(self) -> bool:
        """True of one body in water."""
        return len(self.hulls) == 1

    @property
    def buoyancy(self) -> float:
        """Vertical force of the still water in the reference pose [N]."""
        return float(sum(hull.buoyancy[1] for hull in self.hulls))

    @property
    def neutral_mass(self) -> float:
        return sum(hull.neutral_mass for hull in self.hulls)

    @property
    def heave_stiffness(self) -> float:
        """[N/m]."""
        return float(sum(hull.stiffness[1, 1] for hull in self.hulls))

    @property
    def pitch_stiffness(self) -> float:
        """Of one body or of all turning as one, with their weights [N.m/rad]; heave is free."""
        turn = _rotation(self.hulls).reshape(-1, 3)
        heave = np.array([0.0, 1.0, 0.0])
        pairs = list(zip(self.hulls, turn, strict=True))
        pitch = sum(float(v @ hull.stiffness @ v) for hull, v in pairs)
        pitch -= (self.top_weight or 0.0) * self.buoyancy / self.neutral_mass
        coupling = sum(float(heave @ hull.stiffness @ v) for hull, v in pairs)
        free = self.heave_stiffness
        return pitch - coupling**2 / free if free > 0 else pitch


def balances(
    network: AtStart, wiring: Wiring, hulls: Sequence[FloatingHull]
) -> Iterator[BodyBalance]:
    """For each free body and each group of joined ones, of the components that tell it."""
    sources = {(k.target, k.source.component): k for k in wiring.all_links}
    held: dict[str, list[FloatingHull]] = {}
    for hull in hulls:
        if hull.planes() and _is_told(network, sources, hull):
            held.setdefault(hull.link.source.component, []).append(hull)
    for holder, of_it in held.items():
        wet = {hull.base for hull in hulls if hull.link.source.component == holder}
        yield from _Mobility(network, wiring, holder, of_it, wet).balances()


def _is_told(network: AtStart, sources: dict[tuple[Port, str], Link], hull: FloatingHull) -> bool:
    """True if the holder has exact derivatives, and the water's force comes straight to it.

    `sources` are links by target and component that gives it; others may add forces to it.
    """
    component = hull.link.source.component
    described = network.instances[component].description
    symbols = hull.symbols
    names = [f"{hull.base}.{name}" for s in symbols for name in (s, ACCELERATIONS[s])]
    if not described.directional_derivatives or any(n not in described.variables for n in names):
        return False
    given = {s: sources.get((Port(component, f"{hull.base}.{s}"), hull.component)) for s in symbols}
    return all(
        link is None or (link.is_plain and link.source == Port(hull.component, f"{hull.body}.{s}"))
        for s, link in given.items()
    ) and isinstance(given["force_z"], Link)


@dataclass(frozen=True)
class _Body:
    """A body of the component: its group of variables, and the forces that it takes."""

    base: str
    symbols: tuple[str, ...]

    def motion(self, part: np.ndarray, plane: Plane) -> np.ndarray:
        """A motion (3,) in a plane as one along its forces, (3,) or (6,) [m, rad]."""
        return part if self.symbols == WRENCH else plane.in_world(part)


class _Mobility:
    """How forces on the bodies of one component accelerate them.

    The bodies are the `hulls`, and those that forces on them accelerate. All is made dimensionless
    by `unit`, (m,) of all motions: with it mobilities of bodies and motions compare. `wet` are all
    bodies in water, those without a hull here included.
    """

    def __init__(
        self,
        network: AtStart,
        wiring: Wiring,
        component: str,
        hulls: Sequence[FloatingHull],
        wet: Collection[str],
    ) -> None:
        self.network, self.wiring, self.component = network, wiring, component
        self.hulls, self.wet = hulls, wet
        in_water = [_Body(hull.base, hull.symbols) for hull in hulls]
        self.bodies = [*in_water, *self._others(in_water)]
        parts = [(k, body, s) for k, body in enumerate(self.bodies) for s in body.symbols]
        self.inputs = [f"{body.base}.{symbol}" for _, body, symbol in parts]
        self.outputs = [f"{body.base}.{ACCELERATIONS[symbol]}" for _, body, symbol in parts]
        self.owners = np.array([k for k, _, _ in parts])
        self.of_water = {
            Port(hull.component, f"{hull.body}.{symbol}") for hull in hulls for symbol in FORCES
        }
        self.added = [
            link
            for links in wiring.into.values()
            for link in links
            if len(links) > 1
            and link.target.component == component
            and link.source not in self.of_water
        ]
        mobility = np.array([self._derivatives(name) for name in self.inputs]).T
        self.unit = np.array(
            [
                _unit(hulls[k], symbol) if k < len(hulls) else self._own_unit(symbol, own)
                for (k, _, symbol), own in zip(parts, mobility.diagonal(), strict=True)
            ]
        )
        scaled = mobility * np.outer(self.unit, self.unit)
        values, vectors = np.linalg.eigh((scaled + scaled.T) / 2.0)
        kept = values > RANK * values.max(initial=0.0)
        self.projector = vectors[:, kept] @ vectors[:, kept].T
        self.inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T

    def _others(self, in_water: Sequence[_Body]) -> Iterator[_Body]:
        """Bodies beside those in water whose accelerations depend on forces on these."""
        described = self.network.instances[self.component].description
        known, wet = described.variables, {body.base for body in in_water}
        forces = {f"{body.base}.{symbol}" for body in in_water for symbol in body.symbols}
        for base in (n.removesuffix(".moment_y") for n in known if n.endswith(".moment_y")):
            symbols = FORCES if f"{base}.force_y" in known else WRENCH
            needed = ["x", "z", *symbols, *(ACCELERATIONS[s] for s in symbols)]
            if base in wet or any(f"{base}.{name}" not in known for name in needed):
                continue
            given = (described.dependencies.get(f"{base}.{ACCELERATIONS[s]}", ()) for s in symbols)
            if any(not forces.isdisjoint(names) for names in given):
                yield _Body(base, symbols)

    def _own_unit(self, symbol: str, mobility: float) -> float:
        """That of a motion of a body outside of the water, which may be small or cannot move."""
        largest = max(_unit(hull, symbol) for hull in self.hulls)
        return 1.0 / math.sqrt(mobility) if mobility * largest**2 > RANK else largest

    def _derivatives(self, name: str) -> np.ndarray:
        """Of the accelerations by one input, (m,)."""
        slope = self.network.instances[self.component].directional_derivative
        return np.array([slope(out, name) for out in self.outputs])

    def _read(self, names: Sequence[str]) -> np.ndarray:
        return np.array([float(self.network.read(f"{self.component}.{name}")) for name in names])

    def groups(self) -> list[list[int]]:
        """Indices of the bodies that joints join, where any of them is a hull."""
        left, found = set(range(len(self.bodies))), []
        joined = np.abs(self.projector) > COUPLED
        pairs = set(zip(*(self.owners[k] for k in np.nonzero(joined)), strict=True))
        while left:
            group = {min(left)}
            while (more := {j for i in group for j in left if (i, j) in pairs} - group) != set():
                group |= more
            left -= group
            found.append(sorted(group))
        return [group for group in found if group[0] < len(self.hulls)]

    def balances(self) -> Iterator[BodyBalance]:
        for group in self.groups():
            hulls = [self.hulls[k] for k in group if k < len(self.hulls)]
            planes = [hull.planes() for hull in hulls]
            for number in range(min(map(len, planes))):
                alike = [replace(h, plane=p[number]) for h, p in zip(hulls, planes, strict=True)]
                found = self._balance(group, tuple(alike))
                # the weight is told once, by the first plane
                yield found if number == 0 else replace(found, force=None)

    def _balance(self, group: Sequence[int], hulls: tuple[FloatingHull, ...]) -> BodyBalance:
        """That of one group, in the plane of `hulls`."""
        wrench, acceleration = self._of_water(), self._read(self.outputs)
        wrench[self.owners >= len(self.hulls)] = 0.0  # no water
        heave, turn = np.tile([0.0, 1.0, 0.0], len(hulls)), _rotation(hulls)
        buoyancy = np.concatenate([hull.buoyancy for hull in hulls])
        found = BodyBalance(
            hulls,
            carried=tuple(self.bodies[k].base for k in group[len(hulls) :]),
            is_shared=bool(self.added),
        )
        alike = len({hull.plane.ahead for hull in hulls}) == 1 and not self.added
        if alike and (allowed := self._allowed(group, hulls, np.array([0.0, 0.0, 1.0]))):
            motion, c, _ = allowed
            moment = c @ acceleration - motion @ wrench + turn @ buoyancy
            found = replace(
                found,
                moment=hulls[0].plane.sign * float(moment),
                top_weight=self._top_weight(group, hulls),
            )
        if allowed := self._allowed(group, hulls, np.array([0.0, 1.0, 0.0])):
            motion, c, whole = allowed
            load = motion @ wrench - c @ acceleration
            found = replace(
                found,
                force=float(heave @ buoyancy - load),
                carried=found.carried if whole else (),
            )
        return found

    def _allowed(
        self, group: Sequence[int], hulls: Sequence[FloatingHull], motion: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, bool] | None:
        """A motion (3,) of the group as one, as a motion (m,) [m, rad]; its weights c (m,).

        Of the hulls only, beside which the others move as they must, where joints forbid that of
        all: then the last is False. None where they forbid that, too.
        """
        for members in dict.fromkeys((tuple(group), tuple(group[: len(hulls)]))):
            whole = self._spread(members, hulls, motion)
            if (c := self._weights(whole)) is not None:
                return whole, c, len(members) == len(group)
        return None

    def _spread(
        self, members: Sequence[int], hulls: Sequence[FloatingHull], motion: np.ndarray
    ) -> np.ndarray:
        """A motion (3,) of bodies as one, in the plane of `hulls` about their middle, as (m,)."""
        along, up = _middle(hulls)
        found = np.zeros(len(self.inputs))
        for k in members:
            body = self.bodies[k]
            plane = hulls[members.index(k)].plane if k < len(self.hulls) else hulls[0].plane
            place = _place(self.network, f"{self.component}.{body.base}", plane)
            arm = np.array([place[1] - up, along - place[0], 0.0])
            found[self.owners == k] = body.motion(motion + arm * motion[2], plane)
        return found

    def _of_water(self) -> np.ndarray:
        """Forces (m,) of the hulls' water on their bodies, without what sums add to them."""
        found = self._read(self.inputs)
        for link in self.added:
            if link.target.variable in self.inputs:
                value = link.factor * float(self.network.read(str(link.source))) + link.offset
                found[self.inputs.index(link.target.variable)] -= value
        return found

    def _weights(self, motion: np.ndarray) -> np.ndarray | None:
        """c with c·a = `motion`·(all forces); None of a motion that joints forbid."""
        scaled = self.unit * motion
        if np.abs(self.projector @ scaled - scaled).max() > COUPLED * np.abs(scaled).max():
            return None
        return self.unit * (self.inverse @ scaled)

    def _top_weight(self, group: Sequence[int], hulls: Sequence[FloatingHull]) -> float | None:
        """Sum of mass times height over the middle of the hulls [kg.m], of all bodies.

        It is what couples the motions ahead and turning, without the added mass. 0 of one body,
        None where joints forbid one of them, or where water carries one of the others.
        """
        if len(group) == 1:
            return 0.0
        if any(self.bodies[k].base in self.wet for k in group[len(hulls) :]):
            return None
        ahead, turn = (self._allowed(group, hulls, np.eye(3)[k]) for k in (0, 2))
        if ahead is None or turn is None or not (ahead[2] and turn[2]):
            return None
        added = self._added_mass(hulls, np.tile([1.0, 0.0, 0.0], len(hulls)), _rotation(hulls))
        return float(turn[1] @ ahead[0]) - added

    def _added_mass(
        self, hulls: Sequence[FloatingHull], motion: np.ndarray, other: np.ndarray
    ) -> float:
        """Added mass that the component carries, between two motions (3n,) of hulls, in SI."""
        given = {
            link.source.component
            for link in self.wiring.all_links
            if link.target.component == self.component and link.target.variable.startswith(MATRIX)
        }
        parts = zip(hulls, motion.reshape(-1, 3), other.reshape(-1, 3), strict=True)
        wet = [(hull, hull.motion(left), hull.motion(right)) for hull, left, right in parts]
        return sum(
            float(left @ self._matrix(component, a.base, b.base, len(left)) @ right)
            for component in given
            for a, left, _ in wet
            for b, _, right in wet
        )

    def _matrix(self, component: str, one: str, other: str, n: int) -> np.ndarray:
        """Added mass (n, n) [SI] that a component gives to two bodies, in world axes; or 0."""
        known = self.network.instances[component].description.variables
        bodies = {
            connector(link.target): connector(link.source)
            for link in self.wiring.all_links
            if link.source.component == component and link.target.component == self.component
        }
        order = in_order(added_mass_bodies(known))
        if bodies.get(one) not in order or bodies.get(other) not in order:
            return np.zeros((n, n))
        rows, columns = (n * order.index(bodies[b]) + np.arange(1, n + 1) for b in (one, other))
        read = self.network.read
        return np.array([[read(f"{component}.{MATRIX}{i},{j}]") for j in columns] for i in rows])


def _unit(hull: FloatingHull, symbol: str) -> float:
    """By which a motion of a body is made dimensionless: √mass [√kg], times the size of a turn."""
    size = max(hull.size, 1e-9) if symbol.startswith("moment") else 1.0
    return size * math.sqrt(max(hull.neutral_mass, 1e-9))


def _rotation(hulls: Sequence[FloatingHull]) -> np.ndarray:
    """Motions (3n,) of bodies that turn as one about the middle of the displaced water."""
    along, up = _middle(hulls)
    places = [_place(hull.network, hull.name, hull.plane) for hull in hulls]
    return np.array([[place[1] - up, along - place[0], 1.0] for place in places]).ravel()


def _middle(hulls: Sequence[FloatingHull]) -> tuple[float, float]:
    """Of the hulls' centres of gravity, weighted by the displaced water: ahead, and up [m]."""
    places = np.array([_place(hull.network, hull.name, hull.plane) for hull in hulls])
    masses = np.array([max(hull.neutral_mass, 1e-9) for hull in hulls])
    along, up = masses @ places / masses.sum()
    return float(along), float(up)


def _place(network: AtStart, name: str, plane: Plane) -> tuple[float, float]:
    """Of the body `name`, along the plane's horizontal axis, and up [m]."""
    terms = [("x", plane.ahead[0]), ("y", plane.ahead[1])]
    along = sum(w * float(network.read(f"{name}.{axis}")) for axis, w in terms if w != 0.0)
    return along, float(network.read(f"{name}.z"))
