"""Mean, deviation and other statistics of the values of one run, by the weights of its rows.

The share is half the steps beside a row (trapezoidal rule), so that rows in unequal steps, and the
two rows of an event, count as long as they last.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.statistics.record import Floats, weights


def mean(time: Floats, run: Floats) -> float:
    """Mean over time of `run` (n,), in its unit, at `time` (n,) [s]."""
    return float(weights(time) @ run)


def standard_deviation(time: Floats, run: Floats) -> float:
    """Standard deviation over time of `run` (n,), in its unit, at `time` (n,) [s]."""
    share = weights(time)
    return float(np.sqrt(share @ (run - share @ run) ** 2))


def rms(time: Floats, run: Floats) -> float:
    """Root of the mean square over time of `run` (n,), in its unit, at `time` (n,) [s]."""
    return float(np.sqrt(weights(time) @ run**2))


def percentile(time: Floats, run: Floats, *, percent: float) -> float:
    """Value below which `run` (n,), in its unit, at `time` (n,) [s], is for `percent` of the time.

    Interpolated between the sorted rows, each at the middle of its share (of equal rows: Hazen's
    definition).
    """
    share, order = weights(time), np.argsort(run, kind="stable")
    share = share[order]
    kept = share > 0.0
    middle = (np.cumsum(share) - 0.5 * share)[kept]
    return float(np.interp(percent / 100.0, middle, run[order][kept]))


def time_above(time: Floats, run: Floats, *, level: float) -> float:
    """Share of the time [1] in which `run` (n,), in its unit, at `time` (n,) [s] is above `level`.

    Crossings of the level are interpolated between the rows.
    """
    weights(time)
    steps = np.diff(time)
    high, low = np.maximum(run[1:], run[:-1]), np.minimum(run[1:], run[:-1])
    rise = np.where(high > low, high - low, 1.0)
    part = np.where(high > low, np.clip((high - level) / rise, 0.0, 1.0), high > level)
    return float(part @ steps / (time[-1] - time[0]))


def number_above(time: Floats, run: Floats, *, level: float) -> float:
    """Number [1] of times that `run` (n,), in its unit, at `time` (n,) [s] rises above `level`.

    As of impacts by their force, or of waves on a deck. A record that begins above the level has
    not risen to it; what happens between two rows is not seen.
    """
    weights(time)
    return float(np.count_nonzero((run[:-1] <= level) & (run[1:] > level)))
