"""Spectra and extremes of Gaussian seas against theory, within the scatter of so many seeds."""

from __future__ import annotations

import numpy as np
import pytest
from support.gaussian_sea import density, seas

from m4e_fmi.errors import InputError
from m4e_fmi.statistics import (
    STATISTICS,
    gaussian_extreme,
    gumbel_extreme,
    spectrum,
    weibull_extreme,
)

SEEDS, ROWS, STEP = 200, 14400, 0.25
HEIGHT, PEAK = 4.0, 10.0
TIME = STEP * np.arange(ROWS)
HOUR = 3600.0
BOUND = 3.5
"""Standard errors within which a mean of seeds is found, but once in 2000 tests."""


@pytest.fixture(scope="module")
def sea() -> np.ndarray:
    return seas(SEEDS, ROWS, STEP, height=HEIGHT, peak_period=PEAK)


def error(values: np.ndarray) -> float:
    return float(np.std(values, ddof=1)) / np.sqrt(len(values))


@pytest.mark.parametrize("length", [np.nan, np.inf])
def test_segments_of_no_length_are_wrong_input(length: float) -> None:
    with pytest.raises(InputError, match="expected a finite length"):
        spectrum(TIME, np.sin(TIME), segment=length)


def test_the_integral_of_a_spectrum_is_the_variance(sea: np.ndarray) -> None:
    for run in sea[:5]:
        found = spectrum(TIME, run)
        assert np.trapezoid(found.density, found.omega) == pytest.approx(np.var(run), rel=1e-12)
        assert found.scale == pytest.approx(1.0, abs=0.1)


def test_significant_height_within_its_sampling_error(sea: np.ndarray) -> None:
    """The mean over seeds, and the scatter that `variance_error` says for one record."""
    found = [spectrum(TIME, run) for run in sea]
    variances = np.array([one.moment(0) for one in found])
    assert np.mean(variances) == pytest.approx(HEIGHT**2 / 16.0, abs=BOUND * error(variances))
    scatter = np.std(variances, ddof=1) / np.mean(variances)
    said = np.mean([one.variance_error for one in found])
    assert said == pytest.approx(scatter, rel=BOUND / np.sqrt(2.0 * SEEDS))
    heights = STATISTICS["spectral_significant_height"].compute(TIME, sea)
    assert heights == pytest.approx(4.0 * np.sqrt(variances))


def test_density_and_degrees_of_freedom(sea: np.ndarray) -> None:
    """Where the density is high: its mean over seeds, and its scatter √(2/ν) of one record."""
    found = [spectrum(TIME, run) for run in sea]
    omega = found[0].omega
    high = (omega > 0.55) & (omega < 1.5)
    values = np.stack([one.density for one in found])[:, high]
    exact = density(omega[high], HEIGHT, PEAK)
    bound = 4.5 * np.std(values, axis=0, ddof=1) / np.sqrt(SEEDS)  # of 200 values
    assert np.all(np.abs(values.mean(axis=0) - exact) < bound + 0.01 * exact.max())
    ratio = np.var(values, axis=0, ddof=1) / values.mean(axis=0) ** 2
    assert np.mean(ratio) == pytest.approx(2.0 / found[0].degrees_of_freedom, rel=0.05)


def test_periods_of_a_narrow_spectrum() -> None:
    """Of a sine all periods are its own: within the resolution of the window, 2π/segment."""
    omega = 2.0 * np.pi / 9.0
    run = 3.0 + 2.0 * np.sin(omega * TIME)
    found = spectrum(TIME, run)
    assert found.significant_height == pytest.approx(4.0 * np.sqrt(2.0), rel=1e-3)
    for period in (found.mean_period, found.zero_crossing_period, found.peak_period):
        assert period == pytest.approx(9.0, rel=9.0 / 900.0)
    assert found.bandwidth < 0.05
    assert STATISTICS["zero_crossing_period"].compute(TIME, run) == pytest.approx([9.0], rel=1e-4)
    assert STATISTICS["number_of_cycles"].compute(TIME, run).tolist() == [399.0]
    heights = STATISTICS["significant_height"].compute(TIME, run)
    assert heights == pytest.approx([4.0], rel=0.004)  # (ω h)²/8, of a crest between two rows


