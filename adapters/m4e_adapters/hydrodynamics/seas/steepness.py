"""Waves that break, and seas that are too steep: allowed, and seldom meant.

A wave breaks above 0.142 λ tanh kh (R. Miche, "Mouvements ondulatoires de la mer en profondeur
constante ou décroissante", Annales des Ponts et Chaussées 114, 1944), and above 0.78 h, which is
where a solitary wave does. A sea is too steep where 2π Hs/(g Tp²) is above 1/15 for Tp ≤ 8 s, above
1/25 for Tp ≥ 15 s, or above what is linear between: the steepness criteria of DNV-RP-C205,
"Environmental conditions and environmental loads".
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber

STEEPEST, OF_DEPTH = 0.142, 0.78  # heights that break, over wavelength and over depth
PERIODS, STEEPNESSES = (8.0, 15.0), (1 / 15, 1 / 25)  # [s] of the peak, and limits there


def breaking_heights(omega: np.ndarray, *, depth: float, gravity: float) -> np.ndarray:
    """Heights (k,) [m] above which regular waves of `omega` (k,) [rad/s] break."""
    k = wavenumber(omega, depth=depth, gravity=gravity)
    return np.minimum(STEEPEST * 2 * math.pi / k * np.tanh(k * depth), OF_DEPTH * depth)


def wave_doubts(
    height: float, period: float, *, depth: float, gravity: float, regular: bool
) -> Iterator[str]:
    """Lines on a wave of `height` [m] and `period` [s], or on the sea of these at its peak."""
    omega = np.array([2 * math.pi / period])
    breaking = float(breaking_heights(omega, depth=depth, gravity=gravity)[0])
    noun, of = ("wave height", "") if regular else ("significant wave height", "peak ")
    if height > breaking:
        water = "deep water" if math.isinf(depth) else f"{depth:g} m of water"
        yield (
            f"the {noun} of {height:.4g} m is above {breaking:.3g} m, at which waves of a "
            f"{of}period of {period:.4g} s break in {water}: no such sea exists: make it lower or "
            "longer"
        )
    steepness = 2 * math.pi * height / (gravity * period**2)
    limit = float(np.interp(period, PERIODS, STEEPNESSES))
    if not regular and steepness > limit and height <= breaking:
        yield (
            f"the sea is too steep: 2 pi Hs/(g Tp^2) is {steepness:.3g} (Hs {height:.4g} m, Tp "
            f"{period:.4g} s), seas have up to {limit:.3g} at this period (DNV-RP-C205): make it "
            "lower or longer"
        )
