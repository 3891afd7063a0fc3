"""Largest values over a duration, from a record of another length, by three models.

Each model is a distribution of the largest of N independent peaks:

- Gaussian: crests of a Gaussian process in a narrow band are Rayleigh distributed, exp(−x²/2σ²)
  above the mean; σ and the mean period between up-crossings are the record's. For a process in a
  wide band it holds for high levels (S. O. Rice 1944; Cartwright, Longuet-Higgins 1956).
- Weibull: exp(−(x/a)^c) fitted to the highest half of the crests, one of each cycle, by maximum
  likelihood; those below count as being below. For responses that are not Gaussian.
- Gumbel: exp(−exp(−(x − u)/b)) fitted to the largest values of equal parts of the record by maximum
  likelihood (E. J. Gumbel, "Statistics of Extremes", 1958).

The first two give the mean by the asymptote ln N ≫ 1 (A. G. Davenport 1964 for the Gaussian).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError
from m4e_fmi.shown import short
from m4e_fmi.statistics.cycles import peaks_of, zero_crossing_period
from m4e_fmi.statistics.moments import standard_deviation
from m4e_fmi.statistics.record import CONSTANT, Floats, UndefinedError, of_one_run, weights
from m4e_fmi.statistics.spectra import spectrum_of

TAIL = 0.5
"""Highest part of the crests that a Weibull distribution is fitted to."""
LEAST_CRESTS = 30
"""Cycles of a record to which a Weibull distribution is fitted."""
LEAST_BLOCKS = 5
"""Parts of a record to whose largest values a Gumbel distribution is fitted."""


@short
@dataclass(frozen=True)
class Extreme:
    """Largest value of a record's quantity over a `duration` [s]; all in the unit of the record.

    `most_probable` is the mode, that N peaks exceed once in the mean; `expected` the mean of the
    largest value. `error` is the standard error of `most_probable` from the scatter of the record,
    nan where it is not known.
    """

    model: str
    duration: float
    most_probable: float
    expected: float
    error: float
    _quantile: Callable[[float], float]

    def quantile(self, probability: float) -> float:
        """The value that the largest one does not exceed with a `probability` between 0 and 1."""
        if not 0.0 < probability < 1.0:
            message = f"the probability is {probability:g}, expected one between 0 and 1"
            raise InputError.single(message)
        return self._quantile(probability)


def gaussian_extreme(time: ArrayLike, values: ArrayLike, duration: float) -> Extreme:
    """Largest value over a `duration` [s] of a Gaussian process, by its deviation and period.

    `values` (n,), in their unit, at `time` (n,) [s]. Its error is that of σ, half that of the
    variance by the spectrum. InputError where it is not defined.
    """
    return _checked(_gaussian, time, values, duration)


def weibull_extreme(time: ArrayLike, values: ArrayLike, duration: float) -> Extreme:
    """Largest value over a `duration` [s] by the Weibull distribution of the highest crests.

    `values` (n,), in their unit, at `time` (n,) [s]. Its error is that of the maximum likelihood.
    InputError where it is not defined.
    """
    return _checked(_weibull, time, values, duration)


def gumbel_extreme(
    time: ArrayLike, values: ArrayLike, duration: float, *, blocks: int = 10
) -> Extreme:
    """Largest value over a `duration` [s] by the largest ones of equal parts of the record.

    `values` (n,), in their unit, at `time` (n,) [s]; `blocks` is the number of parts. Its error is
    that of the maximum likelihood for many parts. InputError where it is not defined.
    """
    return _checked(lambda t, x, d: _gumbel(t, x, d, blocks), time, values, duration)


def _checked(
    model: Callable[[Floats, Floats, float], Extreme],
    time: ArrayLike,
    values: ArrayLike,
    duration: float,
) -> Extreme:
    if not duration > 0.0:
        raise InputError.single(f"expected a positive duration, got {duration:g} s")
    return of_one_run(time, values, lambda t, x: model(t, x, duration))


def _of_peaks(
    model: str, duration: float, peaks: float, level: float, scale: float, shape: float
) -> Extreme:
    """Of N peaks with P(peak > level + x) = exp(−(x/scale)^shape); its error is not known yet."""
    if peaks <= math.e:
        raise UndefinedError(f"{duration:g} s have {peaks:.2g} cycles: too few for an extreme")
    log = math.log(peaks)
    largest = scale * log ** (1.0 / shape)

    def quantile(probability: float) -> float:
        size = log - math.log(-math.log(probability))
        return level + scale * max(size, 0.0) ** (1.0 / shape)

    expected = level + largest * (1.0 + np.euler_gamma / (shape * log))
    return Extreme(model, duration, level + largest, expected, math.nan, quantile)


def gaussian_of(time: Floats, run: Floats, duration: float) -> Extreme:
    """As `gaussian_extreme`, of `run` (n,), in its unit, at `time` (n,) [s], without the error."""
    cycles = duration / zero_crossing_period(time, run)
    deviation = standard_deviation(time, run)
    middle = float(weights(time) @ run)
    return _of_peaks("Gaussian", duration, cycles, middle, math.sqrt(2.0) * deviation, 2.0)


def _gaussian(time: Floats, run: Floats, duration: float) -> Extreme:
    found = gaussian_of(time, run, duration)
    try:
        share = 0.5 * spectrum_of(time, run).variance_error
    except UndefinedError:
        share = math.nan
    return _with_error(found, share * (found.most_probable - float(weights(time) @ run)))


def _weibull(time: Floats, run: Floats, duration: float) -> Extreme:
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
    scale, shape, covariance = _weibull_fit(sizes[below:], below, limit)
    span = float(found.crossings[-1] - found.crossings[0])
    peaks = duration * len(sizes) / span
    extreme = _of_peaks("Weibull", duration, peaks, found.level, scale, shape)
    log, size = math.log(peaks), extreme.most_probable - found.level
    slope = size * np.array([1.0, -math.log(log) / shape])  # by ln scale and ln shape
    return _with_error(extreme, float(np.sqrt(max(0.0, slope @ covariance @ slope))))


def _weibull_fit(above: Floats, below: int, limit: float) -> tuple[float, float, Floats]:
    """Scale and shape of values `above` a limit, and the covariance (2, 2) of their logarithms.

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
    information = _second_derivatives(cost, fit.x)
    scale, shape = unit * math.exp(fit.x[0]), math.exp(fit.x[1])
    return scale, shape, np.asarray(np.linalg.pinv(information), dtype=float)


