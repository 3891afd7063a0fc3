"""Hydrodynamic coefficients of floating bodies in the plane, from potential flow.

Motions are surge, heave, pitch of each body about its own centre of gravity, in the order of the
bodies: 3·N in all. Pitch turns +Z towards +X (about +Y). Waves are e^{−iωt}: a wave of complex
amplitude a has the elevation Re[a e^{−iωt}] at x = 0 and makes the force Re[X a e^{−iωt}].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

MEMORY_REACH = 4.5  # wavenumber times size up to which radiation matters
NO_WATERPLANE = 1e-6  # waterplane, relative to volume^(2/3), that is rounding of a closed mesh
MOTIONS = ("surge", "heave", "pitch")


def memory_size(volume: float, waterplane_area: float) -> float:
    """Radius [m] of the half-ball of that volume or of the disc of that area, the smaller one.

    A fully submerged body has no waterplane: then the volume alone counts.
    """
    ball = np.cbrt(1.5 * volume / np.pi)
    floats = waterplane_area > NO_WATERPLANE * np.cbrt(volume) ** 2
    return float(min(ball, np.sqrt(waterplane_area / np.pi)) if floats else ball)


@dataclass(frozen=True)
class Coefficients:
    """Arrays over nω frequencies and n = 3·N motions.

    Attributes
    ----------
    bodies : N names.
    centers : (N, 2) centres of gravity (x, z) [m] in the reference pose, world frame.
    omega : (nω,) angular frequencies [rad/s], increasing, finite, positive.
    added_mass, radiation_damping : (nω, n, n) [kg, kg.m, kg.m2] and [N.s/m, …]: [force, motion].
        As computed or read, so symmetric only as far as the panels allow: use the mean of both
        halves, 0.5 (A + Aᵀ), in estimates from two meshes. `fit_radiation` does.
    added_mass_inf : (n, n) added mass at infinite frequency, likewise.
    excitation : (nω, n) complex force per wave amplitude [N/m, N.m/m], diffraction and
        Froude-Krylov, for waves travelling in `wave_direction`.
    hydrostatic_stiffness : (n, n) of buoyancy about the centres of gravity: force = −K·motion.
    buoyancy : (n,) force of the still water in the reference pose [N, N, N.m].
    wave_direction : 0 or 180 [deg]: towards +X or −X.
    density [kg/m3], depth [m] (inf: deep), gravity [m/s2].
    resolved : (N,) angular frequencies [rad/s] up to which the panels of each body resolve the
        waves; empty: all frequencies.
    heights : (N, 2) lowest and highest points (z) [m] of the wetted hulls in the reference pose;
        empty: not known.
    """

    bodies: tuple[str, ...]
    centers: np.ndarray
    omega: np.ndarray
    added_mass: np.ndarray
    radiation_damping: np.ndarray
    added_mass_inf: np.ndarray
    excitation: np.ndarray
    hydrostatic_stiffness: np.ndarray
    buoyancy: np.ndarray
    wave_direction: float = 0.0
    density: float = 1025.0
    depth: float = np.inf
    gravity: float = 9.81
    resolved: Sequence[float] = ()
    heights: Sequence[tuple[float, float]] = ()

    def __post_init__(self) -> None:
        n, count = 3 * len(self.bodies), len(self.omega)
        expected = {
            "centers": (len(self.bodies), 2),
            "added_mass": (count, n, n),
            "radiation_damping": (count, n, n),
            "added_mass_inf": (n, n),
            "excitation": (count, n),
            "hydrostatic_stiffness": (n, n),
            "buoyancy": (n,),
        }
        for name, shape in expected.items():
            got = np.shape(getattr(self, name))
            if got != shape:
                raise ValueError(f"{name} has shape {got}, expected {shape}")
            if not np.all(np.isfinite(getattr(self, name))):
                raise ValueError(f"{name} has values that are not finite")
        if np.any(np.diff(self.omega, prepend=0.0) <= 0):
            raise ValueError("omega must be positive and increasing")
        if len(self.resolved) not in (0, len(self.bodies)):
            raise ValueError(f"resolved has {len(self.resolved)} values, expected one per body")
        if len(self.heights) not in (0, len(self.bodies)):
            raise ValueError(f"heights has {len(self.heights)} pairs, expected one per body")

    @property
    def motions(self) -> tuple[str, ...]:
        """The n motions as "<body> <motion>"."""
        return tuple(f"{body} {motion}" for body in self.bodies for motion in MOTIONS)

    @property
    def retardation(self) -> np.ndarray:
        """K(jω) = B + jω(A − A∞) of the radiation memory, (nω, n, n) [N.s/m, N.s, N.m.s]."""
        surplus = self.added_mass - self.added_mass_inf
        return self.radiation_damping + 1j * self.omega[:, None, None] * surplus

    @property
    def memory_limits(self) -> np.ndarray:
        """The frequencies [rad/s] up to which each motion's radiation matters, (n,).

        k a = 4.5 in deep water, a is the size of the motion's body as `memory_size` tells it.
        """
        stiffness = self.hydrostatic_stiffness.diagonal()[1::3] / (self.density * self.gravity)
        volumes = self.buoyancy[1::3] / (self.density * self.gravity)
        sizes = [memory_size(v, s) for v, s in zip(volumes, stiffness, strict=True)]
        reach = MEMORY_REACH * self.gravity
        return np.repeat([math.sqrt(reach / a) if a > 0 else math.inf for a in sizes], 3)

    @property
    def memory_limit(self) -> float:
        """The largest of `memory_limits` [rad/s]: the smallest body decides."""
        return float(self.memory_limits.max())

    @property
    def resolved_limits(self) -> np.ndarray:
        """`resolved` of each motion [rad/s], (n,)."""
        none = [math.inf] * len(self.bodies)
        return np.repeat(np.asarray(self.resolved if len(self.resolved) else none), 3)

    def excitation_at(self, omega: np.ndarray) -> np.ndarray:
        """Excitation (k, n) [N/m, N.m/m] at other frequencies `omega` (k,) [rad/s].

        Cubic splines of real and imaginary part, after taking out the phase of the wave's way to
        each body. At ω = 0 the water just rises: X = K[:, heave], which completes the table.

        Above the table the last value falls as ω⁻³: a wave that is short for the body is reflected
        and presses on a layer of thickness 1/k and a strip of width √(R/k), R the radius of the
        waterline, so the force falls as k^(−3/2) (MacCamy and Fuchs, 1954, for a cylinder).
        """
        from scipy.interpolate import CubicSpline

        knots = np.concatenate([[0.0], self.omega])
        heave = self.hydrostatic_stiffness.reshape(-1, len(self.bodies), 3)[:, :, 1].sum(axis=1)
        table = np.concatenate([heave[None, :], self.excitation * self._way(self.omega).conj()])
        omega = np.asarray(omega, dtype=float)
        values = CubicSpline(knots, table, axis=0)(np.minimum(omega, knots[-1]))
        fallen = (knots[-1] / np.maximum(omega, knots[-1])) ** 3
        return fallen[:, None] * values * self._way(omega)

    def _way(self, omega: np.ndarray) -> np.ndarray:
        """e^{i k x_G cos β} of each motion's body, (k, n)."""
        from m4e_adapters.hydrodynamics.waves import wavenumber

        k = wavenumber(np.asarray(omega), depth=self.depth, gravity=self.gravity)
        towards = np.cos(np.radians(self.wave_direction))
        return np.exp(1j * towards * k[:, None] * np.repeat(self.centers[:, 0], 3)[None, :])

    def arrays(self) -> dict[str, np.ndarray]:
        """All fields as arrays with the shape of the attributes, SI, for a file."""
        return {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}
