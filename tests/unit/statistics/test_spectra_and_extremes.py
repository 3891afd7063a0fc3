"""Spectra and extremes of Gaussian seas against theory, within the scatter of so many seeds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.gaussian_sea import density, seas

from m4e_fmi.errors import InputError
from m4e_fmi.statistics import STATISTICS, spectrum

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


def test_the_integral_of_a_spectrum_is_the_variance(sea: np.ndarray) -> None:
    for run in sea[:5]:
        found = spectrum(TIME, run)
        assert np.trapezoid(found.density, found.omega) == pytest.approx(np.var(run), rel=1e-12)
        assert found.scale == pytest.approx(1.0, abs=0.1)


def test_significant_height_within_its_sampling_error(sea: np.ndarray) -> None:
    """The mean over seeds."""
    found = [spectrum(TIME, run) for run in sea]
    variances = np.array([one.moment(0) for one in found])
    assert np.mean(variances) == pytest.approx(HEIGHT**2 / 16.0, abs=BOUND * error(variances))
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
    assert STATISTICS["zero_crossing_period"].compute(TIME, run) == pytest.approx([9.0], rel=1e-4)
    assert STATISTICS["number_of_cycles"].compute(TIME, run).tolist() == [399.0]
    heights = STATISTICS["significant_height"].compute(TIME, run)
    assert heights == pytest.approx([4.0], rel=0.004)  # (ω h)²/8, of a crest between two rows


FEW, SINE = TIME[:10], np.sin(TIME)
UNEVEN = np.cumsum(np.random.default_rng(0).uniform(0.1, 1.0, 500))
REFUSED: list[tuple[Callable[[], Any], str]] = [
    (lambda: spectrum(TIME, np.full(ROWS, 2.0)), "constant"),
    (lambda: spectrum(FEW, np.sin(FEW)), "15 are needed"),
    (lambda: spectrum(UNEVEN, np.sin(UNEVEN)), "time steps differ"),
    (lambda: spectrum(TIME, SINE, segment=np.nan), "expected a finite length"),
]


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_records_without_a_spectrum_or_extremes(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()
