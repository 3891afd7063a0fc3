"""Statistics of records: cycles, extremes, confidence over seeds; phase of two records."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from support.gaussian_sea import seas

from m4e_fmi.analysis.comparison.measures import phase
from m4e_fmi.statistics import STATISTICS, confidence_interval
from m4e_fmi.statistics.cycles import cycles_of

ASTM = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
"""ASTM E1049-85, figure 6."""
SEEDS, ROWS, STEP = 200, 14400, 0.25
HEIGHT, PEAK, HOUR = 4.0, 10.0, 3600.0
TIME = STEP * np.arange(ROWS)
BOUND = 3.5
"""Standard errors within which a mean of seeds is found, but once in 2000 tests."""


def error(values: np.ndarray) -> float:
    """Standard error of the mean of `values` (k,), in their unit."""
    return float(np.std(values, ddof=1)) / np.sqrt(len(values))


@pytest.mark.verifies(
    "rainflow cycles", published="worked example of ASTM E1049-85, 5.4.4", tolerance="identical"
)
def test_rainflow_cycles_of_the_standards_example() -> None:
    """ASTM E1049-85, section 5.4.4: cycles by range."""
    found = Counter[float]()
    for size, count in cycles_of(np.array(ASTM, float)):
        found[size] += count
    assert found == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


@pytest.mark.verifies("damage equivalent load of a sine", analytic="its range", tolerance="1e-12")
def test_equivalent_load_of_a_sine_is_its_range() -> None:
    """50 cycles in 500 s, counted at the sine's frequency; at 1 Hz with 10 times as many."""
    time = np.linspace(0.0, 500.0, 5001)
    values = 7.0 + 3.0 * np.cos(2.0 * np.pi * time / 10.0)
    load = STATISTICS["damage_equivalent_load"]
    for exponent in (1.0, 3.0, 10.0):
        at_own = load.compute(time, values, exponent=exponent, reference_frequency=0.1)
        assert at_own == pytest.approx([6.0], rel=1e-12)
        at_1_hz = load.compute(time, values, exponent=exponent)
        assert at_1_hz == pytest.approx([6.0 * 0.1 ** (1.0 / exponent)], rel=1e-12)


@pytest.mark.verifies(
    "largest crests of an hour in a Gaussian sea, mean of 200 seeds",
    published="Rayleigh's distribution with Davenport's asymptote (1964)",
    tolerance="3.5 standard errors and 1.5 %",
)
def test_largest_values_of_a_gaussian_sea() -> None:
    """Largest values of an hour against Rayleigh's, within the scatter and 1.5 %.

    That is for crests that are not independent (they come in groups) and for the asymptote, whose
    next term is of the order (π²/12)/(2 ln N)², 0.5 %.
    """
    sea = seas(SEEDS, ROWS, STEP, height=HEIGHT, peak_period=PEAK)
    largest = sea.max(axis=1)
    expected = float(np.mean(STATISTICS["expected_maximum"].compute(TIME, sea, duration=HOUR)))
    assert np.mean(largest) == pytest.approx(
        expected, abs=BOUND * error(largest) + 0.015 * expected
    )
    for level in (0.1, 0.5, 0.9):
        given = {"duration": HOUR, "probability": level}
        quantiles = STATISTICS["maximum_quantile"].compute(TIME, sea, **given)
        below = np.mean(largest <= np.mean(quantiles))
        assert below == pytest.approx(
            level, abs=BOUND * np.sqrt(level * (1 - level) / SEEDS) + 0.05
        )
    values = STATISTICS["most_probable_maximum"].compute(TIME, sea, duration=HOUR)
    exact = np.sqrt(2.0 * np.log(HOUR / (PEAK * 0.7104)))  # σ = 1 m, T₀₂ = 0.7104 Tp
    assert np.mean(values) == pytest.approx(exact, abs=BOUND * error(values) + 0.003 * exact)


@pytest.mark.verifies(
    "confidence intervals of 95 % over 5 seeds, share that holds in 2,000 studies",
    analytic="Student's t",
    tolerance="0.015",
)
def test_intervals_hold_as_often_as_they_say() -> None:
    """0.015 are 3 standard errors of a share of 95 % of 2,000."""
    values = 3.0 + 0.5 * np.random.default_rng(5).standard_normal((2000, 5))
    found = confidence_interval(values)
    held = np.mean((found.low <= 3.0) & (found.high >= 3.0))
    assert held == pytest.approx(0.95, abs=0.015)


@pytest.mark.verifies(
    "time shift and amplitude ratio of two sines", analytic="their own", tolerance="1e-6"
)
def test_phase_of_two_sines() -> None:
    time = np.linspace(0.0, 60.0, 1201)
    found = phase(time, 0.7 * np.sin(0.9 * (time - 0.4)), 1.0 + np.sin(0.9 * time))
    assert found.amplitude_ratio == pytest.approx(0.7, rel=1e-6)
    assert found.time_shift == pytest.approx(0.4, rel=1e-6)
