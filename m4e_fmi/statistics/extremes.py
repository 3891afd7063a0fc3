"""Largest values over a duration, from a record of another length, by three models.

Each model is a distribution of the largest of N independent peaks:

- Gaussian: crests of a Gaussian process in a narrow band are Rayleigh distributed, exp(−x²/2σ²)
  above the mean; σ and the mean period between up-crossings are the record's. For a process in a
  wide band it holds for high levels (S. O. Rice 1944; Cartwright, Longuet-Higgins 1956).
- Weibull: exp(−(x/a)^c) fitted to the highest half of the crests, one of each cycle, by maximum
  likelihood; those below count as being below. For responses that are not Gaussian.
- Gumbel: exp(−exp(−(x − u)/b)) fitted to the largest values of equal parts of the record by maximum
  likelihood (E. J. Gumbel, "Statistics of Extremes", 1958).

The mean of the Gaussian one is the asymptote ln N ≫ 1 (A. G. Davenport 1964).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from m4e_fmi.statistics.cycles import peaks_of, zero_crossing_period
from m4e_fmi.statistics.moments import standard_deviation
from m4e_fmi.statistics.record import CONSTANT, Floats, UndefinedError, weights

TAIL = 0.5
"""Highest part of the crests that a Weibull distribution is fitted to."""
LEAST_CRESTS = 30
"""Cycles of a record to which a Weibull distribution is fitted."""
LEAST_BLOCKS = 5
"""Parts of a record to whose largest values a Gumbel distribution is fitted."""


@dataclass(frozen=True)
class _Peaks:
    """N peaks with P(peak > level + x) = exp(−(x/scale)^shape); `log` is ln N.

    `level` and `scale` are in the unit of the record.
    """

    log: float
    level: float
    scale: float
    shape: float

    def exceeded_by(self, log: float) -> float:
        """The value, in the unit of the record, that one of e^log peaks exceeds in the mean."""
        return self.level + self.scale * max(log, 0.0) ** (1.0 / self.shape)


def _log_of(cycles: float, duration: float) -> float:
    """ln of the number of `cycles` in a `duration` [s]; UndefinedError for too few."""
    if cycles <= math.e:
        raise UndefinedError(f"{duration:g} s have {cycles:.2g} cycles: too few for an extreme")
    return math.log(cycles)


def _gaussian(time: Floats, run: Floats, duration: float) -> _Peaks:
    log = _log_of(duration / zero_crossing_period(time, run), duration)
    middle = float(weights(time) @ run)
    return _Peaks(log, middle, math.sqrt(2.0) * standard_deviation(time, run), 2.0)


def most_probable_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mode of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    peaks = _gaussian(time, run, duration)
    return peaks.exceeded_by(peaks.log)


def expected_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mean of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    peaks = _gaussian(time, run, duration)
    largest = peaks.exceeded_by(peaks.log) - peaks.level
    return peaks.level + largest * (1.0 + np.euler_gamma / (peaks.shape * peaks.log))


def maximum_quantile(time: Floats, run: Floats, *, duration: float, probability: float) -> float:
    """Quantile of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    peaks = _gaussian(time, run, duration)
    return peaks.exceeded_by(peaks.log - math.log(-math.log(probability)))


def weibull_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mode of the largest value over a `duration` [s] by a Weibull tail, in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    found = peaks_of(time, run)
    sizes = np.sort(found.amplitudes)
    if len(sizes) < LEAST_CRESTS:
        raise UndefinedError(f"the record has {len(sizes)} complete cycles, not {LEAST_CRESTS}")
    below = len(sizes) - int(TAIL * len(sizes))
    limit = float(sizes[below - 1])
    if limit <= 0.0:
        raise UndefinedError("half of the crests are not above the mean")
    if sizes[-1] - limit <= CONSTANT * max(abs(limit), abs(found.level)):
        raise UndefinedError(f"the highest half of the crests are all {sizes[-1]:g} above the mean")
    span = float(found.crossings[-1] - found.crossings[0])
    log = _log_of(duration * len(sizes) / span, duration)
    return _Peaks(log, found.level, *_weibull_fit(sizes[below:], below, limit)).exceeded_by(log)


def _weibull_fit(above: Floats, below: int, limit: float) -> tuple[float, float]:
    """Scale and shape of values `above` a limit.

    Of `below` further ones it is only known that they are not above the `limit`.
    """
    from scipy.optimize import minimize

    unit = float(above.mean())
    x, u = np.log(above / unit), math.log(limit / unit)

    def cost(logs: Floats) -> float:
        shape = math.exp(logs[1])
        powers = np.exp(shape * (x - logs[0]))
        density = len(x) * (logs[1] - logs[0]) + (shape - 1.0) * float(np.sum(x - logs[0]))
        left = below * math.log(-math.expm1(-math.exp(shape * (u - logs[0]))))
        return -(density - float(powers.sum()) + left)

    start = np.array([0.0, math.log(2.0)])
    fit = minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-9})
    if not fit.success:
        raise UndefinedError(f"no Weibull distribution was found for the crests: {fit.message}")
    return unit * math.exp(fit.x[0]), math.exp(fit.x[1])


def gumbel_maximum(time: Floats, run: Floats, *, duration: float, blocks: float) -> float:
    """Mode of the largest value over a `duration` [s] by Gumbel's fit, in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s]; `blocks` is the number of parts.
    """
    from scipy.stats import gumbel_r

    weights(time)
    edges = np.linspace(time[0], time[-1], int(blocks) + 1)
    starts = np.searchsorted(time, edges[:-1])
    if (np.diff([*starts, len(time)]) < LEAST_BLOCKS).any():
        raise UndefinedError(f"the record has {len(time)} rows: too few for {blocks:g} parts")
    largest = np.maximum.reduceat(run, starts)
    if np.ptp(largest) == 0.0:
        raise UndefinedError(f"all parts have the largest value {largest[0]:g}")
    at, scale = map(float, gumbel_r.fit(largest))
    return at + scale * math.log(duration / float(edges[1] - edges[0]))
