"""Spectrum of slow drift over many seeds, in narrow bands."""

from __future__ import annotations

import itertools

import pytest
from support.slow_drift import expected_mean, pinkster, recorded

EDGES = (0.02, 0.05, 0.1, 0.15, 0.2)  # rad/s


def test_narrow_bands() -> None:
    """10 to 17 frequencies of 400 seeds each: bands are known to 1.6 %."""
    differences, power, means = recorded(400)
    assert means.mean() == pytest.approx(expected_mean(), rel=0.01)
    for low, high in itertools.pairwise(EDGES):
        inside = (differences >= low) & (differences < high)
        expected = pinkster(differences[inside]).mean()
        assert power[inside].mean() == pytest.approx(expected, rel=0.05), (low, high)
