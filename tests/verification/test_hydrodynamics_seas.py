"""Irregular seas have the statistics of the whole spectrum, and scatter as records do."""

import math

import numpy as np
import pytest
from support.seas import moments, scatter, seas

from m4e_adapters.hydrodynamics.seas.systems import PERIODS

PEAK = 7.5  # s


@pytest.mark.parametrize("factor", PERIODS)
def test_a_sea_of_another_peak_period_keeps_its_statistics(factor: float) -> None:
    """At the limits of the parameter: mean periods within 1 %, the scatter within 35 %."""
    peak = 2 * math.pi / (PEAK * factor)
    (m0, m1, m2), _ = moments(3.3, peak)
    sums, heights, _ = seas(40, made_for=PEAK, peak_period=PEAK * factor)
    assert sums[:, 0] / sums[:, 1] == pytest.approx(m0 / m1, rel=0.01)
    assert np.sqrt(sums[:, 0] / sums[:, 2]) == pytest.approx(math.sqrt(m0 / m2), rel=0.01)
    found = (4 * np.sqrt(heights)).std(ddof=1)
    assert found == pytest.approx(scatter(3.3, peak), rel=0.35)


@pytest.mark.verifies(
    "mean height and periods of 100 seeds, 10 minutes each",
    analytic="moments of the whole JONSWAP spectrum",
    tolerance="0.01",
)
@pytest.mark.verifies(
    "scatter of the height of 10 minutes between seeds",
    analytic="variance of the variance of a Gaussian process",
    tolerance="0.25",
)
def test_ten_minutes() -> None:
    """The height of one seed scatters by 7 %: the mean of 40 is known to 1.1 %, that of 100 to
    0.7 %; the standard deviation of 100 to 7 %."""
    peak = 2 * math.pi / PEAK
    (m0, m1, m2), _ = moments(3.3, peak)
    sums, heights, rates = seas(100, made_for=PEAK, peak_period=PEAK)
    found = 4 * np.sqrt(heights)
    assert found.mean() == pytest.approx(1.0, rel=0.01)
    assert sums[:, 0] / sums[:, 1] == pytest.approx(m0 / m1, rel=0.01)
    assert math.sqrt(heights.mean() / rates.mean()) == pytest.approx(math.sqrt(m0 / m2), rel=0.01)
    assert found.std(ddof=1) == pytest.approx(scatter(3.3, peak), rel=0.25)
