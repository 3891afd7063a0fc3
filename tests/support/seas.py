"""Irregular seas of many seeds, and what theory says of them."""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.config import Jonswap
from m4e_adapters.hydrodynamics.seas.waves import (
    component_amplitudes,
    component_frequencies,
    component_phases,
    part_edges,
    relative_spectrum,
)

DURATION = 600.0  # s, of a record


def moments(enhancement: float, peak_omega: float) -> tuple[np.ndarray, float]:
    """(m0, m1, m2) and ∫ S² dω of the whole spectrum, Hs = 1 m, by fine quadrature to 1,000 ω_p;
    beyond, S = m0 c ω⁻⁵ leaves 5e-7 of m2."""
    ratio = np.geomspace(0.3, 1000.0, 20_001)
    form = np.array([relative_spectrum(r, enhancement) for r in ratio.tolist()])
    density = form / np.trapezoid(form, ratio) / peak_omega / 16.0
    omega = ratio * peak_omega
    found = np.array([np.trapezoid(omega**k * density, omega) for k in (0, 1, 2)])
    return found, float(np.trapezoid(density**2, omega))


def seas(
    seeds: int,
    *,
    enhancement: float = 3.3,
    made_for: float = 7.5,
    peak_period: float = 7.5,
    count: int = Jonswap.model_fields["components"].default,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each seed, Hs = 1 m: m0, m1, m2 of the components, and m0 and m2 of a record of DURATION.

    m2 of the record is the variance of the rate, exact for each component. The elevation at 15 i
    + j/4 seconds is Re Σ_k (a_k e^{i(15 ω_k i + φ_k)}) e^{i ω_k j/4}: a product of matrices.
    """
    edges = part_edges(2 * math.pi / made_for, count, enhancement=enhancement)
    sums, heights, rates = [], [], []
    for seed in range(seeds):
        rng = np.random.Generator(np.random.PCG64(seed))
        omega = component_frequencies(edges, rng)
        phases = component_phases(count, rng)
        amplitudes = np.array(
            component_amplitudes(
                omega.tolist(),
                np.diff(edges).tolist(),
                significant_height=1.0,
                peak_period=peak_period,
                enhancement=enhancement,
            )
        )
        coarse = np.exp(1j * (np.outer(15.0 * np.arange(40), omega) + phases))
        fine = np.exp(1j * np.outer(omega, 0.25 * np.arange(60)))
        sums.append([0.5 * np.sum(amplitudes**2 * omega**k) for k in (0, 1, 2)])
        heights.append(np.real((amplitudes * coarse) @ fine).var())
        rates.append(np.imag((omega * amplitudes * coarse) @ fine).var())
    return np.array(sums), np.array(heights), np.array(rates)


def scatter(enhancement: float, peak_omega: float) -> float:
    """Standard deviation of Hs of a record of DURATION, over Hs.

    A Gaussian process of the covariance R(τ) = ∫ S cos ωτ dω has, over T, the variance estimate's
    variance (2/T) ∫ R² dτ over all τ, and by Parseval's theorem ∫ R² dτ = π ∫ S² dω:
    σ²(m0) = (2π/T) ∫ S² dω. Hs = 4 √m0 scatters by σ(m0)/(2 m0) of itself.
    """
    (m0, _, _), square = moments(enhancement, peak_omega)
    return math.sqrt(2 * math.pi / DURATION * square) / (2 * m0)
