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

from m4e_adapters.hydrodynamics.config import PiersonMoskowitz, Tma
from m4e_adapters.hydrodynamics.config.waves import WaveSection
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components
from m4e_adapters.hydrodynamics.seas.waves import depth_factor, relative_spectrum

SEEDS = 60
DEVIATION = 0.25  # m: Hs is 1 m
DEPTH, PEAK = 12.0, 2 * math.pi / 8.0


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


@pytest.mark.verifies(
    "height and mean periods of TMA seas, 30 seeds",
    analytic="moments of the spectrum to 12 peak frequencies",
    tolerance="0.01",
)
def test_a_tma_sea_has_its_mean_periods() -> None:
    section = Tma(spectrum="tma", significant_height=1.0, peak_period=8.0)
    ratio = np.geomspace(0.5, 12.0, 20_001)
    form = np.array([relative_spectrum(r, 3.3) for r in ratio.tolist()])
    form *= depth_factor(ratio * PEAK, depth=DEPTH, gravity=9.81)
    moments = [np.trapezoid((ratio * PEAK) ** k * form, ratio) for k in (0, 1, 2)]
    sums = np.array([_moments(in_water(section, seed)) for seed in range(30)]).mean(axis=0)
    assert 4 * math.sqrt(sums[0]) == pytest.approx(1.0, rel=1e-9)
    assert sums[0] / sums[1] == pytest.approx(moments[0] / moments[1], rel=0.01)
    assert math.sqrt(sums[0] / sums[2]) == pytest.approx(
        math.sqrt(moments[0] / moments[2]), rel=0.01
    )


def in_water(section: WaveSection, seed: int) -> Components:
    changed = section.model_copy(update={"seed": seed})
    return components_of(wave_systems(changed, depth=DEPTH, gravity=9.81), {})


def _moments(waves: Components) -> list[float]:
    return [0.5 * float(waves.amplitude**2 @ waves.omega**k) for k in (0, 1, 2)]
