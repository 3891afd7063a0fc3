"""Two records at the same times: those of the coarser one, where both have rows.

Between the rows of the finer record it is interpolated: by the cubic polynomial through the four
nearest rows where the record is smooth, by a straight line elsewhere, and not beyond its ends nor
over gaps. It is smooth between two rows if for both the cubic polynomial through their four
neighbours is nearer to the row than the straight line through two of them. How far they miss a row
gives the error of the interpolation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.points import Floats
from m4e_fmi.shown import short

SAME = 1e-6
"""Part of a step within which two times are the same."""
LONG_STEP = 10.0
"""Longest step over the median one that counts as no gap."""
ROUNDING = 1e-12
"""Part of the range of a record that is rounding."""
CUBIC, LINEAR = 1.0 / 16.0, 1.0 / 4.0
"""Errors in the middle between rows over those at a row that is left out, whose gap is double."""


@short
@dataclass(frozen=True)
class Aligned:
    """`values` and `reference` (k,) [their unit] at `time` (k,) [s].

    `left_out` counts times within the common interval at which a record has a gap or a long step,
    `lacking` those of them at which the reference has none.
    `interpolated` is how: empty if both have the same rows. `error` estimates the root mean square
    of what the interpolation adds, in the unit.
    """

    time: Floats
    values: Floats
    reference: Floats
    left_out: int
    lacking: int
    interpolated: str
    error: float


def aligned(
    time: Floats,
    values: Floats,
    other_time: Floats,
    other: Floats,
    *,
    between: tuple[float, float] = (-np.inf, np.inf),
    held: bool = False,
) -> Aligned:
    """Both records at the times of the coarser one; `time` (n,) [s], `values` (n,) [their unit].

    `other_time` (m,) [s] and `other` (m,), in the same unit, are the reference. Times increase;
    values that are not finite are gaps. `held` values hold from row to row. Only times `between`
    two [s] count.
    """
    low = max(time[0], other_time[0], between[0])
    high = min(time[-1], other_time[-1], between[1])
    within = [(t >= low) & (t <= high) for t in (time, other_time)]
    second = int(within[1].sum()) < int(within[0].sum())  # the reference is the coarser one
    coarse_time, coarse = (other_time, other) if second else (time, values)
    fine_time, fine = (time, values) if second else (other_time, other)
    at = coarse_time[within[int(second)]]
    known = coarse[within[int(second)]]
    found, how, error = _at(fine_time, fine, at, held=held)
    kept = np.isfinite(known) & np.isfinite(found)
    lacking = int(np.isfinite(known if second else found).sum() - kept.sum())
    in_gaps = _in_gaps(coarse_time, fine_time[within[int(not second)] & np.isfinite(fine)])
    left_out = int(np.sum(~kept)) + in_gaps
    lacking += 0 if second else in_gaps
    at, known, found = at[kept], known[kept], found[kept]
    first, reference = (found, known) if second else (known, found)
    return Aligned(at, first, reference, left_out, lacking, how, error)


def _in_gaps(time: Floats, at: Floats) -> int:
    """How many of the times `at` (k,) [s] are inside of long steps of `time` (n,) [s]."""
    if len(time) < 2:
        return 0
    steps = np.diff(time)
    step = float(np.median(steps))
    near = np.clip(np.searchsorted(time, at), 1, len(steps)) - 1
    inside = (at > time[near] + SAME * step) & (at < time[near + 1] - SAME * step)
    return int(np.sum(inside & (steps[near] > LONG_STEP * step)))


def _at(time: Floats, values: Floats, at: Floats, *, held: bool) -> tuple[Floats, str, float]:
    """Values at times within the record (k,), nan in gaps; how, and the error."""
    there = np.isfinite(values)
    t, x = time[there], values[there]
    found = np.full(len(at), np.nan)
    if not len(t) or not len(at):
        return found, "", 0.0
    steps = np.diff(t)
    near = np.clip(np.searchsorted(t, at), 1, max(len(t) - 1, 1)) - 1
    step = float(np.median(np.diff(time))) if len(time) > 1 else 1.0
    for k in (near, np.minimum(near + 1, len(t) - 1)):  # rows at these times
        same = np.abs(t[k] - at) <= SAME * step
        found[same] = x[k[same]]
    between = np.isnan(found) & (at > t[0]) & (at < t[-1])
    if len(t) > 1:
        row = np.flatnonzero(there)
        between &= (np.diff(row)[near] == 1) & (steps[near] <= LONG_STEP * step)
    if not between.any():
        return found, "", 0.0
    near, at = near[between], at[between]
    if held:
        found[between] = x[near]
        return found, "held from row to row", 0.0
    found[between], smooth, error = _interpolated(t, x, at, near)
    share = 100.0 * float(np.mean(smooth))
    how = "cubic" if share == 100.0 else "linear" if share == 0.0 else f"cubic at {share:.0f} %"
    rest = "" if share in (0.0, 100.0) else " of the times, linear at the others"
    return found, how + rest, error


def _interpolated(
    t: Floats, x: Floats, at: Floats, near: np.ndarray
) -> tuple[Floats, np.ndarray, float]:
    """Values at times after the rows `near`, where they are cubic, and their error."""
    part = (at - t[near]) / (t[near + 1] - t[near])
    linear = x[near] + part * (x[near + 1] - x[near])
    if len(t) < 5:
        return linear, np.zeros(len(at), bool), 0.0
    # how far rows 2 … n − 3 are from the cubic and the line through their neighbours, (n − 4,)
    inner = np.arange(2, len(t) - 2)
    four = inner[:, None] + np.array([-2, -1, 1, 2])
    two = four[:, 1:3]
    miss_cubic = np.abs(x[inner] - _lagrange(t[four], x[four], t[inner]))
    miss_linear = np.abs(x[inner] - _lagrange(t[two], x[two], t[inner]))
    smooth_row = np.zeros(len(t), bool)
    smooth_row[2:-2] = miss_cubic <= miss_linear + ROUNDING * np.ptp(x)
    smooth_row[:2], smooth_row[-2:] = smooth_row[2], smooth_row[-3]
    smooth = smooth_row[near] & smooth_row[near + 1]
    begin = np.clip(near - 1, 0, len(t) - 4)
    rows = begin[:, None] + np.arange(4)
    cubic = _lagrange(t[rows], x[rows], at)
    middle = np.clip(near, 2, len(t) - 3) - 2
    errors = np.where(smooth, CUBIC * miss_cubic[middle], LINEAR * miss_linear[middle])
    return np.where(smooth, cubic, linear), smooth, float(np.sqrt(np.mean(errors**2)))


def _lagrange(t: Floats, x: Floats, at: Floats) -> Floats:
    """Polynomials through the rows (k, p) of `t` and `x`, at (k,)."""
    total = np.zeros(len(at))
    for i in range(t.shape[1]):
        factor = np.ones(len(at))
        for j in range(t.shape[1]):
            if j != i:
                factor *= (at - t[:, j]) / (t[:, i] - t[:, j])
        total += factor * x[:, i]
    return total
