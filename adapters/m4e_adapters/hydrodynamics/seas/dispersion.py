"""Wavenumbers and frequencies of linear waves: ω² = g k tanh(k h).

Travels inside FMUs: imports numpy only.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

STEPS = 12  # of Newton's method, which ends at rounding for every depth


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
