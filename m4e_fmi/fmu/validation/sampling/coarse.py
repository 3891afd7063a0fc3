"""Solvers inside FMUs that advance in fixed steps of their own: coarse, but not wrong.

Between two samples the mean rate of such a solution lies between the rates at both ends, whatever
the method: at the first end for explicit Euler, at the last for implicit Euler.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.fmu.validation.sampling.differences import SAFETY

EXCEPTIONS = 0.25
"""Part of the intervals, at most, in which a coarse solution may leave its rates: events."""


def stands(samples: np.ndarray) -> np.ndarray:
    """Columns, as booleans (n,), that hold in some intervals and move in others.

    `samples` (n_times, n) are in the variables' units.
    """
    same = np.diff(samples, axis=0) == 0.0
    return same.any(axis=0) & ~same.all(axis=0)


def follows(samples: np.ndarray, rates: np.ndarray, spacing: float) -> np.ndarray:
    """Columns that change between two rows as the rates at both rows allow: booleans (n,).

    `samples` and `rates` (n_times, n), in the variables' units, and these per second. Rows are
    `spacing` [s] apart. Between the rows a smooth rate exceeds both ends by an eighth of its second
    difference at most; twice that is allowed. A column that holds in some intervals may be late by
    one interval.
    """
    means = np.diff(samples, axis=0) / spacing
    ends = np.array([rates[:-1], rates[1:]])
    bends = np.max(np.abs(np.diff(rates, 2, axis=0)), axis=0)
    slack = bends / 4 + SAFETY * np.finfo(float).eps * (
        np.max(np.abs(rates), axis=0) + np.max(np.abs(samples), axis=0) / spacing
    )
    inside = (means >= ends.min(axis=0) - slack) & (means <= ends.max(axis=0) + slack)
    regular = np.mean(~inside, axis=0) <= EXCEPTIONS
    # as a sum over all intervals: the mean of both ends, half their difference, one interval more
    total = np.abs(np.sum(means - ends.mean(axis=0), axis=0))
    allowed = np.sum(np.ptp(ends, axis=0) / 2 + slack, axis=0) + np.max(np.abs(rates), axis=0)
    return regular | (stands(samples) & (total <= allowed))
