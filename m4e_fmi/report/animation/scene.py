"""A scene: what an animation of results shows, with names of variables where something moves.

Lengths in m, angles in rad, world frame; places of bodies in their axes. `scene_text` has its text.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from m4e_fmi.report.drawing.hulls import Hull
from m4e_fmi.statistics.record import weights

GROUND = -1
DEEP = 300.0
"""k h beyond which water is as deep as any."""
Triple = tuple[float, float, float]
COORDINATES = ("x", "y", "z", "phi", "theta", "psi")
"""Of a body: place [m], and R = R_z(psi) R_y(theta) R_x(phi) [rad] from body to world axes."""


@dataclass(frozen=True)
class Spot:
    """A point of a body, in body axes from its centre of gravity [m]; of the ground if −1."""

    body: int
    at: Triple


@dataclass(frozen=True)
class Followed:
    """`factor` times the variable ``component.name``, plus `offset`."""

    variable: str
    factor: float = 1.0
    offset: float = 0.0


Value = float | Followed
Place = tuple[Value, Value, Value]
"""x, y, z [m]."""


@dataclass(frozen=True)
class Body:
    """A rigid body: its surfaces, lines from its origin to `sticks` [m], and its motion.

    The motion has the coordinates of `COORDINATES`, in their order.
    """

    name: str
    motion: tuple[Value, ...]
    surfaces: tuple[Hull, ...] = ()
    sticks: tuple[Triple, ...] = ()


@dataclass(frozen=True)
class Rope:
    """A load on the line between two points; `rank` puts several aside."""

    kind: str
    ends: tuple[Spot, Spot]
    rank: float = 0.0


@dataclass(frozen=True)
class Cable:
    """A line through `nodes`, from end to end; through its `ends` if these were not recorded."""

    name: str
    ends: tuple[Place, Place]
    nodes: tuple[Place, ...] = ()


@dataclass(frozen=True)
class Train:
    """Airy waves that grow with one `ramp` [s]: ½(1 − cos π t/T) until t = T, then 1; 0: none.

    The elevation is ramp Σ a cos(ω t + φ − k (x cos β + y sin β)): `omega` [rad/s], `number` k
    [rad/m], `amplitude` [m], `phase` [rad] and `direction` [rad], all (n,).
    """

    omega: np.ndarray = field(repr=False)
    number: np.ndarray = field(repr=False)
    amplitude: np.ndarray = field(repr=False)
    phase: np.ndarray = field(repr=False)
    direction: np.ndarray = field(repr=False)
    ramp: float = 0.0

    @property
    def columns(self) -> tuple[np.ndarray, ...]:
        """Those five, (n,) each, in the units above."""
        return self.omega, self.number, self.amplitude, self.phase, self.direction

    def growth(self, time: np.ndarray) -> np.ndarray:
        """The ramp [1] at `time` (T,) [s], (T,)."""
        if not self.ramp:
            return np.ones(len(time))
        return 0.5 - 0.5 * np.cos(np.pi * np.minimum(time / self.ramp, 1.0))

    def elevation(self, x: float, y: float, time: np.ndarray) -> np.ndarray:
        """Height of the water [m] at x, y [m] and `time` (T,) [s], (T,)."""
        way = self.phase - self.number * (x * np.cos(self.direction) + y * np.sin(self.direction))
        height = np.cos(np.multiply.outer(time, self.omega) + way) @ self.amplitude
        return height * self.growth(time)

    def energy_flux(self, depth: float) -> float:
        """Σ g a² c_g/2 [m4/s3] of all waves, of any directions, in water of a `depth` [m].

        With g = ω²/(k tanh kh) and the group velocity c_g = ω/(2k) (1 + 2kh/sinh 2kh).
        """
        k, kh = self.number, np.minimum(self.number * depth, DEEP)
        shallower = 1.0 + 2.0 * kh / np.sinh(2.0 * kh)
        return 0.25 * float(
            np.sum(self.amplitude**2 * self.omega**3 / (k**2 * np.tanh(kh)) * shallower)
        )


@dataclass(frozen=True)
class Water:
    """Water with its still surface at z = 0, of a `depth` [m]; `trains` are the waves in it.

    `gauge` is the variable that has the elevation at x = y = 0, "" if none has. `density` [kg/m3]
    is 0 if it is not known.
    """

    depth: float
    trains: tuple[Train, ...] = ()
    gauge: str = ""
    density: float = 0.0

    def energy_flux(self, time: np.ndarray) -> float:
        """Mean power [W/m] per metre of crest of all waves over `time` (T,) [s], ramps included."""
        return self.density * sum(
            train.energy_flux(self.depth) * float(weights(time) @ train.growth(time) ** 2)
            for train in self.trains
        )

    def elevation(self, x: float, y: float, time: np.ndarray) -> np.ndarray:
        """Height [m] at x, y [m] and `time` (T,) [s], (T,)."""
        found = [train.elevation(x, y, time) for train in self.trains]
        return np.sum(found, axis=0) if found else np.zeros(len(time))


@dataclass(frozen=True)
class Scene:
    """All that is shown of a system; `planar` ones are seen from the side.

    `hinges` are points of joints, with True for welds; `axes` their lines, with True for those
    about which they turn. `floor` [m] is z of the bed, where there is one. `notes` tell what is
    not shown.
    """

    title: str
    description: str
    planar: bool
    bodies: tuple[Body, ...]
    hinges: tuple[tuple[Spot, bool], ...] = ()
    axes: tuple[tuple[Spot, Spot, bool], ...] = ()
    ropes: tuple[Rope, ...] = ()
    cables: tuple[Cable, ...] = ()
    water: Water | None = None
    floor: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[str, ...]:
        """All variables that an animation follows."""
        values = chain(
            *(body.motion for body in self.bodies),
            *(place for cable in self.cables for place in (*cable.ends, *cable.nodes)),
        )
        names = [value.variable for value in values if isinstance(value, Followed)]
        return tuple(dict.fromkeys(names))
