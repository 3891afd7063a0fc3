"""Confidence intervals over seeds; annual energy, power of waves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from m4e_fmi.errors import InputError
from m4e_fmi.statistics import confidence_interval
from m4e_fmi.statistics.marine import (
    YEAR,
    annual_energy,
    wave_power,
)

RNG = np.random.default_rng(5)


def test_one_seed_and_missing_values_have_no_interval() -> None:
    found = confidence_interval([[2.0], [3.0]])
    assert found.mean.tolist() == [2.0, 3.0]
    assert np.isnan([found.low, found.high, found.error]).all()
    assert np.isnan(confidence_interval([1.0, np.nan, 2.0]).mean)
    for values, level in (([], 0.95), (1.0, 0.95), ([1.0, 2.0], 95.0), ([1.0], np.nan)):
        with pytest.raises(InputError):
            confidence_interval(values, level)


def test_annual_energy_and_its_error() -> None:
    power = np.array([[1e5, 1.2e5], [2e5, 2.4e5], [9e9, np.nan]])
    found = annual_energy(power, [0.5, 0.3, 0.0])
    assert found.energy == pytest.approx(YEAR * (0.5 * 1.1e5 + 0.3 * 2.2e5))
    assert found.megawatt_hours == pytest.approx(8766.0 * 0.121)
    assert found.error == pytest.approx(YEAR * np.hypot(0.5 * 1e4, 0.3 * 2e4))
    assert found.covered == pytest.approx(0.8)
    shared = annual_energy(power, [0.5, 0.3, 0.0], shared_seeds=True)
    assert shared.error == pytest.approx(YEAR * (0.5 * 1e4 + 0.3 * 2e4))
    assert np.isnan(annual_energy(power, [0.5, 0.3, 0.1]).energy)
    assert np.isnan(annual_energy(power[:2, :1], [0.5, 0.3]).error)


def test_the_error_of_annual_energy_is_its_scatter() -> None:
    """Of 1000 studies of 6 sea states with 4 seeds."""
    p, size = np.array([0.1, 0.2, 0.3, 0.2, 0.1, 0.1]), np.array([1.0, 2.0, 4.0, 7.0, 9.0, 12.0])
    power = size[:, None] * (1.0 + 0.1 * RNG.standard_normal((1000, 6, 4)))
    found = [annual_energy(one, p) for one in power]
    scatter = np.std([one.energy for one in found])
    said = np.sqrt(np.mean([one.error**2 for one in found]))
    assert said == pytest.approx(scatter, rel=3.5 / np.sqrt(2000) + 0.02)


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
