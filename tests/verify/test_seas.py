"""Irregular seas of 1,000 seeds: height, periods and scatter for all shapes of the spectrum."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.seas import moments, scatter, seas


@pytest.mark.verify
@pytest.mark.parametrize("period", [7.5, 15.0])
@pytest.mark.parametrize("enhancement", [1.0, 3.3, 7.0])
def test_a_thousand_seeds(enhancement: float, period: float) -> None:
    """The standard deviation of 1,000 is known to 2 %, their mean to 0.3 % of the height."""
    peak = 2 * math.pi / period
    (m0, m1, m2), _ = moments(enhancement, peak)
    sums, heights, rates = seas(1000, enhancement=enhancement, made_for=period, peak_period=period)
    found = 4 * np.sqrt(heights)
    first = (sums[:, 0] / sums[:, 1]).mean() / (m0 / m1)
    second = math.sqrt(heights.mean() / rates.mean() / (m0 / m2))
    spread = found.std(ddof=1) / scatter(enhancement, peak)
    print(
        f"Hs {found.mean():.4f}, T01 {first:.4f}, T02 {second:.4f}, scatter {spread:.3f} of theory"
    )
    assert found.mean() == pytest.approx(1.0, rel=0.01)
    assert first == pytest.approx(1.0, rel=0.01)
    assert second == pytest.approx(1.0, rel=0.01)
    assert spread == pytest.approx(1.0, rel=0.25)
