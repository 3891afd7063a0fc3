"""Unbalanced forces at the start on floating bodies that joints connect, within one component.

The accelerations a of the bodies (three motions each in a planar model, six in space) follow from
the forces by the mobility Y = ∂a/∂F_water: a = Y (F_water + F). F is the load: weight, the model's
own loads and all other connected forces. The range of Y holds the motions that the joints allow;
bodies whose blocks in the projector on it are coupled are joined by joints. Joint reactions do no
work in an allowed motion δ, so c = Y⁺ δ gives the generalised load δ·F = c·a − δ·F_water.

The motions δ that are looked at are heave, and the turns in a vertical plane: that of a planar
model, or in space the planes ahead and across, by the heading.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.fmu import Description

WRENCH = ("force_x", "force_z", "moment_y")
ACROSS = ("force_y", "force_z", "moment_x")
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
ACCELERATIONS: dict[str, str] = dict(
    zip(FORCES, ("ax", "ay", "az", "alpha_x", "alpha", "alpha_z"), strict=True)
)
"""Of a body's centre of gravity, by the components of the force that are along them."""
BUOYANCY = ".buoyancy_force_z"
WATER = 1e3
"""Density [kg/m3], near enough for the size of a body by the mass that it displaces."""
RANK = 1e-9
"""Eigenvalue of the mobility, over the largest, below which joints forbid a motion."""
COUPLED = 1e-6
"""Share of a motion that counts as rounding."""


class OneAtStart(Protocol):
    """A component at the start."""

    @property
    def description(self) -> Description:
        """That of its FMU."""
        ...

    def directional_derivative(self, output: str, known: str) -> float:
        """∂output/∂known, in their units."""
        ...


class AtStart(Protocol):
    """The components at the start: of a run a network, else those of a composed program."""

    @property
    def instances(self) -> Mapping[str, OneAtStart]:
        """Components by name."""
        ...

    def read(self, name: str) -> float:
        """The value of ``component.variable``, in its unit."""
        ...


@dataclass(frozen=True)
class Plane:
    """A vertical plane: `ahead` is its horizontal axis (x, y) [1] in the world.

    Its three motions are along that axis, up, and the turn from up towards ahead. Of the motions of
    a body in water these are the `numbers`; the turn has the `sign` there. `forces` are named so in
    the water's axes. `tilt` and `turn` are words.
    """

    ahead: tuple[float, float] = (1.0, 0.0)
    numbers: tuple[int, int, int] = (1, 2, 3)
    forces: tuple[str, str, str] = WRENCH
    sign: float = 1.0
    tilt: str = "trim"
    turn: str = "pitch"

    @property
    def signs(self) -> np.ndarray:
        """Of the three motions, (3,) [1]."""
        return np.array([1.0, 1.0, self.sign])

    def in_world(self, motion: np.ndarray) -> np.ndarray:
        """A motion (3,) [m, m, rad] in this plane as one of the world, (6,) [m, rad]."""
        (c, s), (along, up, turn) = self.ahead, motion
        return np.array([c * along, s * along, up, -s * turn, c * turn, 0.0])


