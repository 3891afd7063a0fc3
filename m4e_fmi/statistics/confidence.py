"""Confidence intervals of means over seeds: Student's t."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError
from m4e_fmi.shown import short
from m4e_fmi.statistics.record import Floats


@short
@dataclass(frozen=True)
class Interval:
    """Means over seeds and their intervals from `low` to `high`, (…,) in the unit of the values.

    `error` is the standard error of the mean. Both are nan for one seed, and where a value is nan.
    """

    mean: Floats
    error: Floats
    low: Floats
    high: Floats
    level: float
    seeds: int

    @property
    def half_width(self) -> Floats:
        """Half the width of the interval, (…,) in the unit of the values."""
        return 0.5 * (self.high - self.low)


def confidence_interval(values: ArrayLike, level: float = 0.95) -> Interval:
    """Interval that holds the mean of all seeds with probability `level`, of normal values.

    `values` (…, n_seeds), in their unit. x̄ ± t s/√n, t of Student's distribution with n − 1
    degrees of freedom. InputError for no seeds, and a level that is not between 0 and 1.
    """
    from scipy.stats import t as student

    x = np.asarray(values, dtype=float)
    if not 0.0 < level < 1.0:
        raise InputError.single(f"the level is {level:g}, expected one between 0 and 1", "as 0.95")
    if x.ndim < 1 or x.shape[-1] < 1:
        raise InputError.single("there are no seeds", "give values (…, n_seeds)")
    seeds = x.shape[-1]
    mean = x.mean(axis=-1)
    error = np.full_like(mean, np.nan)
    width = np.full_like(mean, np.nan)
    if seeds > 1:
        error = np.asarray(x.std(axis=-1, ddof=1) / np.sqrt(seeds))
        width = float(student.ppf(0.5 + 0.5 * level, seeds - 1)) * error
    return Interval(mean, error, mean - width, mean + width, level, seeds)
