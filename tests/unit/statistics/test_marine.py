"""Power of waves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from m4e_fmi.statistics.marine import wave_power


@pytest.mark.parametrize(("depth", "period"), [(10.0, 14.0), (40.0, 10.0), (40.0, 14.0)])
def test_power_of_waves_in_water_that_is_not_deep(depth: float, period: float) -> None:
    """Beside ρ g ∫S c_g dω of a Bretschneider spectrum, whose dispersion is solved by brentq."""
    g, omega = 9.81, np.linspace(0.15, 6.0, 2000)
    k = np.array(
        [brentq(lambda k, w=w: g * k * np.tanh(k * depth) - w**2, 1e-6, 10.0) for w in omega]
    )
    twice = 2.0 * k * depth
    group = 0.5 * omega / k * (1.0 + twice / np.sinh(twice))
    density = omega**-5.0 * np.exp(-1.25 * (2.0 * np.pi / period / omega) ** 4)
    m0 = np.trapezoid(density, omega)
    energy_period = 2.0 * np.pi * np.trapezoid(density / omega, omega) / m0
    exact = 1025.0 * g * np.trapezoid(density * group, omega)
    height = 4.0 * np.sqrt(m0)
    assert float(wave_power(height, energy_period, depth=depth)) == pytest.approx(exact, rel=0.06)
    assert abs(float(wave_power(height, energy_period)) / exact - 1.0) > 0.09
    # one frequency: exactly its group velocity
    one = wave_power(4.0, 2.0 * np.pi / omega[::100], depth=depth)
    assert one == pytest.approx(1025.0 * g * group[::100], rel=1e-10)
    # 2 m and 8 s in deep water: 1025·9.81²·4·8/(64π)
    assert float(wave_power(2.0, 8.0)) == pytest.approx(15699.0, rel=1e-4)
    assert float(wave_power(2.0, 8.0, depth=1e5)) == pytest.approx(float(wave_power(2.0, 8.0)))
