"""Spectral density of a record by Welch's method, and its moments.

Segments of a quarter of the record that overlap by half, Hann window, mean of the record removed.
The window takes part of the ends of a record away: the density is scaled such that its integral is
the variance.
P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans.
Audio Electroacoust. 15, 1967: degrees of freedom and their correlation, equation (17).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError
from m4e_fmi.shown import short
from m4e_fmi.statistics.record import (
    Floats,
    UndefinedError,
    check_varies,
    even_rows,
    of_one_run,
)

SEGMENTS = 4
"""Lengths of a segment in a record, by default."""
HALF_OVERLAP = 1.0 / 36.0
"""Square of the correlation of a Hann window with itself, half its length later."""


@short
@dataclass(frozen=True)
class Spectrum:
    """One-sided `density` (k,) [unit²·s/rad] at `omega` (k,) [rad/s] of a record.

    `degrees_of_freedom` are those of the χ² distribution of each value. `duration` [s] is the
    record's, `scale` the factor that has made the integral the variance.
    """

    omega: Floats
    density: Floats
    degrees_of_freedom: float
    duration: float
    scale: float

    def moment(self, order: int) -> float:
        """∫ ωⁿ S dω of an order n, by trapezoids, in unit²·(rad/s)ⁿ."""
        return float(np.trapezoid(self.omega**order * self.density, self.omega))

    @property
    def significant_height(self) -> float:
        """4 √m₀, in the unit of the record."""
        return 4.0 * float(np.sqrt(self.moment(0)))

    @property
    def mean_period(self) -> float:
        """T₀₁ = 2π m₀/m₁ [s]."""
        return 2.0 * np.pi * self.moment(0) / self.moment(1)

    @property
    def zero_crossing_period(self) -> float:
        """T₀₂ = 2π √(m₀/m₂) [s]."""
        return 2.0 * np.pi * float(np.sqrt(self.moment(0) / self.moment(2)))

    @property
    def peak_period(self) -> float:
        """2π over the frequency of the highest density above 0, through three values [s]."""
        k = int(np.argmax(self.density[1:])) + 1
        at = float(self.omega[k])
        if k + 1 < len(self.omega) and k > 1:
            low, mid, high = np.log(np.maximum(self.density[k - 1 : k + 2], 1e-300)).tolist()
            if bend := low - 2.0 * mid + high:
                at += 0.5 * (low - high) / bend * float(self.omega[1])
        return 2.0 * np.pi / at


def spectrum(time: ArrayLike, values: ArrayLike, *, segment: float | None = None) -> Spectrum:
    """Spectrum of `values` (n,), in their unit, at `time` (n,) [s], in segments [s] of a length.

    `segment` is a quarter of the record by default; its frequencies are multiples of 2π/segment.
    InputError as `checked_runs`, for several runs, constant or short records, lengths that are not
    finite, and time steps that are unequal by more than some rows between (`even_rows`).
    """
    if segment is not None and not math.isfinite(segment):
        raise InputError.single(f"the segment is {segment:g} s long, expected a finite length")
    return of_one_run(time, values, lambda t, x: spectrum_of(t, x, segment))


def spectrum_of(time: Floats, run: Floats, segment: float | None = None) -> Spectrum:
    """As `spectrum`, of `run` (n,), in its unit, at `time` (n,) [s]; UndefinedError with reason."""
    from scipy.signal import welch

    check_varies(run)
    step, even = even_rows(time, run)
    length = len(even) // SEGMENTS if segment is None else round(segment / step)
    if not 4 <= length <= len(even):
        raise UndefinedError(f"segments of {length} rows: expected 4 to {len(even)}")
    even = even - even.mean()
    check_varies(even)
    hertz, density = welch(
        even,
        1.0 / step,
        window="hann",
        nperseg=length,
        noverlap=length // 2,
        detrend=False,
    )
    omega, density = 2.0 * np.pi * hertz, density / (2.0 * np.pi)
    scale = float(np.mean(even**2) / np.trapezoid(density, omega))
    count = (len(even) - length // 2) // (length - length // 2)
    freedom = 2.0 * count / (1.0 + 2.0 * HALF_OVERLAP * (1.0 - 1.0 / count))
    return Spectrum(omega, scale * density, freedom, step * len(even), scale)


def spectral(name: str, time: Floats, run: Floats) -> float:
    """The property `name` of the spectrum of `run` (n,), in its unit, at `time` (n,) [s]."""
    return float(getattr(spectrum_of(time, run), name))


def spectral_moment(order: int, time: Floats, run: Floats) -> float:
    """Moment ∫ωⁿS dω of the spectrum of `run` (n,), in its unit, at `time` (n,) [s]."""
    return spectrum_of(time, run).moment(order)
