"""Hydrodynamic coefficients of floating bodies from potential flow, in the plane or in space.

Motions are those of `geometry.motions` of each body about its own centre of gravity, in the order
of the bodies: m = 3 or 6 of each, m·N in all. Rotations are about +X, +Y, +Z: pitch turns +Z
towards +X. Waves are e^{−iωt}: a wave of complex amplitude a has the elevation Re[a e^{−iωt}] at
x = y = 0 and makes the force Re[X a e^{−iωt}]. Directions are those that waves travel to, from +X
towards +Y. In space all is in the axes that the hulls are drawn in; a heading turns them later.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import HEAVE, MOTIONS, Motion, point_in_space
from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

MEMORY_REACH = 4.5  # wavenumber times size up to which radiation matters
SAME_DIRECTION = 1e-3  # deg
NO_WATERPLANE = 1e-6  # waterplane, relative to volume^(2/3), that is rounding of a closed mesh


def memory_size(volume: float, waterplane_area: float) -> float:
    """Radius [m] of the half-ball of that volume or of the disc of that area, the smaller one.

    A fully submerged body has no waterplane: then the volume alone counts.
    """
    ball = np.cbrt(1.5 * volume / np.pi)
    floats = waterplane_area > NO_WATERPLANE * np.cbrt(volume) ** 2
    return float(min(ball, np.sqrt(waterplane_area / np.pi)) if floats else ball)


@dataclass(frozen=True)
class Coefficients:
    """Arrays over nω frequencies and n = m·N motions.

    Attributes
    ----------
    bodies : N names.
    centers : (N, 2) centres of gravity (x, z) [m] in the reference pose, or (N, 3), (x, y, z).
    omega : (nω,) angular frequencies [rad/s], increasing, finite, positive.
    added_mass, radiation_damping : (nω, n, n) [kg, kg.m, kg.m2] and [N.s/m, …]: [force, motion].
        As computed or read, so symmetric only as far as the panels allow: use the mean of both
        halves, 0.5 (A + Aᵀ), in estimates from two meshes. `fit_radiation` does.
    added_mass_inf : (n, n) added mass at infinite frequency, likewise.
    excitation : (nω, n) complex force per wave amplitude [N/m, N.m/m], diffraction and
        Froude-Krylov, for waves travelling in `wave_direction`.
    hydrostatic_stiffness : (n, n) of buoyancy about the centres of gravity: force = −K·motion.
    buoyancy : (n,) force of the still water in the reference pose [N, N, N.m].
    wave_direction : [deg]; 0 or 180 in the plane: towards +X or −X.
    density [kg/m3], depth [m] (inf: deep), gravity [m/s2].
    resolved : (N,) angular frequencies [rad/s] up to which the panels of each body resolve the
        waves; empty: all frequencies.
    heights : (N, 2) lowest and highest points (z) [m] of the wetted hulls in the reference pose;
        empty: not known.
    harmonics : (nω, 2M + 1, n) complex excitation as a function of the direction β, for waves
        whose elevation is Re[a e^{−iωt}] at each body's centre: Σ harmonics[:, M + j] e^{ijβ},
        j = −M … M. No rows: `wave_direction` is the only one, or one of `directions`.
    excited_by : the parts that the excitation consists of, of "froude_krylov" and "diffraction".
    directions : (nβ,) [deg], those that the excitation is known for if it is not for all; empty:
        `wave_direction` alone, or all if there are harmonics.
    by_direction : (nω, nβ, n) complex excitation for these.
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
    harmonics: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=complex))
    excited_by: tuple[str, ...] = ("froude_krylov", "diffraction")
    directions: np.ndarray = field(default_factory=lambda: np.zeros(0))
    by_direction: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=complex))

    def __post_init__(self) -> None:
        if np.ndim(self.centers) != 2 or self.dimensions not in MOTIONS:
            raise ValueError("centers have (x, z), or (x, y, z), of each body")
        n, count = self.per_body * len(self.bodies), len(self.omega)
        expected = {
            "centers": (len(self.bodies), self.dimensions),
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
        if self.has_harmonics and self.harmonics.shape[::2] != (count, n):
            raise ValueError(f"harmonics has shape {self.harmonics.shape}, expected nω, 2M + 1, n")
        if len(self.directions) and self.by_direction.shape != (count, len(self.directions), n):
            raise ValueError(
                f"by_direction has shape {self.by_direction.shape}, expected nω, nβ, n"
            )
        if np.any(np.diff(self.omega, prepend=0.0) <= 0):
            raise ValueError("omega must be positive and increasing")
        if len(self.resolved) not in (0, len(self.bodies)):
            raise ValueError(f"resolved has {len(self.resolved)} values, expected one per body")
        if len(self.heights) not in (0, len(self.bodies)):
            raise ValueError(f"heights has {len(self.heights)} pairs, expected one per body")

    @property
    def dimensions(self) -> int:
        """2 or 3."""
        return int(self.centers.shape[1])

    @property
    def body_motions(self) -> tuple[Motion, ...]:
        """The motions of each body."""
        return MOTIONS[self.dimensions]

    @property
    def per_body(self) -> int:
        """The number of motions of each body: 3 or 6."""
        return len(self.body_motions)

    def own(self, k: int) -> slice:
        """Where the motions of body `k` are."""
        return slice(k * self.per_body, (k + 1) * self.per_body)

    @property
    def heave(self) -> int:
        """Where heave is among the motions of a body."""
        return self.body_motions.index(HEAVE)

    @property
    def has_harmonics(self) -> bool:
        """True if the excitation is a function of the direction; after `towards` of one only."""
        return self.harmonics.size > 0

    def towards(self, direction: float) -> Coefficients:
        """The coefficients with the excitation for waves that travel to `direction` [deg].

        InputError for a direction that it is not known for.
        """
        if self.has_harmonics:
            return self
        known, table = self.directions, self.by_direction
        if not len(known):
            known, table = np.array([self.wave_direction]), self.excitation[:, None]
        apart = np.abs(np.mod(known - direction + 180.0, 360.0) - 180.0)
        if apart.min() > SAME_DIRECTION:
            shown = ", ".join(f"{angle:g}" for angle in known)
            raise InputError.single(
                f"the excitation is known for waves that travel at {shown} deg from the hulls' x "
                f"axis, not at {direction:g} deg",
                "use one of these directions, or coefficients for directions all around (computed: "
                "'dimensions: 3')",
            )
        excitation = table[:, int(apart.argmin())]
        found = replace(self, excitation=excitation, wave_direction=direction)
        if self.dimensions == 2:
            return found
        relative = excitation * self.way(self.omega, direction).conj()
        return replace(found, harmonics=relative[:, None, :])

    def without_interaction(self) -> Coefficients:
        """The coefficients without forces of one body's motion on another."""
        n = self.added_mass_inf.shape[0]
        own = np.equal.outer(np.arange(n) // self.per_body, np.arange(n) // self.per_body)
        names = ("added_mass", "radiation_damping", "added_mass_inf")
        return replace(self, **{name: getattr(self, name) * own for name in names})

    def without_flow(self) -> Coefficients:
        """The coefficients with the hydrostatics alone; those of the flow are 0."""
        names = (
            "added_mass", "radiation_damping", "added_mass_inf",
            "excitation", "harmonics", "by_direction",
        )  # fmt: skip
        return self._with_zeros(names)

    def without_excitation(self) -> Coefficients:
        """The coefficients with no part of the excitation."""
        found = self._with_zeros(("excitation", "harmonics", "by_direction"))
        return replace(found, excited_by=())

    def _with_zeros(self, names: Sequence[str]) -> Coefficients:
        return replace(self, **{name: 0 * getattr(self, name) for name in names})

    @property
    def places(self) -> np.ndarray:
        """Centres of gravity (N, 3), (x, y, z) [m]."""
        return np.array([point_in_space(center) for center in self.centers])

    @property
    def motions(self) -> tuple[str, ...]:
        """The n motions as "<body> <motion>"."""
        return tuple(f"{body} {m.name}" for body in self.bodies for m in self.body_motions)

    @property
    def memory_limits(self) -> np.ndarray:
        """The frequencies [rad/s] up to which each motion's radiation matters, (n,).

        k a = 4.5 in deep water, a is the size of the motion's body as `memory_size` tells it.
        """
        stiffness = self.hydrostatic_stiffness.diagonal()[self.heave :: self.per_body]
        stiffness = stiffness / (self.density * self.gravity)
        volumes = self.buoyancy[self.heave :: self.per_body] / (self.density * self.gravity)
        sizes = [memory_size(v, s) for v, s in zip(volumes, stiffness, strict=True)]
        reach = MEMORY_REACH * self.gravity
        return np.repeat(
            [math.sqrt(reach / a) if a > 0 else math.inf for a in sizes], self.per_body
        )

    @property
    def memory_limit(self) -> float:
        """The largest of `memory_limits` [rad/s]: the smallest body decides."""
        return float(self.memory_limits.max())

    @property
    def resolved_limits(self) -> np.ndarray:
        """`resolved` of each motion [rad/s], (n,)."""
        none = [math.inf] * len(self.bodies)
        return np.repeat(np.asarray(self.resolved if len(self.resolved) else none), self.per_body)

    def excitation_at(self, omega: np.ndarray) -> np.ndarray:
        """Excitation (k, n) [N/m, N.m/m] at other frequencies `omega` (k,) [rad/s].

        Cubic splines of real and imaginary part, after taking out the phase of the wave's way to
        each body. At ω = 0 the water just rises: X = K[:, heave], which completes the table; all of
        that is Froude-Krylov's part.

        Above the table the last value falls as ω⁻³: a wave that is short for the body is reflected
        and presses on a layer of thickness 1/k and a strip of width √(R/k), R the radius of the
        waterline, so the force falls as k^(−3/2) (MacCamy and Fuchs, 1954, for a cylinder).
        """
        table = self.excitation * self.way(self.omega, self.wave_direction).conj()
        omega = np.asarray(omega, dtype=float)
        return self._between(table[:, None, :], omega)[:, 0, :] * self.way(
            omega, self.wave_direction
        )

    def harmonics_at(self, omega: np.ndarray) -> np.ndarray:
        """`harmonics` (k, 2M + 1, n) [N/m, N.m/m] at other frequencies `omega` (k,) [rad/s].

        Between the frequencies, below and above them as of `excitation_at`.
        """
        return self._between(self.harmonics, np.asarray(omega, dtype=float))

    def _between(self, table: np.ndarray, omega: np.ndarray) -> np.ndarray:
        """A `table` (nω, 2M + 1, n) of excitation by the wave at each body's centre, at `omega`."""
        knots, spline = self._spline(table)
        values = spline(np.minimum(omega, knots[-1]))
        fallen = (knots[-1] / np.maximum(omega, knots[-1])) ** 3
        return fallen[:, None, None] * values

    def excitation_knots(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Knots (k,) [rad/s] of the splines of `harmonics_at`, values and slopes (k, 2M + 1, n).

        Values in N/m and N.m/m, slopes these per rad/s; between the knots the splines are cubic.
        Without harmonics those of `excitation_at`, M = 0, for waves at each body's centre.
        """
        table = self.harmonics
        if not self.has_harmonics:
            way = self.way(self.omega, self.wave_direction)
            table = (self.excitation * way.conj())[:, None, :]
        knots, spline = self._spline(table)
        return knots, spline(knots), spline(knots, 1)

    def _spline(self, table: np.ndarray) -> tuple[np.ndarray, CubicSpline]:
        """Knots, and the spline of `table` (nω, 2M + 1, n) with its value at ω = 0."""
        from scipy.interpolate import CubicSpline

        knots = np.concatenate([[0.0], self.omega])
        stiffness = self.hydrostatic_stiffness.reshape(-1, len(self.bodies), self.per_body)
        first = np.zeros((1, *table.shape[1:]), dtype=complex)
        if "froude_krylov" in self.excited_by:
            first[0, table.shape[1] // 2] = stiffness[:, :, self.heave].sum(axis=1)
        return knots, CubicSpline(knots, np.concatenate([first, table]), axis=0)

    def way(self, omega: np.ndarray, direction: float) -> np.ndarray:
        """e^{i k (x_G cos β + y_G sin β)} of each motion's body, (k, n) [1].

        `omega` (k,) [rad/s], `direction` β [deg].
        """
        from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber

        k = wavenumber(np.asarray(omega), depth=self.depth, gravity=self.gravity)[:, None]
        x, y, _ = np.repeat(self.places, self.per_body, axis=0).T
        beta = np.radians(direction)
        return np.exp(1j * (np.cos(beta) * k * x + np.sin(beta) * k * y))
