"""Wanted statistics of recorded series."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from m4e_fmi.statistics import STATISTICS
from m4e_fmi.study.given.study import Wanted


def computed(
    wanted: Sequence[Wanted],
    time: np.ndarray,
    values: Mapping[str, np.ndarray],
    start_up: float,
) -> tuple[dict[str, np.ndarray], dict[str, tuple[str, ...]]]:
    """Statistics (m,) of m runs by name, in their units, and why they are nan.

    `time` (n,) [s], `values` (m, n) by variable, in their units; those before `start_up` [s] do not
    count.
    """
    after = time >= start_up
    counted = slice(None) if np.all(after) else after  # no copies of all
    found: dict[str, np.ndarray] = {}
    reasons: dict[str, tuple[str, ...]] = {}
    for one in wanted:
        statistic = STATISTICS[one.statistic]
        explained = statistic.explained(
            time[counted], values[one.variable][:, counted], **dict(one.parameters)
        )
        found[one.name] = explained.values
        reasons[one.name] = explained.reasons
    return found, reasons
