"""Dispersion, spectra, components."""

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency, wavenumber
from m4e_adapters.hydrodynamics.seas.waves import (
    BAND,
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


def test_spectra() -> None:
    for ratio, width in ((0.6, 0.07), (0.9, 0.07), (1.1, 0.09), (3.0, 0.09)):
        plain = ratio**-5 * math.exp(-1.25 * ratio**-4)
        assert relative_spectrum(ratio, 1.0) == pytest.approx(plain, rel=1e-13)
        peak = 3.3 ** math.exp(-((ratio - 1) ** 2) / (2 * width**2))
        assert relative_spectrum(ratio, 3.3) == pytest.approx(plain * peak, rel=1e-13)
