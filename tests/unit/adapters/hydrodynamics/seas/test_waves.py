"""Dispersion, spectra, components."""

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency, wavenumber
from m4e_adapters.hydrodynamics.seas.waves import (
    BAND,
    LOGARITHMIC,
    component_amplitudes,
    component_frequencies,
    component_phases,
    part_edges,
    relative_spectrum,
)


def generator(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


@pytest.mark.parametrize("depth", [0.5, 10.0, 50.0, 5000.0, math.inf])
def test_dispersion_is_solved_to_rounding(depth: float) -> None:
    omega = np.concatenate([[0.0], np.geomspace(1e-4, 20.0, 400)])
    k = wavenumber(omega, depth=depth, gravity=9.81)
    back = angular_frequency(k, depth=depth, gravity=9.81)
    np.testing.assert_allclose(back, omega, rtol=1e-13, atol=1e-300)


def test_pierson_moskowitz_integrates_to_its_closed_form() -> None:
    # ∫ r⁻⁵ exp(−1.25 r⁻⁴) dr = 1/5
    ratio = np.linspace(0.2, 60.0, 400_001)
    values = ratio**-5 * np.exp(-1.25 * ratio**-4)
    ours = [relative_spectrum(float(r), 1.0) for r in ratio[::1000]]
    np.testing.assert_allclose(ours, values[::1000], rtol=1e-13)
    tail = 60.0**-4 / 4
    assert np.trapezoid(values, ratio) + tail == pytest.approx(0.2, rel=1e-6)


def test_jonswap_peak_and_widths() -> None:
    assert relative_spectrum(1.0, 3.3) == pytest.approx(3.3 * math.exp(-1.25), rel=1e-14)
    for ratio, width in ((0.9, 0.07), (1.1, 0.09)):
        enhanced = relative_spectrum(ratio, 3.3) / relative_spectrum(ratio, 1.0)
        expected = 3.3 ** math.exp(-((ratio - 1) ** 2) / (2 * width**2))
        assert enhanced == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("enhancement", [1.0, 3.3])
def test_variance_is_exactly_that_of_the_significant_height(enhancement: float) -> None:
    edges = part_edges(0.9, 80, enhancement=enhancement)
    omega = component_frequencies(edges, generator(7))
    amplitudes = component_amplitudes(
        omega.tolist(),
        np.diff(edges).tolist(),
        significant_height=2.5,
        peak_period=7.0,
        enhancement=enhancement,
    )
    assert sum(a * a for a in amplitudes) / 2 == pytest.approx(2.5**2 / 16, rel=1e-13)


def test_components_are_of_the_seed_and_spread_over_the_band() -> None:
    edges = part_edges(0.9, 50)
    assert edges[[0, -1]] == pytest.approx(0.9 * np.array(BAND), rel=1e-14)
    first = component_frequencies(edges, generator(3))
    np.testing.assert_array_equal(first, component_frequencies(edges, generator(3)))
    assert not np.array_equal(first, component_frequencies(edges, generator(4)))
    assert np.all((edges[:-1] <= first) & (first <= edges[1:]))
    phases = component_phases(1000, generator(3))
    assert phases.min() >= 0.0
    assert phases.max() < 2 * math.pi
    # mean of 1000 uniform values: π ± 2π/√(12·1000); five of these
    assert phases.mean() == pytest.approx(math.pi, abs=5 * 2 * math.pi / math.sqrt(12_000))


def test_the_same_numbers_everywhere() -> None:
    """PCG64 is specified: these must not change with platform or version."""
    omega = component_frequencies(np.linspace(0.5, 3.5, 11), generator(1))
    np.testing.assert_allclose(omega[:2], [0.65354649, 1.08513911], rtol=1e-8)


@pytest.mark.parametrize("enhancement", [1.0, 3.3])
def test_parts_have_equal_energy_and_grow_in_the_tail(enhancement: float) -> None:
    """Up to twice the peak frequency the energy of no part is above its equal share; from four
    times on parts are equal steps of log ω."""
    count = 200
    edges = part_edges(1.0, count, enhancement=enhancement)
    fine = np.geomspace(*BAND, 20_001)
    spectrum = np.array([relative_spectrum(r, enhancement) for r in fine.tolist()])
    energy = np.concatenate([[0.0], np.cumsum(np.diff(fine) * spectrum[1:])])
    parts = np.diff(np.interp(edges, fine, energy / energy[-1]))
    assert parts.max() < 1.01 / (1 - LOGARITHMIC) / count
    step = np.log(BAND[1] / BAND[0]) / (LOGARITHMIC * count)
    tail = edges > 6.0
    assert np.diff(np.log(edges[tail])) == pytest.approx(step, rel=0.05)
