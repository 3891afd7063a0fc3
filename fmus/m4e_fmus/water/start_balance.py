"""Unbalanced forces at the start on floating bodies, which joints of one component may connect.

The accelerations a of the hulls (three motions each in a planar model, six in space) follow from
the forces by the mobility Y = ∂a/∂F_water: a = Y (F_water + F). F is the load: weight, the model's
own loads and all other connected forces, as far as joints and other bodies pass them on to the
hulls. The range of Y holds the motions that the joints allow; hulls whose blocks in the projector
on it are coupled are joined. Joint reactions do no work in an allowed motion δ, so c = Y⁺ δ gives
the generalised load δ·F = c·a − δ·F_water.

The motions δ that are looked at are heave, and the turns in a vertical plane: that of a planar
model, or in space the planes ahead and across, by the heading. In them all joined hulls move as
one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.csgraph import connected_components

from m4e_fmi.cosim.wiring.links import Port, Wiring
from m4e_fmus.water.hulls import FORCES, AtStart, FloatingHull

ACCELERATIONS: dict[str, str] = dict(
    zip(FORCES, ("ax", "ay", "az", "alpha_x", "alpha", "alpha_z"), strict=True)
)
"""Of a body's centre of gravity, by the components of the force that are along them."""
RANK = 1e-9
"""Eigenvalue of the mobility, over the largest, below which joints forbid a motion."""
COUPLED = 1e-6
"""Share of a motion that counts as rounding."""


@dataclass(frozen=True)
class Balance:
    """A free hull, or hulls that joints join, at the start.

    `force` and `moment` are out of balance [N, N.m]: load and buoyancy in the reference pose, in
    heave and in the turn of all as one, the moment about their middle and in the water's sense.
    They are None where joints forbid that motion, and the moment where other components, as
    members, add to the forces of the water. `is_alone`: one hull that carries no other body.
    """

    hulls: tuple[FloatingHull, ...]
    force: float | None
    moment: float | None
    is_alone: bool

    @property
    def buoyancy(self) -> float:
        """Vertical force of the still water in the reference pose [N]."""
        return float(sum(hull.buoyancy[1] for hull in self.hulls))

    @property
    def neutral_mass(self) -> float:
        """Mass of the displaced water [kg]."""
        return sum(hull.neutral_mass for hull in self.hulls)


def balances(network: AtStart, wiring: Wiring, hulls: Sequence[FloatingHull]) -> Iterator[Balance]:
    """For each free hull and each group of joined ones, of the components that tell it."""
    held: dict[str, list[FloatingHull]] = {}
    for hull in hulls:
        if hull.planes() and _is_told(network, wiring, hull):
            held.setdefault(hull.link.source.component, []).append(hull)
    for component, of_it in held.items():
        yield from _of_component(network, wiring, component, of_it)


def _is_told(network: AtStart, wiring: Wiring, hull: FloatingHull) -> bool:
    """True if the holder has exact derivatives, and the water's force comes straight to it."""
    component = hull.link.source.component
    described = network.instances[component].description
    names = [f"{hull.base}.{name}" for s in hull.symbols for name in (s, ACCELERATIONS[s])]
    links = {(link.source, link.target) for link in wiring.all_links if link.is_plain}
    return (
        described.directional_derivatives
        and all(name in described.variables for name in names)
        and all(
            (Port(hull.component, f"{hull.body}.{s}"), Port(component, f"{hull.base}.{s}")) in links
            for s in hull.symbols
        )
    )


def _of_component(
    network: AtStart, wiring: Wiring, component: str, hulls: Sequence[FloatingHull]
) -> Iterator[Balance]:
    """The balances of the `hulls` that one component holds."""
    instance = network.instances[component]
    parts = [(k, hull, symbol) for k, hull in enumerate(hulls) for symbol in hull.symbols]
    owners = np.array([k for k, _, _ in parts])
    unit = np.array([_unit(hull, symbol) for _, hull, symbol in parts])
    inputs = [f"{hull.base}.{symbol}" for _, hull, symbol in parts]
    outputs = [f"{hull.base}.{ACCELERATIONS[symbol]}" for _, hull, symbol in parts]
    acceleration = np.array([float(network.read(f"{component}.{name}")) for name in outputs])
    water = np.array([float(network.read(f"{hull.name}.{symbol}")) for _, hull, symbol in parts])
    mobility = np.array(
        [[instance.directional_derivative(y, u) for u in inputs] for y in outputs]
    ) * np.outer(unit, unit)
    values, vectors = np.linalg.eigh((mobility + mobility.T) / 2.0)
    kept = values > RANK * values.max(initial=0.0)
    projector = vectors[:, kept] @ vectors[:, kept].T
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T

    def unbalanced(group: Sequence[FloatingHull], number: int, moves: np.ndarray) -> float | None:
        """Work of load and buoyancy in a motion of a group, whose hulls have `moves` (n, 3).

        None where joints forbid it.
        """
        motion = np.zeros(len(parts))
        of_group = [k for k in range(len(hulls)) if labels[k] == number]
        for k, hull, part in zip(of_group, group, moves, strict=True):
            motion[owners == k] = hull.motion(part)
        scaled = unit * motion
        if np.abs(projector @ scaled - scaled).max() > COUPLED * np.abs(scaled).max():
            return None
        load = unit * (inverse @ scaled) @ acceleration - motion @ water
        return float(load + sum(p @ hull.buoyancy for p, hull in zip(moves, group, strict=True)))

    joined = np.zeros((len(hulls), len(hulls)))
    np.add.at(joined, (owners[:, None], owners[None]), np.abs(projector) > COUPLED)
    count, labels = connected_components(joined, directed=False)
    shared = any(len(wiring.into.get(Port(component, name), ())) > 1 for name in inputs)
    described = instance.description
    carries = any(
        name.endswith(".alpha") and name not in outputs and not needs.isdisjoint(inputs)
        for name, needs in described.dependencies.items()
    )
    for number in range(count):
        group = [hull for hull, label in zip(hulls, labels, strict=True) if label == number]
        for k, planes in enumerate(zip(*(hull.planes() for hull in group), strict=False)):
            alike = [replace(h, plane=plane) for h, plane in zip(group, planes, strict=True)]
            moment = None
            if len({plane.ahead for plane in planes}) == 1 and not shared:
                moment = unbalanced(alike, number, _turn(alike))
            heave = np.tile([0.0, 1.0, 0.0], (len(alike), 1))
            yield Balance(
                hulls=tuple(alike),
                # the weight is told once, by the first plane
                force=unbalanced(alike, number, heave) if k == 0 else None,
                moment=None if moment is None else planes[0].sign * moment,
                is_alone=len(alike) == 1 and not carries,
            )


def _unit(hull: FloatingHull, symbol: str) -> float:
    """By which a motion of a body is made dimensionless: √mass [√kg], times the size of a turn."""
    size = max(hull.size, 1e-9) if symbol.startswith("moment") else 1.0
    return size * math.sqrt(max(hull.neutral_mass, 1e-9))


def _turn(hulls: Sequence[FloatingHull]) -> np.ndarray:
    """Motions (n, 3) of hulls that turn as one about their middle, by the displaced water."""
    places = np.array([hull.place for hull in hulls])
    masses = np.array([max(hull.neutral_mass, 1e-9) for hull in hulls])
    arms = places - masses @ places / masses.sum()
    return np.column_stack([arms[:, 1], -arms[:, 0], np.ones(len(hulls))])
