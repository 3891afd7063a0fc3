"""Means over the seeds of many designs."""

from __future__ import annotations

import numpy as np

from m4e_fmi.statistics.confidence import confidence_interval


def means_of_designs(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean (…) and half-width (…) of `values` (…, n_seeds), in their unit, and missing ones [1].

    The half-width is that of 95 % confidence by Student's t, nan for one seed. Values that are nan
    are missing (…); the mean is over the others, nan if there are none.
    """
    missing = np.isnan(values).sum(axis=-1)
    mean, width = np.full(missing.shape, np.nan), np.full(missing.shape, np.nan)
    for lacking in np.unique(missing):
        left = values.shape[-1] - int(lacking)
        if not left:
            continue
        alike = missing == lacking
        rows = values[alike]
        interval = confidence_interval(rows[~np.isnan(rows)].reshape(-1, left))
        mean[alike], width[alike] = interval.mean, interval.half_width
    return mean, width, missing
