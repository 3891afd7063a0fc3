"""Unbalanced forces at the start on floating bodies that joints connect, within one component.

The accelerations a of the bodies (surge, heave, pitch of each) follow from the forces by the
mobility Y = ∂a/∂F_water: a = Y (F_water + F). F is the load: weight, the model's own loads and all
other connected forces. The range of Y holds the motions that the joints allow; bodies whose blocks
in the projector on it are coupled are joined by joints. Joint reactions do no work in an allowed
motion δ, so c = Y⁺ δ gives the generalised load δ·F = c·a − δ·F_water.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.cosim.exchange.network import Network

POSE = ("x", "z", "theta")
WRENCH = ("force_x", "force_z", "moment_y")
ACCELERATION = ("ax", "az", "alpha")
BUOYANCY = ".buoyancy_force_z"
WATER = 1e3
"""Density [kg/m3], near enough for the size of a body by the mass that it displaces."""
RANK = 1e-9
"""Eigenvalue of the mobility, over the largest, below which joints forbid a motion."""
COUPLED = 1e-6
"""Share of a motion that counts as rounding."""


@dataclass(frozen=True)
class Hull:
    """A body of a hydrodynamics component: `component`.`body`; `link` leads to its ``z``."""

    network: Network
    component: str
    body: str
    link: Link

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
        """True if the body has six motions; those looked at are surge, heave and pitch."""
        known = self.network.instances[self.component].description.variables
        return f"{self.body}.omega_z" in known

    @property
    def buoyancy(self) -> np.ndarray:
        """Force and moment of the still water in the reference pose (3,) [N, N, N.m]."""
        return np.array([self.parameter(f"buoyancy_{symbol}") for symbol in WRENCH])

    @property
    def neutral_mass(self) -> float:
        """Mass of the displaced water [kg]."""
        return self.parameter("neutral_mass")

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Hydrostatic stiffness (3, 3), about the centre of gravity [N/m, N/rad, N.m/rad]."""
        numbers = (1, 3, 5) if self.is_in_space else (1, 2, 3)
        return np.array(
            [[self.parameter(f"hydrostatic_stiffness[{i},{j}]") for j in numbers] for i in numbers]
        )

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
    holders = {hull.link.source.component: None for hull in hulls}
    for holder in holders:
        held = [
            hull
            for hull in hulls
            if hull.link.source.component == holder and _is_told(network, sources, hull)
        ]
        if held:
            yield from _Mobility(network, wiring, holder, held).balances()


def _is_told(network: Network, sources: dict[Port, Link], hull: Hull) -> bool:
    """True if the holder has exact derivatives, and the water's force comes straight to it."""
    component = hull.link.source.component
    described = network.instances[component].description
    names = [f"{hull.base}.{symbol}" for symbol in (*WRENCH, *ACCELERATION)]
    if not described.directional_derivatives or any(n not in described.variables for n in names):
        return False
    given = [sources.get(Port(component, f"{hull.base}.{symbol}")) for symbol in WRENCH]
    wanted = [Port(hull.component, f"{hull.body}.{symbol}") for symbol in WRENCH]
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
        self.inputs = [f"{hull.base}.{symbol}" for hull in hulls for symbol in WRENCH]
        self.outputs = [f"{hull.base}.{symbol}" for hull in hulls for symbol in ACCELERATION]
        scales = [(1.0, 1.0, max(hull.size, 1e-9)) for hull in hulls]
        masses = [math.sqrt(max(hull.neutral_mass, 1e-9)) for hull in hulls]
        self.unit = np.concatenate([m * np.array(s) for m, s in zip(masses, scales, strict=True)])
        mobility = np.array([self._derivatives(name) for name in self.inputs]).T
        values, vectors = np.linalg.eigh(self._symmetric(mobility * np.outer(self.unit, self.unit)))
        kept = values > RANK * values.max(initial=0.0)
        self.projector = vectors[:, kept] @ vectors[:, kept].T
        self.inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T

    @staticmethod
    def _symmetric(matrix: np.ndarray) -> np.ndarray:
        return (matrix + matrix.T) / 2.0

    def _derivatives(self, name: str) -> np.ndarray:
        instance = self.network.instances[self.component]
        return np.array([instance.directional_derivative(out, name) for out in self.outputs])

    def _read(self, names: Sequence[str]) -> np.ndarray:
        return np.array([float(self.network.read(f"{self.component}.{name}")) for name in names])

    @cached_property
    def connected(self) -> np.ndarray:
        """Accelerations (3n,) by the connected forces, but for those of the water."""
        total = np.zeros(len(self.outputs))
        for link in self.wiring.links:
            component, name = link.target.component, link.target.variable
            if component != self.component or name in self.inputs or not link.is_real:
                continue
            last = name.rpartition(".")[2]
            if last in WRENCH or last.startswith("effort"):
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
            for link in self.wiring.initial_links
            if link.target.component == self.component
            and link.target.variable.startswith("added_mass[")
        }
        return sum(a.added_mass(b) for a in hulls for b in hulls if a.component in carried)


def _rotation(hulls: Sequence[Hull]) -> np.ndarray:
    """Motions (3n,) of bodies that turn as one about the middle of the displaced water."""
    places = np.array(
        [[float(h.network.read(f"{h.name}.{symbol}")) for symbol in ("x", "z")] for h in hulls]
    )
    masses = np.array([max(hull.neutral_mass, 1e-9) for hull in hulls])
    arms = places - masses @ places / masses.sum()
    return np.column_stack([arms[:, 1], -arms[:, 0], np.ones(len(hulls))]).ravel()
