"""Bodies in water at the start of a run, and the vertical planes in which they are looked at."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from m4e_fmi.cosim.wiring.links import Link
from m4e_fmi.fmu import Description

WRENCH = ("force_x", "force_z", "moment_y")
ACROSS = ("force_y", "force_z", "moment_x")
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
BUOYANCY = ".buoyancy_force_z"
WATER = 1e3
"""Density [kg/m3], near enough for the size of a body by the mass that it displaces."""


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


@dataclass(frozen=True)
class FloatingHull:
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

    def planes(self) -> list[Plane]:
        """The planes in which it is looked at."""
        known = self.network.instances[self.component].description.variables
        if f"{self.body}.omega_z" not in known:  # three motions in the water
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
    def turn_stiffness(self) -> float:
        """Of the turn in the plane, with its neutral mass [N.m/rad]; heave is free."""
        heave, coupling, turn = self.stiffness[1, 1], self.stiffness[1, 2], self.stiffness[2, 2]
        return float(turn - coupling**2 / heave if heave > 0 else turn)

    @property
    def size(self) -> float:
        """Side of the cube that the body displaces [m]."""
        return math.cbrt(self.neutral_mass / WATER)

    @property
    def draft(self) -> float:
        """Mean draft [m], displaced volume over waterplane; of a submerged body its `size`."""
        waterplane = self.stiffness[1, 1]
        return self.buoyancy[1] / waterplane if waterplane > 0 else self.size

    @property
    def place(self) -> tuple[float, float]:
        """Of its centre of gravity, along the plane's horizontal axis, and up [m]."""
        terms = zip(("x", "y"), self.plane.ahead, strict=True)
        along = sum(w * float(self.network.read(f"{self.name}.{axis}")) for axis, w in terms if w)
        return along, float(self.network.read(f"{self.name}.z"))

    def motion(self, part: np.ndarray) -> np.ndarray:
        """The motion `part` (3,) in its plane as one along its `symbols`, (n,) [m, rad]."""
        if self.symbols == WRENCH:
            return part
        (c, s), (along, up, turn) = self.plane.ahead, part
        return np.array([c * along, s * along, up, -s * turn, c * turn, 0.0])
