"""Measures of the difference of two records at the same times."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.points import Floats
from m4e_fmi.shown import short
from m4e_fmi.statistics.moments import standard_deviation
from m4e_fmi.statistics.record import UndefinedError, even_rows, is_constant

LEAST_PERIODS = 2.0
"""Periods of the dominant frequency in a record of which a phase is given."""
ROWS_PER_PERIOD = 20
"""Least rows that the frequency is sought in: of finer records not all."""
SCALES = ("range", "amplitude", "value")
"""Sizes of the reference that differences are divided by."""


@short
@dataclass(frozen=True)
class Scales:
    """Sizes of the reference, in its unit.

    `range` is its largest minus its smallest value, `amplitude` √2 times its standard deviation,
    that of a sine, and `value` its largest magnitude.
    """

    range: float
    amplitude: float
    value: float


@short
@dataclass(frozen=True)
class Phase:
    """The record beside the reference at the dominant frequency of the latter, of a `period` [s].

    `amplitude_ratio` is the record's amplitude over the reference's; `time_shift` [s] how much
    later the record is, between minus and plus half a period. `share` is the part of the
    reference's variance that is at this frequency. All are nan, with a `reason`, where there is
    no such frequency.
    """

    period: float = math.nan
    amplitude_ratio: float = math.nan
    time_shift: float = math.nan
    share: float = math.nan
    reason: str = ""


def scales(time: Floats, reference: Floats) -> Scales:
    """Sizes of `reference` (k,), in its unit, at `time` (k,) [s]."""
    deviation = standard_deviation(time, reference) if time[-1] > time[0] else 0.0
    largest = float(np.max(np.abs(reference)))
    return Scales(float(np.ptp(reference)), math.sqrt(2.0) * deviation, largest)


def normalised(difference: Floats, scale: float) -> Floats:
    """`difference` (k,), in its unit, over a `scale` in the same unit, (k,) [1].

    Over a scale of 0 no difference is 0, and any other is infinite.
    """
    if scale > 0.0:
        return difference / scale
    return np.where(difference == 0.0, 0.0, np.inf)


def phase(time: Floats, values: Floats, reference: Floats) -> Phase:
    """Amplitude ratio and time shift of `values` beside `reference` (k,), at `time` (k,) [s].

    Both are in one unit. By least squares of a + b cos ωt + c sin ωt with the weights of a Hann
    window; ω is where the reference has most of its energy. Exact for sines.
    """
    from scipy.optimize import minimize_scalar

    if is_constant(reference):
        return Phase(reason="the reference is constant")
    try:
        step, even = even_rows(time, reference)
    except UndefinedError as error:
        return Phase(reason=str(error))
    span = float(time[-1] - time[0])
    even = (even - even.mean()) * _hann(np.arange(len(even), dtype=float))
    lines = np.abs(np.fft.rfft(even, 4 * len(even)))
    lines[:4] = 0.0  # up to a period in the record: the mean and a drift
    omega = 2.0 * math.pi * int(np.argmax(lines)) / (4 * len(even) * step)
    window = _hann(time)
    if omega * span < 2.0 * math.pi * LEAST_PERIODS:
        return Phase(reason=f"fewer than {LEAST_PERIODS:g} periods of the dominant frequency")
    every = max(1, int(2.0 * math.pi / (omega * step * ROWS_PER_PERIOD)))
    some = slice(None, None, every)
    width = math.pi / span
    found = minimize_scalar(
        lambda w: _fitted(w, time[some], reference[some], window[some])[1],
        bounds=(omega - width, omega + width),
        method="bounded",
        options={"xatol": 1e-8 * omega},
    )
    omega = float(found.x)
    of_reference, left = _fitted(omega, time, reference, window)
    of_values, _ = _fitted(omega, time, values, window)
    ratio = of_values / of_reference
    return Phase(
        period=2.0 * math.pi / omega,
        amplitude_ratio=abs(ratio),
        time_shift=-math.atan2(ratio.imag, ratio.real) / omega,
        share=1.0 - left,
    )


def _hann(time: Floats) -> Floats:
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * (time - time[0]) / (time[-1] - time[0]))


def _fitted(omega: float, time: Floats, values: Floats, window: Floats) -> tuple[complex, float]:
    """Complex amplitude X of Re(X exp(iωt)) in values (k,), and the part of their variance left."""
    angle = omega * time
    rows = np.stack([np.ones(len(time)), np.cos(angle), np.sin(angle)])
    away = values - window @ values / window.sum()
    weighted = rows * window
    found = np.linalg.solve(weighted @ rows.T, weighted @ away)  # well conditioned: two periods
    left = float(window @ (away - found @ rows) ** 2)
    whole = float(window @ away**2)
    return complex(found[1], -found[2]), left / whole if whole > 0.0 else 1.0
