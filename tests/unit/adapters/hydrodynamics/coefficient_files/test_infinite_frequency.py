"""Ogilvie's relation beside quadrature of the same damping, with the pole taken out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from m4e_adapters.hydrodynamics.coefficient_files.consistency import USED, ogilvie


@pytest.mark.parametrize("steps", [np.full(30, 0.1), np.linspace(0.05, 0.2, 24)])
def test_added_mass_at_infinite_frequency(steps: np.ndarray) -> None:
    """PV ∫₀^∞ du/(ω² − u²) = 0: with B(u) − B(ω) above, the integral has no pole any more."""
    omega = np.cumsum(steps)
    added_mass, damping = 3.0 - np.exp(-omega), omega**2 * np.exp(-2 * omega)
    end = omega[-1]

    def b(u: float) -> float:
        inside = np.interp(u, [0.0, *omega], [0.0, *damping])
        return float(inside if u <= end else damping[-1] * (end / u) ** 3)

    def at_infinity(k: int) -> float:
        w, ends = omega[k], [0.0, *omega, np.inf]
        parts = (
            quad(lambda u: (b(u) - damping[k]) / (w**2 - u**2), low, high, epsabs=1e-11)[0]
            for low, high in pairwise(ends)
        )
        return added_mass[k] + 2 / np.pi * sum(parts)

    chosen = [k for k, w in enumerate(omega) if USED[0] * end <= w <= USED[1] * end]
    expected = np.quantile([at_infinity(k) for k in chosen], [0.1, 0.5, 0.9])
    found, spread = ogilvie(omega, added_mass[:, None], damping[:, None])
    np.testing.assert_allclose(found, expected[1], rtol=1e-8)
    np.testing.assert_allclose(spread, (expected[2] - expected[0]) / 2, rtol=1e-6)
