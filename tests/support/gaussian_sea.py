"""Gaussian processes with a known spectrum, for tests of statistics."""

from __future__ import annotations

import numpy as np


def density(omega: np.ndarray, height: float, peak_period: float) -> np.ndarray:
    """Density (k,) [m2.s/rad] of Bretschneider's spectrum at `omega` (k,) [rad/s], all positive.

    Of significant height [m] and peak period [s].
    """
    ratio = 2.0 * np.pi / peak_period / omega
    return 0.3125 * height**2 * ratio**4 / omega * np.exp(-1.25 * ratio**4)


def seas(seeds: int, rows: int, step: float, *, height: float, peak_period: float) -> np.ndarray:
    """Elevations (seeds, rows) [m] in steps [s]: complex normal amplitudes.

    Made in four times the rows, so that the record is not periodic.
    """
    rng = np.random.default_rng(0)
    whole = 4 * rows
    omega = 2.0 * np.pi * np.fft.rfftfreq(whole, step)[1:]
    deviation = np.sqrt(density(omega, height, peak_period) * omega[0])
    found = np.empty((seeds, rows))
    for k in range(seeds):
        lines = np.zeros(len(omega) + 1, complex)
        real, imaginary = rng.standard_normal((2, len(omega)))
        lines[1:] = 0.5 * whole * deviation * (real + 1j * imaginary)
        found[k] = np.fft.irfft(lines, whole)[:rows]
    return found
