"""Slow drift in irregular seas: mean and spectrum of Newman's approximation."""

from __future__ import annotations

import pytest
from support.slow_drift import expected_mean, pinkster, recorded

BANDS = ((0.02, 0.1), (0.1, 0.2))  # rad/s
SEEDS = 40


@pytest.mark.verifies(
    "spectrum of slow drift in a JONSWAP sea, 40 seeds of 34 minutes, differences up to 0.2 rad/s",
    analytic="Pinkster's integral over the whole spectrum",
    tolerance="0.05",
)
def test_spectrum_and_mean() -> None:
    """With 26 and 33 frequencies of 40 seeds each, bands are known to 3 %. Beyond 0.2 rad/s the
    product of D at two frequencies is less than D² between them, by 4 % at 0.22 rad/s."""
    differences, power, means = recorded(SEEDS)
    assert means.mean() == pytest.approx(expected_mean(), rel=0.02)
    for low, high in BANDS:
        inside = (differences >= low) & (differences < high)
        expected = pinkster(differences[inside]).mean()
        assert power[inside].mean() == pytest.approx(expected, rel=0.05)
