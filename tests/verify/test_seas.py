"""Irregular seas of 1,000 seeds: height, periods and scatter for all shapes of the spectrum."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.crests import (
    DURATION,
    LEVELS,
    Spectrum,
    beyond,
    gaussian_records,
    maxima,
    of_seed,
    record,
    rice_above,
)
from support.seas import moments, scatter, seas

from m4e_adapters.hydrodynamics.config import Jonswap


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


@pytest.mark.parametrize("enhancement", [1.0, 3.3])
def test_five_thousand_seeds_of_random_amplitudes(enhancement: float) -> None:
    """Variance of m0 of ten minutes within 6 % of theory; that of 5,000 is known to 2 %."""
    section = Jonswap(
        spectrum="jonswap",
        significant_height=1.0,
        peak_period=7.5,
        peak_enhancement=enhancement,
        amplitudes="random",
    )
    found = np.array([record(of_seed(section, seed), step=0.5).var() for seed in range(5000)])
    expected = (2 * scatter(enhancement, 2 * math.pi / 7.5) / 16) ** 2
    print(f"m0 {16 * found.mean():.4f}, variance {found.var(ddof=1) / expected:.4f} of theory")
    assert found.mean() == pytest.approx(1 / 16, rel=0.01)
    assert found.var(ddof=1) == pytest.approx(expected, rel=0.06)


def test_crests_of_a_thousand_seeds(tmp_path: Path) -> None:
    """Local maxima above -1 to 3 standard deviations: Rice's distribution, and a reference
    simulation, both within three standard errors."""
    spectrum, seeds = Spectrum.narrow(), 1000
    section = spectrum.section(tmp_path, amplitudes="random")
    m0, m2, m4 = (spectrum.moment(k) for k in (0, 2, 4))
    rate = DURATION / (2 * math.pi) * math.sqrt(m4 / m2)
    ours = [4 * maxima(record(of_seed(section, k, tmp_path), step=0.1)) for k in range(seeds)]
    theirs = [4 * maxima(z) for z in gaussian_records(spectrum, seeds, step=0.1)]
    for level in LEVELS:
        found, reference = (
            np.array([np.sum(top > level) for top in tops], dtype=float) for tops in (ours, theirs)
        )
        off = beyond(found, rate * rice_above(level, m0, m2, m4))
        error = math.hypot(found.std(ddof=1), reference.std(ddof=1)) / math.sqrt(seeds)
        apart = (found.mean() - reference.mean()) / error
        print(f"{level:4g}: {found.mean():8.3f} in ten minutes, off by {off:5.2f}, {apart:5.2f}")
        assert abs(off) < 3
        assert abs(apart) < 3