@dataclass(frozen=True)
class Hull:
    """A body of a hydrodynamics component: `component`.`body`; `link` leads to its ``z``.

    It is looked at in a `plane`.
    """

    network: AtStart
    component: str
    body: str
    link: Link
    plane: Plane = Plane()

    @property
    def name(self) -> str:
        return f"{self.component}.{self.body}"

    @property
    def holder(self) -> str:
        """The connector ``component.group`` that holds the body's mass."""
        return str(self.link.source).removesuffix(".z")

    @property
    def base(self) -> str:
        """The group in it."""
        return self.link.source.variable.removesuffix(".z")

    def parameter(self, name: str) -> float:
        """A parameter of the body; 0 if it has none of this name."""
        known = self.network.instances[self.component].description.variables
        name = f"{self.body}.{name}"
        return float(self.network.read(f"{self.component}.{name}")) if name in known else 0.0

    @property
    def symbols(self) -> tuple[str, ...]:
        """The forces by which its holder takes it: three of a planar model, or six."""
        holder = self.network.instances[self.link.source.component].description.variables
        return FORCES if f"{self.base}.force_y" in holder else WRENCH

    @property
    def heading(self) -> float:
        """Heading of the water's coefficients [rad]; 0 of water that has none."""
        known = self.network.instances[self.component].description.variables
        return float(self.network.read(f"{self.component}.heading")) if "heading" in known else 0.0

    @property
    def is_in_space(self) -> bool:
        """True if the body has six motions in the water."""
        known = self.network.instances[self.component].description.variables
        return f"{self.body}.omega_z" in known

    def planes(self) -> list[Plane]:
        """The planes in which it is looked at."""
        if not self.is_in_space:
            return [Plane()]
        c, s = math.cos(self.heading), math.sin(self.heading)
        along = Plane((c, s) if s else (1.0, 0.0), (1, 3, 5))
        if self.symbols == WRENCH:
            return [along] if s == 0.0 else []
        return [along, Plane((-s, c), (2, 3, 4), ACROSS, -1.0, "heel", "roll")]

    @property
    def buoyancy(self) -> np.ndarray:
        """Force and moment of the still water in the reference pose (3,) [N, N, N.m]."""
        found = [self.parameter(f"buoyancy_{symbol}") for symbol in self.plane.forces]
        return self.plane.signs * found

    @property
    def neutral_mass(self) -> float:
        """Mass of the displaced water [kg]."""
        return self.parameter("neutral_mass")

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Hydrostatic stiffness (3, 3), about the centre of gravity [N/m, N/rad, N.m/rad]."""
        numbers, signs = self.plane.numbers, self.plane.signs
        found = [
            [self.parameter(f"hydrostatic_stiffness[{i},{j}]") for j in numbers] for i in numbers
        ]
        return np.array(found) * np.outer(signs, signs)

    @property
    def size(self) -> float:
        """Side of the cube that the body displaces [m]."""
        return math.cbrt(self.neutral_mass / WATER)

    @property
    def draft(self) -> float:
        """Mean draft [m], displaced volume over waterplane; of a submerged body its `size`."""
        waterplane = self.stiffness[1, 1]
        return self.buoyancy[1] / waterplane if waterplane > 0 else self.size

    def added_mass(self, other: Hull) -> float:
        """That in heave at infinite frequency, of both bodies [kg]; 0 if there is none."""
        known = self.network.instances[self.component].description.variables
        bodies = [name.removesuffix(BUOYANCY) for name in known if name.endswith(BUOYANCY)]
        size, heave = (6, 3) if self.is_in_space else (3, 2)
        row, column = (size * bodies.index(hull.body) + heave for hull in (self, other))
        name = f"added_mass[{row},{column}]"
        if other.component != self.component or name not in known:
            return 0.0
        return float(self.network.read(f"{self.component}.{name}"))


@dataclass(frozen=True)
class Balance:
    """A free body, or bodies that joints join, at the start.

    `force` and `moment` are out of balance [N, N.m]: load and buoyancy in the reference pose, in
    heave and in the turn of all bodies as one, the moment about their middle and in the water's
    sense. They are None where joints forbid that motion. `load` is the vertical one downwards [N],
    `connected` its part by connected forces, `mass` what it accelerates, without the added mass
    [kg].
    """

    hulls: tuple[Hull, ...]
    load: float = 0.0
    connected: float = 0.0
    mass: float = 0.0
    force: float | None = None
    moment: float | None = None

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
        """Of one body or of all turning as one [N.m/rad]; heave follows freely."""
        turn = _rotation(self.hulls).reshape(-1, 3)
        heave = np.array([0.0, 1.0, 0.0])
        pairs = list(zip(self.hulls, turn, strict=True))
        pitch = sum(float(v @ hull.stiffness @ v) for hull, v in pairs)
        coupling = sum(float(heave @ hull.stiffness @ v) for hull, v in pairs)
        free = self.heave_stiffness
        return pitch - coupling**2 / free if free > 0 else pitch


def balances(network: AtStart, wiring: Wiring, hulls: Sequence[Hull]) -> Iterator[Balance]:
    """For each free body and each group of joined ones, of the components that tell it."""
    sources = {link.target: link for link in wiring.links}
    held: dict[str, list[Hull]] = {}
    for hull in hulls:
        if hull.planes() and _is_told(network, sources, hull):
            held.setdefault(hull.link.source.component, []).append(hull)
    for holder, of_it in held.items():
        yield from _Mobility(network, wiring, holder, of_it).balances()


def _is_told(network: AtStart, sources: dict[Port, Link], hull: Hull) -> bool:
    """True if the holder has exact derivatives, and the water's force comes straight to it."""
    component = hull.link.source.component
    described = network.instances[component].description
    symbols = hull.symbols
    names = [f"{hull.base}.{name}" for s in symbols for name in (s, ACCELERATIONS[s])]
    if not described.directional_derivatives or any(n not in described.variables for n in names):
        return False
    given = {s: sources.get(Port(component, f"{hull.base}.{s}")) for s in symbols}
    return all(
        link is None or (link.is_plain and link.source == Port(hull.component, f"{hull.body}.{s}"))
        for s, link in given.items()
    ) and isinstance(given["force_z"], Link)


