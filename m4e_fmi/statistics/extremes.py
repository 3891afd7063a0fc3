"""Largest values over a duration of a Gaussian process, from a record of another length.

The largest is that of N independent peaks. Crests of a Gaussian process in a narrow band are
Rayleigh distributed, exp(−x²/2σ²) above the mean; σ and the mean period between up-crossings are
the record's. For a process in a wide band it holds for high levels (S. O. Rice 1944; Cartwright,
Longuet-Higgins 1956). The mean of the largest is the asymptote ln N ≫ 1 (A. G. Davenport 1964).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from m4e_fmi.statistics.cycles import zero_crossing_period
from m4e_fmi.statistics.moments import standard_deviation
from m4e_fmi.statistics.record import Floats, UndefinedError, weights


@dataclass(frozen=True)
class _Peaks:
    """N peaks with P(peak > level + x) = exp(−(x/scale)²); `log` is ln N.

    `level` and `scale` are in the unit of the record.
    """

    log: float
    level: float
    scale: float

    def exceeded_by(self, log: float) -> float:
        """The value, in the unit of the record, that one of e^log peaks exceeds in the mean."""
        return self.level + self.scale * math.sqrt(max(log, 0.0))


def _peaks(time: Floats, run: Floats, duration: float) -> _Peaks:
    """The peaks of a `duration` [s]; UndefinedError for too few."""
    cycles = duration / zero_crossing_period(time, run)
    if cycles <= math.e:
        raise UndefinedError(f"{duration:g} s have {cycles:.2g} cycles: too few for an extreme")
    middle = float(weights(time) @ run)
    return _Peaks(math.log(cycles), middle, math.sqrt(2.0) * standard_deviation(time, run))


def most_probable_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mode of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    peaks = _peaks(time, run, duration)
    return peaks.exceeded_by(peaks.log)


def expected_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mean of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    peaks = _peaks(time, run, duration)
    largest = peaks.exceeded_by(peaks.log) - peaks.level
    return peaks.level + largest * (1.0 + np.euler_gamma / (2.0 * peaks.log))


def maximum_quantile(time: Floats, run: Floats, *, duration: float, probability: float) -> float:
    """Quantile of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    peaks = _peaks(time, run, duration)
    return peaks.exceeded_by(peaks.log - math.log(-math.log(probability)))
