"""Criterion of instability: which recorded quantity grows without bound, since when, how fast.

A quantity of an unstable system grows by the same factor in equal times, or by more and more. What
else becomes large does not: a ramp, a free fall and a launch take longer for each further factor
of ten, a jump takes one sample, and what settles at a limit grows no more. Of the envelope (the
largest magnitude so far) the times are compared at which it has passed factors of ten.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

SLOWER = 2.0
"""How much longer the second half of the decades may take than the first. The power t**n takes
10**(D/2n) times as long: with 4 decades up to the sixth power is told from exponential growth."""
FASTER = 2.5
"""How much shorter it may be, unless the growth is as in STEEP."""
STEEP, STEEP_RISES, EASING = 2.0, 3, 0.7
"""A factor from sample to sample, in so many at the end, and how far its rate (1/s) may fall from
one to the next: fast growth is told by that. Doubled times give a power of t half the rate."""
LARGEST_RISE = 1 / 3
"""Share of the decades that may lie between two samples."""


@dataclass(frozen=True)
class Growth:
    """`name` grew from magnitude `low` at time `since` to `high` at `until` [s], without an end."""

    name: str
    since: float
    low: float
    until: float
    high: float

    @property
    def decades(self) -> float:
        """Factors of ten by which it grew."""
        return float(np.log10(self.high / self.low))

    @property
    def tenfold(self) -> float:
        """Time [s] in which it grew tenfold."""
        return (self.until - self.since) / self.decades

    def text(self, description: str = "", unit: str = "") -> str:
        """The growth in words."""
        unit = "" if unit in ("", "1") else f" {unit}"
        what = f" ({description})" if description else ""
        return (
            f"{self.name}{what} grew from {self.low:.3g}{unit} at t = {self.since:.6g} s to "
            f"{self.high:.3g}{unit} at t = {self.until:.6g} s, tenfold every {self.tenfold:.2g} s"
        )


def growth(name: str, times: np.ndarray, values: np.ndarray, *, decades: float) -> Growth | None:
    """The growth without bound of one quantity up to its last sample, by `decades` at least.

    `times` (n,) [s] ascend; `values` (n,), in any unit, are taken by their magnitudes, up to the
    first that is not finite. None if it does not grow so.
    """
    size = np.abs(values)
    bad = np.flatnonzero(~np.isfinite(size))
    size = size[: bad[0]] if bad.size else size
    times = times[: len(size)]
    envelope = np.maximum.accumulate(size)
    times, envelope = times[envelope > 0.0], envelope[envelope > 0.0]
    if len(envelope) <= STEEP_RISES:
        return None
    level = np.log10(envelope)
    if level[-1] - level[0] < decades:
        return None
    first, last = _steep(times, level), len(level) - 1
    if level[last] - level[first] >= decades:
        (since, low), (until, high) = ((float(times[k]), float(envelope[k])) for k in (first, last))
        return Growth(name, since, low, until, high)
    return _sustained(name, times, level, decades)


def _steep(times: np.ndarray, level: np.ndarray) -> int:
    """From which sample on there is a large factor from each to the next, at no lower rate."""
    rise = np.diff(level)
    rate = rise / np.diff(times)
    first = len(level) - 1
    while first > 0 and rise[first - 1] >= np.log10(STEEP):
        if first < len(rise) and rate[first] < EASING * rate[first - 1]:
            break
        first -= 1
    return first if len(level) - 1 - first >= STEEP_RISES else len(level) - 1


def _sustained(name: str, times: np.ndarray, level: np.ndarray, least: float) -> Growth | None:
    """The longest growth up to the end in which each factor of ten took about the same time."""
    top = level[-1]
    reached = times[np.searchsorted(level, top)]
    last = np.append(np.flatnonzero(np.diff(level) > 0.0), len(level) - 1)  # of each plateau
    at = times[last].copy()
    at[-1] = reached

    def when(decades: float) -> float:
        return float(np.interp(top - decades, level[last], at))

    waiting = times[-1] - reached
    for count in np.arange(np.floor(2 * (top - level[0])) / 2, least - 0.25, -0.5):
        begin, middle = when(count), when(count / 2)
        slow, fast = middle - begin, reached - middle
        rises = np.diff(level[np.searchsorted(level, top - count, side="right") - 1 :])
        if (
            fast <= SLOWER * slow
            and slow <= FASTER * fast
            and rises.max() <= LARGEST_RISE * count
            and waiting <= max((reached - begin) / count, 2 * (times[-1] - times[-2]))
        ):
            return Growth(name, begin, 10 ** float(top - count), float(times[-1]), 10 ** float(top))
    return None


def largest_growth(
    times: np.ndarray, columns: Mapping[str, np.ndarray], *, decades: float
) -> Growth | None:
    """The growth by most decades among `columns`, (n,) each, in any unit, at `times` (n,) [s]."""
    found = (growth(name, times, values, decades=decades) for name, values in columns.items())
    return max((one for one in found if one), key=lambda one: one.decades, default=None)
