"""Unbalanced forces at the start on floating bodies that joints connect, within one component.

Bodies are looked at in a vertical plane: that of a planar model, or in space the planes ahead and
across, by the heading. The accelerations a of the bodies (surge, heave, pitch of each, or sway,
heave and roll) follow from the forces by the mobility Y = ∂a/∂F_water: a = Y (F_water + F). F is
the load: weight, the model's own loads and all other connected forces. The range of Y holds the
motions that the joints allow; bodies whose blocks in the projector on it are coupled are joined by
joints. Joint reactions do no work in an allowed motion δ, so c = Y⁺ δ gives the generalised load
δ·F = c·a − δ·F_water.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.cosim.exchange.network import Network

WRENCH = ("force_x", "force_z", "moment_y")
ACROSS = ("force_y", "force_z", "moment_x")
FORCES = {*WRENCH, *ACROSS, "moment_z"}
ACCELERATION = ("ax", "az", "alpha")
BUOYANCY = ".buoyancy_force_z"
WATER = 1e3
"""Density [kg/m3], near enough for the size of a body by the mass that it displaces."""
RANK = 1e-9
"""Eigenvalue of the mobility, over the largest, below which joints forbid a motion."""
COUPLED = 1e-6
"""Share of a motion that counts as rounding."""


Terms = list[tuple[str, float]]
"""Names of variables and their weights in a sum."""


@dataclass(frozen=True)
class Plane:
    """A vertical plane: `ahead` is its horizontal axis (x, y) [1] in the world.

    Of the motions of a body in water `numbers` are along that axis, up, and the turn, which counts
    with a `sign`; `forces` are named so in the water's axes. `tilt` and `turn` are words.
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

    def terms(self, base: str, symbols: Sequence[str]) -> list[Terms]:
        """Components in this plane of a vector pair: `symbols` for x, y, up, about x, about y."""
        (c, s), (x, y, up, roll, pitch) = self.ahead, symbols
        parts = [[(x, c), (y, s)], [(up, 1.0)], [(pitch, c), (roll, -s)]]
        return [[(f"{base}.{name}", w) for name, w in part if w != 0.0] for part in parts]


@dataclass(frozen=True)
class Hull:
    """A body of a hydrodynamics component: `component`.`body`; `link` leads to its ``z``.

    It is looked at in a `plane`.
    """

    network: Network
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
    def is_in_space(self) -> bool:
        """True if the body has six motions in the water."""
        known = self.network.instances[self.component].description.variables
        return f"{self.body}.omega_z" in known

    def planes(self) -> list[Plane]:
        """The planes in which it is looked at."""
        if not self.is_in_space:
            return [Plane()]
        holder = self.network.instances[self.link.source.component].description.variables
        heading = float(self.network.read(f"{self.component}.heading"))
        c, s = math.cos(heading), math.sin(heading)
        along = Plane((c, s) if s else (1.0, 0.0), (1, 3, 5))
        if f"{self.base}.force_y" not in holder:
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
    heave and pitch of all bodies as one, the moment about their middle. They are None where joints
    forbid that motion. `load` is the vertical one downwards [N], `connected` its part by connected
    forces, `mass` what it accelerates, without the added mass [kg].
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


def balances(network: Network, wiring: Wiring, hulls: Sequence[Hull]) -> Iterator[Balance]:
    """One for each free body and each group of joined ones, of the components that tell it."""
    sources = {link.target: link for link in wiring.links}
    held: dict[tuple[str, Plane], list[Hull]] = {}
    for hull in (hull for hull in hulls if _is_told(network, sources, hull)):
        for plane in hull.planes():
            group = hull.link.source.component, plane
            held.setdefault(group, []).append(replace(hull, plane=plane))
    for (holder, plane), group in held.items():
        for found in _Mobility(network, wiring, holder, group).balances():
            # the weight is told once
            yield found if plane.forces == WRENCH else replace(found, force=None)


def _is_told(network: Network, sources: dict[Port, Link], hull: Hull) -> bool:
    """True if the holder has exact derivatives, and the water's force comes straight to it."""
    component = hull.link.source.component
    described = network.instances[component].description
    symbols = list(dict.fromkeys((*WRENCH, *(p for q in hull.planes() for p in q.forces))))
    names = [f"{hull.base}.{symbol}" for symbol in (*symbols, *ACCELERATION)]
    if not described.directional_derivatives or any(n not in described.variables for n in names):
        return False
    given = [sources.get(Port(component, f"{hull.base}.{symbol}")) for symbol in symbols]
    wanted = [Port(hull.component, f"{hull.body}.{symbol}") for symbol in symbols]
    return all(
        link is None or (link.is_plain and link.source == port)
        for link, port in zip(given, wanted, strict=True)
    ) and isinstance(given[1], Link)


