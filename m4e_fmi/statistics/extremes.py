"""Largest values over a duration of a Gaussian process, from a record of another length.

The largest is that of N independent peaks. Crests of a Gaussian process in a narrow band are
Rayleigh distributed, exp(−x²/2σ²) above the mean; σ and the mean period between up-crossings are
the record's. For a process in a wide band it holds for high levels (S. O. Rice 1944; Cartwright,
Longuet-Higgins 1956). The mean of the largest is the asymptote ln N ≫ 1 (A. G. Davenport 1964).
"""

from __future__ import annotations

import math

import numpy as np

from m4e_fmi.statistics.cycles import zero_crossing_period
from m4e_fmi.statistics.moments import standard_deviation
from m4e_fmi.statistics.record import Floats, UndefinedError, weights


def _peaks(time: Floats, run: Floats, duration: float) -> tuple[float, float, float]:
    """ln N, level, scale of N peaks in a `duration` [s]; UndefinedError for too few.

    P(peak > level + x) = exp(−(x/scale)²); one of e^n peaks exceeds level + scale √n in the mean.
    Level and scale are in the unit of `run` (n,), at `time` (n,) [s].
    """
    cycles = duration / zero_crossing_period(time, run)
    if cycles <= math.e:
        raise UndefinedError(f"{duration:g} s have {cycles:.2g} cycles: too few for an extreme")
    middle = float(weights(time) @ run)
    return math.log(cycles), middle, math.sqrt(2.0) * standard_deviation(time, run)


def most_probable_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mode of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    log, level, scale = _peaks(time, run, duration)
    return level + scale * math.sqrt(log)


def expected_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mean of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    log, level, scale = _peaks(time, run, duration)
    largest = level + scale * math.sqrt(log) - level
    return level + largest * (1.0 + np.euler_gamma / (2.0 * log))


def maximum_quantile(time: Floats, run: Floats, *, duration: float, probability: float) -> float:
    """Quantile of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    log, level, scale = _peaks(time, run, duration)
    return level + scale * math.sqrt(max(log - math.log(-math.log(probability)), 0.0))