def _second_derivatives(function: Callable[[Floats], float], at: Floats) -> Floats:
    """Second derivatives (2, 2) of a function of two numbers, by central differences."""
    e = 1e-4 * np.eye(2)
    found = np.empty((2, 2))
    for i in range(2):
        for j in range(2):
            plus = function(at + e[i] + e[j]) + function(at - e[i] - e[j])
            minus = function(at + e[i] - e[j]) + function(at - e[i] + e[j])
            found[i, j] = (plus - minus) / 4e-8
    return found


def _gumbel(time: Floats, run: Floats, duration: float, blocks: int) -> Extreme:
    from scipy.stats import gumbel_r

    if blocks < LEAST_BLOCKS:
        raise UndefinedError(f"{blocks:g} parts are too few: {LEAST_BLOCKS} are needed")
    weights(time)
    edges = np.linspace(time[0], time[-1], blocks + 1)
    starts = np.searchsorted(time, edges[:-1])
    if (np.diff([*starts, len(time)]) < LEAST_BLOCKS).any():
        raise UndefinedError(f"the record has {len(time)} rows: too few for {blocks} parts")
    largest = np.maximum.reduceat(run, starts)
    if np.ptp(largest) == 0.0:
        raise UndefinedError(f"all parts have the largest value {largest[0]:g}")
    at, scale = map(float, gumbel_r.fit(largest))
    log = math.log(duration / float(edges[1] - edges[0]))
    mode = at + scale * log

    def quantile(probability: float) -> float:
        return mode - scale * math.log(-math.log(probability))

    ratio = 6.0 / math.pi**2
    variance = 1.0 + ratio * (1.0 - np.euler_gamma + log) ** 2  # of the mode, by scale²/blocks
    error = scale * math.sqrt(variance / blocks)
    expected = mode + np.euler_gamma * scale
    return Extreme("Gumbel", duration, mode, expected, error, quantile)


def _with_error(found: Extreme, error: float) -> Extreme:
    return replace(found, error=error)


def most_probable_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mode of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    return gaussian_of(time, run, duration).most_probable


def expected_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mean of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    return gaussian_of(time, run, duration).expected


def maximum_quantile(time: Floats, run: Floats, *, duration: float, probability: float) -> float:
    """Quantile of the Gaussian largest value over a `duration` [s], in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    return gaussian_of(time, run, duration).quantile(probability)


def weibull_maximum(time: Floats, run: Floats, *, duration: float) -> float:
    """Mode of the largest value over a `duration` [s] by a Weibull tail, in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    return _weibull(time, run, duration).most_probable


def gumbel_maximum(time: Floats, run: Floats, *, duration: float, blocks: float) -> float:
    """Mode of the largest value over a `duration` [s] by Gumbel's fit, in the unit of `run`.

    `run` (n,), in its unit, at `time` (n,) [s]; `blocks` is the number of parts.
    """
    return _gumbel(time, run, duration, int(blocks)).most_probable