class _Mobility:
    """How forces on the bodies of one component accelerate them.

    All is made dimensionless by `unit`, (m,) of all motions: with it mobilities of bodies and
    motions compare.
    """

    def __init__(
        self, network: AtStart, wiring: Wiring, component: str, hulls: Sequence[Hull]
    ) -> None:
        self.network, self.wiring, self.component = network, wiring, component
        self.hulls = hulls
        parts = [(hull, symbol) for hull in hulls for symbol in hull.symbols]
        self.inputs = [f"{hull.base}.{symbol}" for hull, symbol in parts]
        self.outputs = [f"{hull.base}.{ACCELERATIONS[symbol]}" for hull, symbol in parts]
        self.owners = np.array([hulls.index(hull) for hull, _ in parts])
        self.of_water = {f"{hull.base}.{symbol}" for hull in hulls for symbol in FORCES}
        self.unit = np.array([_unit(hull, symbol) for hull, symbol in parts])
        mobility = np.array([self._derivatives(name) for name in self.inputs]).T
        values, vectors = np.linalg.eigh(self._symmetric(mobility * np.outer(self.unit, self.unit)))
        kept = values > RANK * values.max(initial=0.0)
        self.projector = vectors[:, kept] @ vectors[:, kept].T
        self.inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T

    @staticmethod
    def _symmetric(matrix: np.ndarray) -> np.ndarray:
        return (matrix + matrix.T) / 2.0

    def _derivatives(self, name: str) -> np.ndarray:
        """Of the accelerations by one input, (m,)."""
        slope = self.network.instances[self.component].directional_derivative
        return np.array([slope(out, name) for out in self.outputs])

    def _read(self, names: Sequence[str]) -> np.ndarray:
        return np.array([float(self.network.read(f"{self.component}.{name}")) for name in names])

    @cached_property
    def connected(self) -> np.ndarray:
        """Accelerations (m,) by the connected forces, but for those of the water."""
        total = np.zeros(len(self.outputs))
        for link in self.wiring.links:
            component, name = link.target.component, link.target.variable
            if component != self.component or name in self.of_water or not link.is_real:
                continue
            last = name.rpartition(".")[2]
            if last in FORCES or last.startswith("effort"):
                value = self.network.read(str(link.source)) + link.offset / link.factor
                total += self._derivatives(name) * value
        return total

    def groups(self) -> list[list[int]]:
        """Indices of the bodies that joints join."""
        left, found = set(range(len(self.hulls))), []
        joined = np.abs(self.projector) > COUPLED
        pairs = set(zip(*(self.owners[k] for k in np.nonzero(joined)), strict=True))
        while left:
            group = {min(left)}
            while (more := {j for i in group for j in left if (i, j) in pairs} - group) != set():
                group |= more
            left -= group
            found.append(sorted(group))
        return found

    def balances(self) -> Iterator[Balance]:
        for group in self.groups():
            hulls = [self.hulls[k] for k in group]
            planes = [hull.planes() for hull in hulls]
            for number in range(min(map(len, planes))):
                alike = [replace(h, plane=p[number]) for h, p in zip(hulls, planes, strict=True)]
                found = self._balance(group, tuple(alike))
                # the weight is told once, by the first plane
                yield found if number == 0 else replace(found, force=None)

    def _balance(self, group: Sequence[int], hulls: tuple[Hull, ...]) -> Balance:
        """That of one group, in the plane of `hulls`."""
        wrench, acceleration = self._read(self.inputs), self._read(self.outputs)
        heave, turn = np.tile([0.0, 1.0, 0.0], len(group)), _rotation(hulls)
        buoyancy = np.concatenate([hull.buoyancy for hull in hulls])
        found = Balance(hulls)
        motion = self._spread(group, hulls, turn)
        alike = len({hull.plane.ahead for hull in hulls}) == 1
        if alike and (c := self._weights(motion)) is not None:
            moment = c @ acceleration - motion @ wrench + turn @ buoyancy
            found = Balance(hulls, moment=hulls[0].plane.sign * float(moment))
        motion = self._spread(group, hulls, heave)
        if (c := self._weights(motion)) is not None:
            load = motion @ wrench - c @ acceleration
            found = Balance(
                hulls,
                load=float(load),
                connected=-float(c @ self.connected),
                mass=float(c @ motion) - self._added_mass(hulls),
                force=float(heave @ buoyancy - load),
                moment=found.moment,
            )
        return found

    def _spread(
        self, group: Sequence[int], hulls: Sequence[Hull], motion: np.ndarray
    ) -> np.ndarray:
        """A motion (3n,) of a group in its plane as one of all bodies, (m,)."""
        whole = np.zeros(len(self.inputs))
        for k, hull, part in zip(group, hulls, motion.reshape(-1, 3), strict=True):
            whole[self.owners == k] = part if hull.symbols == WRENCH else hull.plane.in_world(part)
        return whole

    def _weights(self, motion: np.ndarray) -> np.ndarray | None:
        """c with c·a = `motion`·(all forces); None of a motion that joints forbid."""
        scaled = self.unit * motion
        if np.abs(self.projector @ scaled - scaled).max() > COUPLED * np.abs(scaled).max():
            return None
        return self.unit * (self.inverse @ scaled)

    def _added_mass(self, hulls: Sequence[Hull]) -> float:
        """Added mass that the component carries [kg]."""
        carried = {
            link.source.component
            for link in self.wiring.all_links
            if link.target.component == self.component
            and link.target.variable.startswith("added_mass[")
        }
        return sum(a.added_mass(b) for a in hulls for b in hulls if a.component in carried)


def _unit(hull: Hull, symbol: str) -> float:
    """By which a motion of a body is made dimensionless: √mass [√kg], times the size of a turn."""
    size = max(hull.size, 1e-9) if symbol.startswith("moment") else 1.0
    return size * math.sqrt(max(hull.neutral_mass, 1e-9))


def _rotation(hulls: Sequence[Hull]) -> np.ndarray:
    """Motions (3n,) of bodies that turn as one about the middle of the displaced water."""
    places = np.array([_place(hull) for hull in hulls])
    masses = np.array([max(hull.neutral_mass, 1e-9) for hull in hulls])
    arms = places - masses @ places / masses.sum()
    return np.column_stack([arms[:, 1], -arms[:, 0], np.ones(len(hulls))]).ravel()


def _place(hull: Hull) -> tuple[float, float]:
    """Along the plane's horizontal axis, and up [m]."""
    terms = [("x", hull.plane.ahead[0]), ("y", hull.plane.ahead[1])]
    read = hull.network.read
    along = sum(w * float(read(f"{hull.name}.{name}")) for name, w in terms if w != 0.0)
    return along, float(read(f"{hull.name}.z"))
