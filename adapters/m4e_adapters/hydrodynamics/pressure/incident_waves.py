"""Elevation and pressure of linear waves, stretched to the instantaneous surface.

η = Σ r(t) a cos θ, θ = ω t − k (x cos β + y sin β) + φ, with ramps r = ½(1 − cos π t/T) until T.
Wheeler's stretching takes the pressure at z from z' = (z − η) d/(d + η), d the depth: it is that of
the undisturbed surface on the instantaneous one, where with the hydrostatic part it vanishes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np


class IncidentWaves:
    """Waves of n components: `omega` [rad/s], `wavenumber` [rad/m], `amplitude` [m], `phase` and
    `direction` [rad], `ramp_time` [s], (n,) each; the last may be 0. `depth` [m] may be inf.
    """

    def __init__(self, data: Mapping[str, Sequence[float] | float]) -> None:
        names = ("omega", "wavenumber", "amplitude", "phase", "direction")
        self._omega, k, self._amplitude, self._phase, direction = (np.array(data[n]) for n in names)
        self._k, self._vectors = k, np.stack([k * np.cos(direction), k * np.sin(direction)])
        self._depth = float(data["depth"])  # type: ignore[arg-type]
        self._ramp_time = np.array(data["ramp_time"])

    def _amplitudes(self, time: float) -> np.ndarray:
        """r a (n,) [m] at `time` [s]."""
        length = self._ramp_time
        grown = np.where(time < length, time / np.where(length > 0.0, length, 1.0), 1.0)
        return self._amplitude * (0.5 - 0.5 * np.cos(math.pi * grown))

    def elevation(self, points: np.ndarray, time: float) -> np.ndarray:
        """η (np,) [m] at `points` (np, 2) [m] or more columns, the first of which are x, y."""
        return self._cosines(points, time) @ self._amplitudes(time)

    def head(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Pressure head and elevation (np,) [m] at `points` (np, 3) [m].

        Above the surface the head is the height below it, which is negative.
        """
        cosines, amplitude = self._cosines(points, time), self._amplitudes(time)
        elevation = cosines @ amplitude
        head = elevation - points[:, 2]
        wet = np.flatnonzero(head > 0.0)
        level = -head[wet]
        if math.isfinite(self._depth):
            level = level * self._depth / (self._depth + elevation[wet])
        dynamic = (cosines[wet] * self._decay(level)) @ amplitude
        head[wet] = dynamic - points[wet, 2]
        return head, elevation

    def _cosines(self, points: np.ndarray, time: float) -> np.ndarray:
        """cos θ (np, n) at `points` (np, 2) [m] or more columns."""
        return np.cos(points[:, :2] @ self._vectors - (self._omega * time + self._phase))

    def _decay(self, level: np.ndarray) -> np.ndarray:
        """cosh k(z' + d)/cosh k d (np, n) at `level` z' (np,) [m], which is not above 0."""
        falling = np.exp(np.multiply.outer(level, self._k))
        if math.isinf(self._depth):
            return falling
        rising = np.exp(np.multiply.outer(-(level + 2.0 * self._depth), self._k))
        return (falling + rising) / (1.0 + np.exp(-2.0 * self._k * self._depth))
