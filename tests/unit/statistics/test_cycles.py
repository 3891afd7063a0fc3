"""Peaks, rainflow cycles and equivalent loads against worked examples."""

from __future__ import annotations

import numpy as np
import pytest

from m4e_fmi.statistics import STATISTICS, peaks

ASTM = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
"""ASTM E1049-85, figure 6."""


def test_equivalent_load_of_the_standards_example() -> None:
    found = STATISTICS["damage_equivalent_load"].compute(np.arange(9.0), ASTM, exponent=4.0)
    damage = 0.5 * 3**4 + 1.5 * 4**4 + 0.5 * 6**4 + 8**4 + 0.5 * 9**4
    assert found == pytest.approx([(damage / 8.0) ** 0.25], rel=1e-12)
    plateaus = STATISTICS["damage_equivalent_load"].compute(
        np.linspace(0.0, 8.0, 27), np.repeat(ASTM, 3), exponent=4.0
    )
    assert plateaus == pytest.approx(found, rel=1e-12)


def test_peaks_about_the_mean_and_about_a_level() -> None:
    time = np.linspace(0.0, 40.0, 4001)
    values = 1.0 + (1.0 + 0.1 * np.floor(time / 10.0)) * np.sin(2.0 * np.pi * (time / 10.0 - 0.01))
    found = peaks(time, values, level=1.0)
    assert found.crossings == pytest.approx([0.1, 10.1, 20.1, 30.1], abs=0.02)
    assert found.time == pytest.approx([2.6, 12.6, 22.6], abs=1e-9)
    assert found.amplitudes == pytest.approx([1.0, 1.1, 1.2])
    assert found.heights == pytest.approx([2.0, 2.2, 2.4])
    assert peaks(time, values).level == pytest.approx(np.trapezoid(values, time) / 40.0)
    assert len(peaks(time, values, level=9.0).crests) == 0


def test_significant_heights_are_of_the_highest_third() -> None:
    """Nine whole cycles of the heights 2, 4 … 18 and a tenth, cut; each has the mean 0."""
    time = np.linspace(0.0, 10.0, 10001)
    values = np.minimum(np.floor(time) + 1.0, 10.0) * np.sin(2.0 * np.pi * (time - 0.001))
    heights = STATISTICS["significant_height"].compute(time, values)
    assert heights == pytest.approx([16.0], rel=1e-4)
    amplitudes = STATISTICS["significant_amplitude"].compute(time, values)
    assert amplitudes == pytest.approx([8.0], rel=1e-3)
