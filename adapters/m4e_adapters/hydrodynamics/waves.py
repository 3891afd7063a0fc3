"""Linear long-crested waves: dispersion, spectra, components of a sea.

The elevation is a sum of components, η(x, t) = Σ a_k cos(ω_k t − k_k x cos β + φ_k), β = 0 or
180 deg. Spectra are those of Hasselmann et al. (1973, JONSWAP) and Bretschneider's two-parameter
form of Pierson and Moskowitz; the amplitudes are scaled so that Σ a_k²/2 = Hs²/16 holds exactly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from m4e_fmi.program import exp, log, sign, sqrt

BAND = (0.5, 3.5)  # of the components, in peak frequencies: 99 % of the energy and all of the peak


def angular_frequency(wavenumber: Any, *, depth: float, gravity: float) -> Any:
    """ω [rad/s] of waves of `wavenumber` [rad/m]: ω² = g k tanh(k h)."""
    k = np.asarray(wavenumber, dtype=float)
    return np.sqrt(gravity * k * np.tanh(k * depth if math.isfinite(depth) else np.inf))


def wavenumber(omega: np.ndarray, *, depth: float, gravity: float) -> np.ndarray:
    """k [rad/m] of waves of `omega` [rad/s] ≥ 0: the root of ω² = g k tanh(k h).

    Newton's method on y tanh y = ω² h/g, y = k h, from a start that is close in deep and in
    shallow water alike; it converges from above, quadratically.
    """
    omega = np.asarray(omega, dtype=float)
    deep = omega**2 / gravity
    if math.isinf(depth):
        return deep
    target = deep * depth
    y = np.maximum(np.sqrt(target), target)
    for _ in range(12):
        slope = np.tanh(y) + y / np.cosh(np.minimum(y, 300.0)) ** 2
        y = y - np.where(target > 0, (y * np.tanh(y) - target) / np.where(slope > 0, slope, 1), 0)
    return y / depth


def component_frequencies(peak_omega: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """`count` angular frequencies [rad/s], one at random in each of equal parts of BAND.

    Because their differences have no common divisor the sea does not repeat itself.
    """
    low, high = (factor * peak_omega for factor in BAND)
    return low + (high - low) / count * (np.arange(count) + rng.random(count))


def component_phases(count: int, rng: np.random.Generator) -> np.ndarray:
    """`count` phases [rad], uniform in [0, 2π)."""
    return rng.uniform(0.0, 2 * math.pi, count)


def relative_spectrum(ratio: Any, enhancement: Any) -> Any:
    """JONSWAP's form at ω/ω_p = `ratio`, peak enhancement γ (1: Pierson-Moskowitz), any scale.

    r⁻⁵ exp(−1.25 r⁻⁴) γ^exp(−(r − 1)²/(2 σ²)), σ = 0.07 below the peak, 0.09 above it.
    """
    width = 0.08 + 0.01 * sign(ratio - 1.0)
    peak = exp(-0.5 * ((ratio - 1.0) / width) ** 2)
    return exp(-1.25 / ratio**4 + log(enhancement) * peak) / ratio**5


def component_amplitudes(
    omega: Sequence[float], *, significant_height: Any, peak_period: Any, enhancement: Any
) -> list[Any]:
    """Amplitudes [m] of components of equal bandwidth, Σ a²/2 = `significant_height`²/16.

    Heights in m, periods in s; over any scalar of `m4e_fmi.program`.
    """
    weights = [
        relative_spectrum(w * peak_period * (0.5 / math.pi), enhancement) for w in map(float, omega)
    ]
    total = weights[0]
    for weight in weights[1:]:
        total = total + weight
    scale = significant_height / sqrt(8.0 * total)
    return [scale * sqrt(weight) for weight in weights]
