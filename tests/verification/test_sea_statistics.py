"""Seas are Gaussian, crests follow Rice's distribution, and records scatter as they should."""

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
from support.seas import scatter

from m4e_adapters.hydrodynamics.config import PiersonMoskowitz

SEEDS = 60
DEVIATION = 0.25  # m: Hs is 1 m


@pytest.mark.verifies(
    "moments of the elevation, rate of crests, local maxima above -1 to 3 standard deviations",
    analytic="Gaussian process; Rice's distribution of maxima",
    tolerance="3 standard errors of 60 seeds",
)
@pytest.mark.parametrize("amplitudes", ["fixed", "random"])
def test_seas_are_gaussian_and_crests_are_rices(amplitudes: str, tmp_path: Path) -> None:
    spectrum = Spectrum.narrow()
    section = spectrum.section(tmp_path, amplitudes=amplitudes)
    m0, m2, m4 = (spectrum.moment(k) for k in (0, 2, 4))
    rate = DURATION / (2 * math.pi) * math.sqrt(m4 / m2)
    records = [record(of_seed(section, seed, tmp_path)) / DEVIATION for seed in range(SEEDS)]
    for power, expected in ((2, 1.0), (3, 0.0), (4, 3.0)):
        assert abs(beyond(np.array([np.mean(z**power) for z in records]), expected)) < 3
    tops = [maxima(z) for z in records]
    assert abs(beyond(np.array([len(top) for top in tops]), rate)) < 3
    for level in LEVELS:
        found = np.array([np.sum(top > level) for top in tops], dtype=float)
        assert abs(beyond(found, rate * rice_above(level, m0, m2, m4))) < 3, level


@pytest.mark.verifies(
    "crests above three standard deviations in ten minutes",
    independent="Gaussian process by the Fourier transform of complex normal numbers",
    tolerance="3 standard errors of 60 seeds",
)
def test_high_crests_are_as_many_as_in_a_reference_simulation(tmp_path: Path) -> None:
    spectrum = Spectrum.narrow()
    section = spectrum.section(tmp_path, amplitudes="random")
    records = [record(of_seed(section, seed, tmp_path)) for seed in range(SEEDS)]
    ours, theirs = (
        np.array([np.sum(maxima(z) > 3 * DEVIATION) for z in every])
        for every in (records, gaussian_records(spectrum, SEEDS))
    )
    error = math.hypot(ours.std(ddof=1), theirs.std(ddof=1)) / math.sqrt(SEEDS)
    assert ours.mean() > 0.5
    assert abs(ours.mean() - theirs.mean()) < 3 * error


@pytest.mark.verifies(
    "variance of m0 of ten minutes between 200 seeds, random amplitudes, Pierson-Moskowitz",
    analytic="variance of the variance of a Gaussian process",
    tolerance="0.2; 0.06 with 5,000 seeds (make verify)",
)
def test_random_amplitudes_scatter_as_records() -> None:
    """The variance of 200 values is known to 10 %; fixed amplitudes have 0.70 of it."""
    section = PiersonMoskowitz(
        spectrum="pierson_moskowitz", significant_height=1.0, peak_period=7.5, amplitudes="random"
    )
    found = np.array([record(of_seed(section, seed), step=0.5).var() for seed in range(200)])
    expected = (2 * scatter(1.0, 2 * math.pi / 7.5) / 16) ** 2
    assert found.mean() == pytest.approx(1 / 16, rel=0.02)
    assert found.var(ddof=1) == pytest.approx(expected, rel=0.2)
