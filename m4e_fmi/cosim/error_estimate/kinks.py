"""Kinks of a run: the steps on which they act, the events that cause them, their error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from m4e_fmi.cosim.error_estimate.repeated_steps import FAR, ROUNDING, Recorded
from m4e_fmi.cosim.error_estimate.roughness import HISTORY, fourth_differences

BEFORE, AFTER = 2, 2
"""Steps before and after one that is suddenly rough on which its kink may act."""
NOISE = 8 * ROUNDING
"""Share of the largest value up to which a fourth difference may be rounding."""
SMALL = 0.1
"""Share of the known error up to which a kink is ignored."""
RESOLVED = 0.3
"""Difference over range up to which the order of an algorithm shows."""
GROWN = 2.0
"""Difference over range above which it is not that of values within the range any more."""


def about(kinks: np.ndarray, steps: int) -> np.ndarray:
    """Indices (m,), of so many steps, of those on which `kinks` (k,), indices, may act."""
    near = (kinks[:, None] + np.arange(-BEFORE, AFTER + 1)).ravel()
    return np.unique(near[(near >= 0) & (near < steps)])


def events(kinks: np.ndarray) -> int:
    """Number of events that cause `kinks` (k,), indices of steps in order.

    Kinks that act on each other's steps belong to one event.
    """
    return int(len(kinks) > 0) + int((np.diff(kinks) > BEFORE + AFTER).sum())


def first_of_each(kinks: np.ndarray) -> np.ndarray:
    """Indices (m,) of the first kink of each event, of `kinks` (k,), indices in order."""
    return kinks[np.diff(kinks, prepend=-FAR) > BEFORE + AFTER]


def first_events(kinks: np.ndarray, count: int) -> np.ndarray:
    """Indices (m,) of the kinks of the first `count` events, of `kinks` (k,), indices in order."""
    number = np.concatenate([[0], np.cumsum(np.diff(kinks) > BEFORE + AFTER)])[: len(kinks)]
    return kinks[number < count]


def roughness_at(steps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Fourth differences (k, n) at the ends of `steps` (k,), indices, or the first that is known.

    They are those of `values` (m, n), in the units of these.
    """
    return fourth_differences(values)[np.clip(steps + 1, HISTORY, len(values) - 1)]


def rougher(kinks: np.ndarray, run: Recorded, least: np.ndarray) -> np.ndarray:
    """Indices (m,) of those `kinks` (k,), indices, that are rougher than a limit in some output.

    That is `least` (n,), in the outputs' units.
    """
    if not len(kinks):  # most stretches have none, and the differences are of all their steps
        return kinks
    return kinks[np.any(roughness_at(kinks, run.values) > least, axis=1)]


def smooth_roughness(run: Recorded, kinks: np.ndarray, jumps: Sequence[int]) -> np.ndarray:
    """Largest fourth difference (n,) of each output away from kinks and jumps, in its unit.

    `kinks` (k,) are indices of steps, `jumps` are times [ns].
    """
    found = fourth_differences(run.values)
    uneven = np.flatnonzero(np.diff(np.diff(run.times))) + 1
    last = np.searchsorted(run.times, jumps) - 1
    steps = np.concatenate([about(kinks, run.steps), last, uneven]).astype(np.intp)
    after = (steps[:, None] + 1 + np.arange(HISTORY + 1)).ravel()
    found[after[after <= run.steps]] = 0.0
    return found.max(axis=0)


def halved_kinks(errors: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """Errors (n,) of kinks at half the step, of first order; all in the outputs' units.

    A jump that comes at another point is an error of its size, about the range, however short the
    steps. Beyond that it is growth, and the step is too long. `errors` (n,) are those at the whole
    step, `spans` (n,) the ranges of the units; all in the outputs' units.
    """
    jumps = (errors > RESOLVED * spans) & (errors <= GROWN * spans)
    return errors * np.where(jumps, 1.0, 0.5)
