"""Spectra of slow drift: recorded over seeds, and Pinkster's integral.

S_F(μ) = 8 ∫ S(ω) S(ω + μ) D²(ω + μ/2) dω, one-sided (J. A. Pinkster, "Low frequency second order
wave exciting forces on floating structures", 1980).
"""

from __future__ import annotations

import math

import numpy as np
from support.drifting import calm, series

from m4e_adapters.hydrodynamics.config import Jonswap
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift, MeanDrift
from m4e_adapters.hydrodynamics.geometry.motions import SURGE
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_adapters.hydrodynamics.seas.waves import relative_spectrum

HEIGHT, PEAK, ENHANCEMENT = 2.0, 8.0, 3.3
DURATION, STEP = 2048.0, 4.0  # s; the step resolves differences up to 0.78 rad/s
KNOTS = np.linspace(0.2, 3.0, 57)


def mean_drift(omega: np.ndarray) -> np.ndarray:
    return 2e4 * omega**2 / (1.0 + omega**4)


def _sea(omega: np.ndarray) -> np.ndarray:
    """S [m2.s] of the whole spectrum."""
    grid = np.geomspace(0.3, 20.0, 4001) * 2.0 * math.pi / PEAK
    ratio = (grid * PEAK / (2.0 * math.pi)).tolist()
    form = np.array([relative_spectrum(r, ENHANCEMENT) for r in ratio])
    density = form / np.trapezoid(form, grid) * HEIGHT**2 / 16.0
    return np.interp(omega, grid, density, left=0.0, right=0.0)


def expected_mean() -> float:
    """2 ∫ S D dω [N]."""
    omega = np.linspace(0.2, 9.0, 8001)
    return 2.0 * float(np.trapezoid(_sea(omega) * mean_drift(omega), omega))


def pinkster(differences: np.ndarray) -> np.ndarray:
    """S_F (n,) [N2.s] at `differences` μ (n,) [rad/s]."""
    omega = np.linspace(0.2, 9.0, 4001)
    density = _sea(omega)
    return np.array(
        [
            8.0 * np.trapezoid(density * _sea(omega + mu) * mean_drift(omega + mu / 2) ** 2, omega)
            for mu in differences.tolist()
        ]
    )


def recorded(seeds: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """μ (n,) [rad/s], mean periodogram (n,) [N2.s] and the mean of each seed [N]."""
    table = MeanDrift("own", KNOTS, np.zeros(1), (SURGE,), mean_drift(KNOTS)[:, None, None])
    times = np.arange(0.0, DURATION, STEP)
    forces = []
    for seed in range(seeds):
        sea = Jonswap(
            spectrum="jonswap",
            significant_height=HEIGHT,
            peak_period=PEAK,
            peak_enhancement=ENHANCEMENT,
            ramp_time=0.0,
            seed=seed,
        )
        drift = {"float": BodyDrift(table)}
        program = hydrodynamics_program(calm(("float",)), waves=sea, drift=drift)
        forces.append(series(program, times)["float.drift_force_x"])
    x = np.array(forces)
    window = np.hanning(len(times))
    window /= math.sqrt(float(np.mean(window**2)))
    parts = np.fft.rfft((x - x.mean(axis=1, keepdims=True)) * window, axis=1)
    power = (np.abs(parts) ** 2).mean(axis=0) * STEP / (len(times) * math.pi)
    return 2.0 * math.pi * np.fft.rfftfreq(len(times), STEP), power, x.mean(axis=1)
