"""Linear (Airy) waves as a sum of components: dispersion, elevation, velocity, pressure.

With θ_k = ω_k t − k_k (x cos β_k + y sin β_k) + φ_k and the still-water level z = 0, the sea bed
z = −h:

    η = Σ a cos θ                                 p = ρ g Σ a cosh k(z + h)/cosh kh cos θ
    u = Σ a ω cosh k(z + h)/sinh kh cos θ         along β
    w = −Σ a ω sinh k(z + h)/sinh kh sin θ        upwards

p is the dynamic pressure, without −ρ g z. Accelerations are local: ∂/∂t at a fixed place.
Travels inside FMUs: imports numpy only.

Linear theory ends at z = 0. "wheeler" (J. D. Wheeler, "Method for calculating forces produced by
irregular waves", Journal of Petroleum Technology 22, 1970) evaluates the profiles at
h (z − η)/(h + η), which is 0 at the surface and −h at the bed; so −ρ g z + p is 0 at the surface.
"linear" leaves them as they are below z = 0, and above it continues those of velocity and
acceleration along their tangents, that of the pressure constant. Above the surface there is no
water: values there are those at the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

Stretching = Literal["wheeler", "linear"]
STEPS = 12  # of Newton's method for wavenumbers, which ends at rounding for every depth


def angular_frequency(wavenumber: ArrayLike, *, depth: float, gravity: float) -> np.ndarray:
    """ω (n,) or scalar [rad/s] of `wavenumber` (n,) or scalar [rad/m]: ω² = g k tanh(k h)."""
    k = np.asarray(wavenumber, dtype=float)
    return np.sqrt(gravity * k * np.tanh(k * depth if math.isfinite(depth) else np.inf))


def wavenumber(omega: np.ndarray, *, depth: float, gravity: float) -> np.ndarray:
    """k (n,) [rad/m] of waves of `omega` (n,) or scalar [rad/s] ≥ 0: root of ω² = g k tanh(k h).

    Newton's method on y tanh y = ω² h/g, y = k h, from a start that is close in deep and in
    shallow water alike; it converges from above, quadratically.
    """
    omega = np.asarray(omega, dtype=float)
    deep = omega**2 / gravity
    if math.isinf(depth):
        return deep
    target = deep * depth
    y = np.maximum(np.sqrt(target), target)
    for _ in range(STEPS):
        slope = np.tanh(y) + y / np.cosh(np.minimum(y, 300.0)) ** 2
        y = y - np.where(target > 0, (y * np.tanh(y) - target) / np.where(slope > 0, slope, 1), 0)
    return y / depth


@dataclass(frozen=True)
class Components:
    """Regular waves that make a sea, n of them, in water of `depth` [m] (inf: deep).

    `omega` [rad/s], `amplitude` [m], `phase` [rad] at x = y = 0 and t = 0, and `direction` [rad]
    that each travels to, from +X towards +Y, are (n,). `gravity` in m/s2.
    """

    omega: np.ndarray = field(repr=False)
    amplitude: np.ndarray = field(repr=False)
    phase: np.ndarray = field(repr=False)
    direction: np.ndarray = field(repr=False)
    depth: float = math.inf
    gravity: float = 9.81

    @cached_property
    def wavenumber(self) -> np.ndarray:
        """k (n,) [rad/m]."""
        return wavenumber(self.omega, depth=self.depth, gravity=self.gravity)

    def scaled(self, factor: np.ndarray) -> Components:
        """The same with amplitudes times `factor` (n,) [1]."""
        result = replace(self, amplitude=self.amplitude * factor)
        result.__dict__["wavenumber"] = self.wavenumber  # not to be solved for again
        return result

    def angles(self, t: ArrayLike, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """θ (..., n) [rad] at times `t` [s] and places `x`, `y` [m], each (...) or scalar."""
        t, x, y = (np.asarray(value, dtype=float)[..., None] for value in (t, x, y))
        way = x * np.cos(self.direction) + y * np.sin(self.direction)
        return self.omega * t + self.phase - self.wavenumber * way


def elevation(waves: Components, t: ArrayLike, x: ArrayLike, y: ArrayLike = 0.0) -> np.ndarray:
    """η (...) [m] at times `t` (...) [s] and places `x`, `y` (...) [m], each of them or scalar."""
    return np.cos(waves.angles(t, x, y)) @ waves.amplitude


@dataclass(frozen=True)
class Flow:
    """The water at places: `elevation` (...) [m] of the surface above or below them.

    `velocity` and local `acceleration` (..., 3) [m/s, m/s2], (x, y, z); `head` (...) [m] is the
    dynamic pressure over ρ g.
    """

    elevation: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    head: np.ndarray


def flow(
    waves: Components, t: ArrayLike, place: ArrayLike, *, stretching: Stretching = "wheeler"
) -> Flow:
    """The water at times `t` (...) [s] or scalar, at `place` (..., 3), (x, y, z) [m]."""
    x, y, z = np.moveaxis(np.asarray(place, dtype=float), -1, 0)
    angle = waves.angles(t, x, y)
    cosine, sine = np.cos(angle), np.sin(angle)
    surface = cosine @ waves.amplitude
    level, above = _levels(waves, z, surface, stretching)
    along, upwards, pressing = depth_profiles(waves.wavenumber, level, waves.depth)
    if np.any(above):
        rise = waves.wavenumber * above[..., None]
        along, upwards = along + rise * upwards, upwards + rise * along
    rate = waves.amplitude * waves.omega
    faster = rate * waves.omega
    c, s = np.cos(waves.direction), np.sin(waves.direction)
    forth, back, down, up = along * cosine, along * sine, upwards * sine, upwards * cosine
    u = [forth @ (rate * c), forth @ (rate * s), -(down @ rate)]
    a = [-(back @ (faster * c)), -(back @ (faster * s)), -(up @ faster)]
    head = (pressing * cosine) @ waves.amplitude
    return Flow(surface, np.stack(u, axis=-1), np.stack(a, axis=-1), head)


def _levels(
    waves: Components, z: np.ndarray, surface: np.ndarray, stretching: Stretching
) -> tuple[np.ndarray, np.ndarray]:
    """Level (...) [m] ≤ 0 at which profiles count, and how far their tangents reach above it."""
    if stretching == "wheeler":
        shrunk = 1.0 if math.isinf(waves.depth) else waves.depth / (waves.depth + surface)
        level = np.minimum((z - surface) * shrunk, 0.0)
        above = np.zeros_like(level)
    else:
        wet = np.minimum(z, np.maximum(surface, 0.0))
        level = np.minimum(wet, 0.0)
        above = wet - level
    return np.maximum(level, -waves.depth), above


def velocity_per_amplitude(
    omega: np.ndarray,
    directions: np.ndarray,
    place: tuple[float, float, float],
    *,
    depth: float,
    number: np.ndarray,
) -> np.ndarray:
    """Velocity (k, 3) [1/s] per amplitude of waves of `omega` (k,) [rad/s], for e^{−iωt}.

    They travel to `directions` (k,) [rad] and have the wavenumbers `number` (k,) [rad/m]. `place`
    (x, y, z) [m], which counts as at z = 0 if it is above.
    """
    x, y, z = place
    crest = np.exp(1j * number * (x * np.cos(directions) + y * np.sin(directions)))
    along, upwards, _ = depth_profiles(number, max(min(z, 0.0), -depth), depth)
    u, w = omega * along * crest, -1j * omega * upwards * crest
    return np.stack([u * np.cos(directions), u * np.sin(directions), w], axis=1)


def depth_profiles(
    wavenumber: np.ndarray, level: np.ndarray | float, depth: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """cosh k(z + h)/sinh kh, sinh k(z + h)/sinh kh and cosh k(z + h)/cosh kh, (..., n) [1].

    For `wavenumber` k (n,) [rad/m] at a `level` z ≤ 0 (...,) or scalar [m]; `depth` h [m].
    """
    bed = np.exp(-2.0 * wavenumber * depth)
    above = np.asarray(level)[..., None]
    up = np.exp(wavenumber * above)
    down = np.exp(-wavenumber * (above + 2.0 * depth))  # bed/up is 0/0 where short waves end
    return (up + down) / (1.0 - bed), (up - down) / (1.0 - bed), (up + down) / (1.0 + bed)
