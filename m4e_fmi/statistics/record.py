"""Records of one or more runs, checked, and the weights of their rows in the time.

`UndefinedError` is the reason where a statistic of one is not defined.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.errors import InputError

Floats = NDArray[np.float64]
Found = TypeVar("Found")
CONSTANT = 1e-12
"""Range over the largest magnitude up to which values count as constant: rounding."""

SMALLEST, LARGEST = 1e-60, 1e60
"""Range up to which values count as constant, and largest magnitude: fourth powers are finite."""
LEAST_STEPS = 15
"""Steps of a record of which a spectrum is made."""
LONGEST_STEP = 1.5
"""Longest step over the median one in rows that count as equally spaced."""


class UndefinedError(ValueError):
    """A statistic of a record is not defined; the text is the reason."""


def checked_runs(time: ArrayLike, values: ArrayLike) -> tuple[Floats, Floats]:
    """`time` (n,) [s] and `values` (m, n) of m runs, in their unit, as floats; (n,) is one run.

    Rows at equal times, before and after an event, are accepted. InputError for arrays that do not
    fit each other, no rows, times that decrease or are not finite.
    """
    t, x = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    if t.ndim != 1 or x.ndim not in (1, 2) or x.shape[-1:] != t.shape:
        message = f"time and values do not fit each other: {t.shape} and {x.shape}"
        raise InputError.single(message, "give times (n,) and values (n,) or (m, n)")
    if not len(t):
        raise InputError.single("the record has no rows")
    bad = np.flatnonzero(~np.isfinite(t))
    if len(bad):
        raise InputError.single(f"the time in row {bad[0]} is not finite", "leave such rows out")
    back = np.flatnonzero(np.diff(t) < 0.0)
    if len(back):
        k = int(back[0]) + 1
        message = f"the time decreases in row {k}: {t[k - 1]:g} s, then {t[k]:g} s"
        raise InputError.single(message, "sort the rows")
    return t, x.reshape(-1, len(t))


def of_one_run(
    time: ArrayLike, values: ArrayLike, found: Callable[[Floats, Floats], Found]
) -> Found:
    """The result of `found` for the record `values` (n,), in their unit, at `time` (n,) [s].

    InputError as `checked_runs`, for several runs, values that are not finite, and where it is not
    defined.
    """
    t, x = checked_runs(time, values)
    if len(x) != 1:
        raise InputError.single(f"expected the values of one run, got {len(x)} runs")
    try:
        check_finite(t, x[0])
        return found(t, x[0])
    except UndefinedError as error:
        raise InputError.single(str(error)) from None


def check_finite(time: Floats, run: Floats) -> None:
    """UndefinedError unless all of `run` (n,), in its unit, at `time` (n,) [s] are finite.

    And of a magnitude whose square is finite.
    """
    bad = np.flatnonzero(~np.isfinite(run))
    if len(bad):
        raise UndefinedError(
            f"{len(bad)} of {len(run)} rows are not finite, the first at t = {time[bad[0]]:g} s"
        )
    if (largest := float(np.max(np.abs(run)))) > LARGEST:
        raise UndefinedError(f"the largest magnitude is {largest:.3g}: out of all scale")


def weights(time: Floats) -> Floats:
    """Share of each row in the time of a record (n,) [1]: half the steps beside it (trapezoids).

    UndefinedError for a record without duration.
    """
    steps = np.diff(time)
    if not len(steps) or time[-1] <= time[0]:
        raise UndefinedError("the record has no duration: two rows at different times are needed")
    share = np.zeros(len(time))
    share[:-1] += 0.5 * steps
    share[1:] += 0.5 * steps
    return share / (time[-1] - time[0])


def even_rows(time: Floats, run: Floats) -> tuple[float, Floats]:
    """The step [s], and `run` (n,), in its unit, in rows (k,) with equal steps from the first on.

    The step is the median of those of `time` (n,) [s]. Rows between, as those of events, are left
    out, others interpolated linearly in `run` (n,). UndefinedError for fewer than 16 rows, and
    where a step is longer than the median by half or more.
    """
    steps = np.diff(time)
    steps = steps[steps > 0.0]
    if len(steps) < LEAST_STEPS:
        raise UndefinedError(f"the record has {len(steps)} steps, {LEAST_STEPS} are needed")
    step = float(np.median(steps))
    if steps.max() >= LONGEST_STEP * step:
        raise UndefinedError(
            f"its time steps differ: most are {step:.4g} s, the longest {steps.max():.4g} s"
        )
    count = int((time[-1] - time[0]) / step * (1.0 + 1e-9)) + 1
    return step, np.interp(time[0] + step * np.arange(count), time, run)


def is_constant(run: Floats) -> bool:
    """True if `run` (n,), in its unit, varies by no more than rounding."""
    return bool(np.ptp(run) <= max(CONSTANT * np.max(np.abs(run)), SMALLEST))


def check_varies(run: Floats) -> None:
    """UndefinedError if `run` (n,), in its unit, is constant."""
    if is_constant(run):
        raise UndefinedError(f"the record is constant: {run[0]:g}")