def test_moments_of_the_sea(sea: np.ndarray) -> None:
    """Bretschneider's m₁ and m₂, of which 0.3 % are above the Nyquist frequency, 12.6 rad/s."""
    peak = 2.0 * np.pi / PEAK
    m0 = HEIGHT**2 / 16.0
    exact = {1: m0 * 1.25**0.25 * peak * 1.2254167, 2: m0 * np.sqrt(1.25 * np.pi) * peak**2}
    for order, value in exact.items():
        found = STATISTICS[f"spectral_moment_{order}"].compute(TIME, sea)
        assert np.mean(found) == pytest.approx(value, abs=BOUND * error(found) + 0.01 * value)


def test_fits_of_tail_and_parts_agree_with_the_gaussian(sea: np.ndarray) -> None:
    modes = STATISTICS["most_probable_maximum"].compute(TIME, sea[:100], duration=HOUR)
    gaussian = float(np.mean(modes))
    for model, name in ((weibull_extreme, "weibull_maximum"), (gumbel_extreme, "gumbel_maximum")):
        found = [model(TIME, run, HOUR) for run in sea[:100]]
        values = np.array([one.most_probable for one in found])
        assert np.mean(values) == pytest.approx(
            gaussian, abs=BOUND * error(values) + 0.015 * gaussian
        )
        said = np.mean([one.error for one in found])
        assert said == pytest.approx(np.std(values, ddof=1), rel=BOUND / np.sqrt(200) + 0.1)
        assert STATISTICS[name].compute(TIME, sea[:3], duration=HOUR) == pytest.approx(values[:3])
        assert all(o.most_probable < o.expected < o.quantile(0.9) for o in found)


def test_a_tail_that_is_not_gaussian_is_seen() -> None:
    """Crests of a cubed sea: of the sea's Rayleigh, a Weibull with the shape 2/3."""
    run = seas(1, ROWS, STEP, height=HEIGHT, peak_period=PEAK, first=7)[0]
    largest = gaussian_extreme(TIME, run, 3.0 * HOUR).most_probable
    found = weibull_extreme(TIME, run**3, 3.0 * HOUR)
    assert found.most_probable == pytest.approx(largest**3, abs=3.0 * found.error)
    assert gaussian_extreme(TIME, run**3, 3.0 * HOUR).most_probable < 0.5 * largest**3


def test_records_without_a_spectrum_or_extremes_are_refused() -> None:
    few = TIME[:10]
    with pytest.raises(InputError, match="constant"):
        spectrum(TIME, np.full(ROWS, 2.0))
    with pytest.raises(InputError, match="15 are needed"):
        spectrum(few, np.sin(few))
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.1, 1.0, 500))
    with pytest.raises(InputError, match="time steps differ"):
        spectrum(uneven, np.sin(uneven))
    with pytest.raises(InputError, match="not finite"):
        gaussian_extreme(few, [*few[:9], np.nan], HOUR)
    with pytest.raises(InputError, match="too few for an extreme"):
        gaussian_extreme(TIME, np.sin(TIME), 10.0)
    with pytest.raises(InputError, match="positive duration"):
        gumbel_extreme(TIME, np.sin(TIME), -1.0)
    with pytest.raises(InputError, match="complete cycles"):
        weibull_extreme(TIME[:200], np.sin(TIME[:200]), HOUR)
    with pytest.raises(InputError, match="between 0 and 1"):
        gaussian_extreme(TIME, np.sin(TIME), HOUR).quantile(1.0)


def test_rows_of_events_between_do_no_harm() -> None:
    run = np.sin(0.7 * TIME)
    more = np.sort(np.concatenate([TIME, [100.01, 100.1, 2000.03], TIME[[50, 50, 60]]]))
    found, plain = spectrum(more, np.sin(0.7 * more)), spectrum(TIME, run)
    assert found.density == pytest.approx(plain.density, abs=1e-9 * plain.density.max())


def test_equal_crests_have_no_weibull_distribution() -> None:
    """Of a sine, or of a response that stops cut off."""
    time = np.linspace(0.0, 600.0, 6001)
    for record in (np.sin(2.0 * np.pi * time / 10.0), np.sign(np.sin(time))):
        (reason,) = STATISTICS["weibull_maximum"].explained(time, record, duration=1e4).reasons
        assert "highest half of the crests are all" in reason


def test_the_number_of_parts_is_whole() -> None:
    (problem,) = STATISTICS["gumbel_maximum"].problems({"duration": 1e4, "blocks": 9.5})
    assert "blocks is 9.5, expected a whole number" in problem.message