class _Mobility:
    """How forces on the bodies of one component accelerate them.

    All is made dimensionless by `unit`, (3n,): with it mobilities of bodies and motions compare.
    """

    def __init__(
        self, network: Network, wiring: Wiring, component: str, hulls: Sequence[Hull]
    ) -> None:
        self.network, self.wiring, self.component = network, wiring, component
        self.hulls = hulls
        forces = ("force_x", "force_y", "force_z", "moment_x", "moment_y")
        moved = ("ax", "ay", "az", "alpha_x", "alpha")
        self.inputs = [t for hull in hulls for t in hull.plane.terms(hull.base, forces)]
        self.outputs = [t for hull in hulls for t in hull.plane.terms(hull.base, moved)]
        self.of_water = {f"{hull.base}.{symbol}" for hull in hulls for symbol in FORCES}
        scales = [(1.0, 1.0, max(hull.size, 1e-9)) for hull in hulls]
        masses = [math.sqrt(max(hull.neutral_mass, 1e-9)) for hull in hulls]
        self.unit = np.concatenate([m * np.array(s) for m, s in zip(masses, scales, strict=True)])
        columns = [
            sum(weight * self._derivatives(name) for name, weight in terms) for terms in self.inputs
        ]
        mobility = np.array(columns).T
        values, vectors = np.linalg.eigh(self._symmetric(mobility * np.outer(self.unit, self.unit)))
        kept = values > RANK * values.max(initial=0.0)
        self.projector = vectors[:, kept] @ vectors[:, kept].T
        self.inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T

    @staticmethod
    def _symmetric(matrix: np.ndarray) -> np.ndarray:
        return (matrix + matrix.T) / 2.0

    def _derivatives(self, name: str) -> np.ndarray:
        """Of the accelerations by one input, (3n,)."""
        slope = self.network.instances[self.component].directional_derivative
        return np.array([sum(w * slope(out, name) for out, w in terms) for terms in self.outputs])

    def _read(self, sums: Sequence[Terms]) -> np.ndarray:
        def value(name: str) -> float:
            return float(self.network.read(f"{self.component}.{name}"))

        return np.array([sum(weight * value(name) for name, weight in terms) for terms in sums])

    @cached_property
    def connected(self) -> np.ndarray:
        """Accelerations (3n,) by the connected forces, but for those of the water."""
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
        count = len(self.hulls)
        blocks = np.abs(self.projector).reshape(count, 3, count, 3).max(axis=(1, 3)) > COUPLED
        left, found = set(range(count)), []
        while left:
            group = {min(left)}
            while (more := {j for i in group for j in left if blocks[i, j]} - group) != set():
                group |= more
            left -= group
            found.append(sorted(group))
        return found

    def balances(self) -> Iterator[Balance]:
        wrench = self._read(self.inputs)
        acceleration = self._read(self.outputs)
        for group in self.groups():
            hulls = tuple(self.hulls[k] for k in group)
            buoyancy = np.zeros(len(self.inputs))
            for k in group:
                buoyancy[3 * k : 3 * k + 3] = self.hulls[k].buoyancy
            heave, turn = (
                self._spread(group, motion)
                for motion in (np.tile([0.0, 1.0, 0.0], len(group)), _rotation(hulls))
            )
            found = Balance(hulls)
            if (weights := self._weights(turn)) is not None:
                moment = weights @ acceleration - turn @ (wrench - buoyancy)
                found = Balance(hulls, moment=float(moment))
            if (weights := self._weights(heave)) is not None:
                load = heave @ wrench - weights @ acceleration
                found = Balance(
                    hulls,
                    load=float(load),
                    connected=-float(weights @ self.connected),
                    mass=float(weights @ heave) - self._added_mass(hulls),
                    force=float(heave @ buoyancy - load),
                    moment=found.moment,
                )
            yield found

    def _spread(self, group: Sequence[int], motion: np.ndarray) -> np.ndarray:
        whole = np.zeros((len(self.hulls), 3))
        whole[list(group)] = motion.reshape(-1, 3)
        return whole.ravel()

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
