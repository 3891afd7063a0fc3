"""Dispersion, spectra, components."""

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Jonswap
from m4e_adapters.hydrodynamics.sea import PERIODS
from m4e_adapters.hydrodynamics.waves import (
    BAND,
    LOGARITHMIC,
    angular_frequency,
    component_amplitudes,
    component_frequencies,
    component_phases,
    part_edges,
    relative_spectrum,
    wavenumber,
)


def generator(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


@pytest.mark.parametrize("depth", [0.5, 10.0, 50.0, 5000.0, math.inf])
def test_dispersion_is_solved_to_rounding(depth: float) -> None:
    omega = np.concatenate([[0.0], np.geomspace(1e-4, 20.0, 400)])
    k = wavenumber(omega, depth=depth, gravity=9.81)
    back = angular_frequency(k, depth=depth, gravity=9.81)
    np.testing.assert_allclose(back, omega, rtol=1e-13, atol=1e-300)


def test_long_waves_travel_at_the_speed_of_shallow_water() -> None:
    omega = np.array([1e-4])
    k = wavenumber(omega, depth=10.0, gravity=9.81)
    # relative deviation (k h)²/6, k h = 1e-4
    assert (omega / k)[0] == pytest.approx(math.sqrt(9.81 * 10.0), rel=1e-8)


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


def moments(enhancement: float, peak_omega: float) -> tuple[np.ndarray, float]:
    """(m0, m1, m2) and ∫ S² dω of the whole spectrum, Hs = 1 m, by fine quadrature to 1,000 ω_p;
    beyond, S = m0 c ω⁻⁵ leaves 5e-7 of m2."""
    ratio = np.geomspace(0.3, 1000.0, 20_001)
    form = np.array([relative_spectrum(r, enhancement) for r in ratio.tolist()])
    density = form / np.trapezoid(form, ratio) / peak_omega / 16.0
    omega = ratio * peak_omega
    found = np.array([np.trapezoid(omega**k * density, omega) for k in (0, 1, 2)])
    return found, float(np.trapezoid(density**2, omega))


def seas(
    seeds: int,
    *,
    enhancement: float = 3.3,
    made_for: float = 7.5,
    peak_period: float = 7.5,
    count: int = Jonswap.model_fields["components"].default,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each seed, Hs = 1 m: m0, m1, m2 of the components, and m0 and m2 of a record of 600 s.

    m2 of the record is the variance of the rate, exact for each component. The elevation at 15 i
    + j/4 seconds is Re Σ_k (a_k e^{i(15 ω_k i + φ_k)}) e^{i ω_k j/4}: a product of matrices.
    """
    edges = part_edges(2 * math.pi / made_for, count, enhancement=enhancement)
    sums, heights, rates = [], [], []
    for seed in range(seeds):
        rng = generator(seed)
        omega = component_frequencies(edges, rng)
        phases = component_phases(count, rng)
        amplitudes = np.array(
            component_amplitudes(
                omega.tolist(),
                np.diff(edges).tolist(),
                significant_height=1.0,
                peak_period=peak_period,
                enhancement=enhancement,
            )
        )
        coarse = np.exp(1j * (np.outer(15.0 * np.arange(40), omega) + phases))
        fine = np.exp(1j * np.outer(omega, 0.25 * np.arange(60)))
        sums.append([0.5 * np.sum(amplitudes**2 * omega**k) for k in (0, 1, 2)])
        heights.append(np.real((amplitudes * coarse) @ fine).var())
        rates.append(np.imag((omega * amplitudes * coarse) @ fine).var())
    return np.array(sums), np.array(heights), np.array(rates)


@pytest.mark.parametrize("factor", PERIODS)
def test_a_sea_of_another_peak_period_keeps_its_statistics(factor: float) -> None:
    """At the limits of the parameter: mean periods within 1 %, the scatter within 35 %."""
    (m0, m1, m2), square = moments(3.3, 2 * math.pi / (7.5 * factor))
    sums, heights, _ = seas(40, peak_period=7.5 * factor)
    first, second = sums[:, 0] / sums[:, 1], np.sqrt(sums[:, 0] / sums[:, 2])
    assert first == pytest.approx(m0 / m1, rel=0.01)
    assert second == pytest.approx(math.sqrt(m0 / m2), rel=0.01)
    scatter = 2 * math.sqrt(2 * math.pi / 600.0 * square) / math.sqrt(m0)
    assert (4 * np.sqrt(heights)).std(ddof=1) == pytest.approx(scatter, rel=0.35)


@pytest.mark.verifies(
    "irregular seas: mean height and periods over 100 seeds of 10 minutes",
    analytic="moments of the whole JONSWAP spectrum",
    tolerance="1 %",
)
@pytest.mark.verifies(
    "irregular seas: scatter of the height of 10 minutes between seeds",
    analytic="variance of the variance of a Gaussian process",
    tolerance="25 %",
)
def test_statistics_of_ten_minutes_are_those_of_the_whole_spectrum() -> None:
    """A Gaussian process of the covariance R(τ) = ∫ S cos ωτ dω has, over T, the variance
    estimate's variance (2/T) ∫ R² dτ over all τ, and by Parseval's theorem ∫ R² dτ = π ∫ S² dω:
    σ²(m0) = (2π/T) ∫ S² dω. Hs = 4 √m0 scatters by 2 σ(m0)/√m0, 7 % here: the mean
    of 40 seeds is only known to 1.1 %, that of 100 to 0.7 %."""
    (m0, m1, m2), square = moments(3.3, 2 * math.pi / 7.5)
    sums, heights, rates = seas(100)
    assert (4 * np.sqrt(heights)).mean() == pytest.approx(1.0, rel=0.01)
    assert (2 * np.pi * sums[:, 0] / sums[:, 1]).mean() == pytest.approx(
        2 * math.pi * m0 / m1, rel=0.01
    )
    whole = 2 * math.pi * math.sqrt(m0 / m2)
    assert 2 * math.pi * math.sqrt(heights.mean() / rates.mean()) == pytest.approx(whole, rel=0.01)
    scatter = 2 * math.sqrt(2 * math.pi / 600.0 * square) / math.sqrt(m0)
    assert (4 * np.sqrt(heights)).std(ddof=1) == pytest.approx(scatter, rel=0.25)
