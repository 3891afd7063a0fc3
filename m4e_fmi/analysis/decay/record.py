"""A record of a free decay: its checks, its peaks, the part of it that is fitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.errors import InputError
from m4e_fmi.results.compared_file import LEAVE_OUT

Floats = NDArray[np.float64]

LEAST_SWING = 0.03
"""Of the largest swing: smaller ones are no peaks."""
NOISE = 6.0
"""Swing between peaks, over the standard deviation of white noise, at least."""
NOISY, SIXTEENTH = 0.005, 16
"""White noise over the range of a record above which it is smoothed, over this part of a period."""
ABOUT = 0.95
"""Distance from rest, over the largest, of the first peak that counts as the release."""
GROWTH = 1.2
"""Last distance from rest over the first, above which a motion grows."""
SETTLED = 0.05
"""Range of the last fifth of a record, over that of all, below which the motion is at rest."""
LEAST_ROWS = 12
"""For six parameters and a process of noise."""
REMEDY = "give a longer record, or fit another part of it"


class Window(NamedTuple):
    """Times [s] between which a record is fitted, and the reason in words."""

    start: float
    end: float
    reason: str


@dataclass(frozen=True)
class Peaks:
    """Highest and lowest points in turn: `time` (k,) [s] and `values` (k,), in the motion's unit.

    `amplitudes` are half the distances between neighbours; `decrements` the logarithms of an
    amplitude over the next, at the geometric mean `between` of both.
    """

    time: Floats
    values: Floats

    def after(self, time: float) -> Peaks:
        """Those from a `time` [s] on."""
        kept = self.time >= time
        return Peaks(self.time[kept], self.values[kept])

    @property
    def amplitudes(self) -> Floats:
        """Half the distances of neighbouring peaks, (k - 1,) [unit of the motion]."""
        return 0.5 * np.abs(np.diff(self.values))

    @property
    def decrements(self) -> Floats:
        """Logarithmic decrements of half a period, (k - 2,) [1]."""
        return -np.diff(np.log(self.amplitudes))

    @property
    def ratios(self) -> Floats:
        """Damping ratios δ/√(π² + δ²) of the decrements δ, (k - 2,) [1]."""
        return self.decrements / np.sqrt(np.pi**2 + self.decrements**2)

    @property
    def between(self) -> Floats:
        """Amplitudes that the decrements are of, (k - 2,) [unit of the motion]."""
        return np.sqrt(self.amplitudes[1:] * self.amplitudes[:-1])


def checked(time: ArrayLike, motion: ArrayLike) -> tuple[Floats, Floats]:
    """`time` (n,) [s] and `motion` (n,) [its unit] of a record that can be fitted, as floats.

    InputError for arrays of different length, values that are not finite, a time that does not
    increase, a motion that does not move.
    """
    t, x = np.asarray(time, dtype=float), np.asarray(motion, dtype=float)
    if t.ndim != 1 or t.shape != x.shape:
        message = f"time and motion are not of one length: {t.shape} and {x.shape}"
        raise InputError.single(message, "give two arrays (n,)")
    if len(t) < LEAST_ROWS:
        raise InputError.single(f"the record has {len(t)} rows, at least {LEAST_ROWS} are needed")
    bad = np.flatnonzero(~np.isfinite(t) | ~np.isfinite(x))
    if len(bad):
        message = f"row {bad[0]} of the record is not finite (t = {t[bad[0]]:g} s)"
        raise InputError.single(message, LEAVE_OUT)
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        k = int(back[0]) + 1
        message = f"the time does not increase in row {k}: {t[k - 1]:g} s, then {t[k]:g} s"
        raise InputError.single(message, "sort the rows, and leave out those that are there twice")
    if np.ptp(x) == 0.0:
        raise InputError.single(f"nothing moves: the motion is {x[0]:g} throughout")
    return t, x


def white_noise(values: Floats) -> float:
    """Standard deviation of the white noise in `values` (n,), in their unit.

    From their fourth differences, in which a motion with many rows per period is negligible.
    """
    return float(np.median(np.abs(np.diff(values, 4)))) / (0.6745 * np.sqrt(70.0))


def smoothed(values: Floats) -> Floats:
    """Means of `values` (n,), in their unit, over a 16th of their main period, if they are noisy.

    Rows count as equally spaced.
    """
    if white_noise(values) < NOISY * float(np.ptp(values)):
        return values
    lines = np.abs(np.fft.rfft(values - values.mean()))
    rows = len(values) // (SIXTEENTH * int(np.argmax(lines[1:]) + 1))
    window = np.ones(2 * (rows // 2) + 1)
    counts = np.convolve(np.ones(len(values)), window, "same")
    return np.convolve(values, window, "same") / counts


def find_peaks(time: Floats, values: Floats, least: float, *, width: float = 0.0) -> Peaks:
    """Peaks of `values` (n,) at `time` (n,) [s] that the motion leaves by at least `least`.

    Values and `least` are in the motion's unit. The first row is a peak if the motion leaves it,
    the last one is none. Peaks are the vertices of parabolas through the rows within `width` [s],
    or through three rows if these are more.
    """
    found: list[int] = []
    high = low = best = way = 0
    for k, value in enumerate(values.tolist()):
        if way == 0:
            high = k if value > values[high] else high
            low = k if value < values[low] else low
            if max(values[high] - value, value - values[low]) < least:
                continue
            way = 1 if values[high] - value >= least else -1
            best = high if way > 0 else low
        if way * (value - values[best]) > 0.0:
            best = k
        elif way * (values[best] - value) >= least:
            found.append(best)
            way, best = -way, k
    places = [_vertex(time, values, k, width) for k in found]
    return Peaks(np.array([p[0] for p in places]), np.array([p[1] for p in places]))


def _vertex(time: Floats, values: Floats, k: int, width: float) -> tuple[float, float]:
    """Time and height of the peak at row k; of row k itself at the ends."""
    if not 0 < k < len(values) - 1:
        return float(time[k]), float(values[k])
    first = min(int(np.searchsorted(time, time[k] - width)), k - 1)
    last = max(int(np.searchsorted(time, time[k] + width)), k + 2)
    t = time[first:last] - time[k]
    a, b, c = np.polyfit(t, values[first:last], 2).tolist()
    at = -b / (2.0 * a) if a else 0.0
    if not t[0] < at < t[-1]:
        return float(time[k]), float(values[k])
    return float(time[k] + at), c + 0.5 * b * at


@dataclass(frozen=True)
class Part:
    """The rows of a record that are fitted: `rows`, its `window`, `peaks` from there on.

    `rest` is about where the motion comes to rest, `release` its largest distance from there, both
    in the motion's unit.
    """

    rows: slice
    window: Window
    peaks: Peaks
    rest: float
    release: float


def part_of(time: Floats, values: Floats, start: float | None, end: float | None) -> Part:
    """The part of a record, `values` (n,) in the motion's unit at `time` (n,) [s], that is fitted.

    From `start` to `end` [s] if they are given; else from the first peak after the release, which
    is the first of those that are as far from rest as the farthest. InputError without two peaks
    after it.
    """
    given = _given(time, start, end)
    t, x = time[given], smoothed(values[given])
    least = max(LEAST_SWING * float(np.ptp(x)), NOISE * white_noise(x))
    peaks = find_peaks(t, x, least)
    if len(peaks.time) < 2:
        raise _no_peaks(t, x, len(peaks.time))
    rest = _rest(peaks, x)
    away = np.abs(peaks.values - rest)
    released = int(np.argmax(away >= ABOUT * away.max()))
    if start is None:
        after = len(peaks.time) - 1 - released
        if after < 2 and released > 2:
            raise _grows(float(peaks.time[0]), float(peaks.time[released]))
        if after < 2:
            raise _no_peaks(t, x, after)
        first = released + 1 if len(away) - released > 3 else released
        reason = "from the first peak after the release" if first > released else "from the release"
        begin = float(peaks.time[first])
    else:
        cut = len(away) > 2 and peaks.time[0] == t[0]  # the first row need not be a peak
        first, reason, begin = int(cut), "as given", start
        if len(away) > 2 and away[-1] > GROWTH * away[first]:
            raise _grows(float(t[0]), float(t[-1]))
    rows = slice(int(np.searchsorted(time, begin)), given.stop)
    if rows.stop - rows.start < LEAST_ROWS:
        text = f"{rows.stop - rows.start} rows from {begin:g} s on"
        raise InputError.single(f"the record has {text}, at least {LEAST_ROWS} are needed", REMEDY)
    window = Window(float(time[rows][0]), float(time[rows][-1]), reason)
    kept = Peaks(peaks.time[first:], peaks.values[first:])
    return Part(rows, window, kept, rest, float(away.max()))


def _given(time: Floats, start: float | None, end: float | None) -> slice:
    """The rows between `start` and `end` [s]; InputError if there are too few."""
    low = float(time[0]) if start is None else start
    high = float(time[-1]) if end is None else end
    first, last = np.searchsorted(time, low), np.searchsorted(time, high, side="right")
    if last - first < LEAST_ROWS:
        raise InputError.single(
            f"the record has {max(0, last - first)} rows from {low:g} to {high:g} s, at least "
            f"{LEAST_ROWS} are needed",
            f"it goes from {time[0]:g} to {time[-1]:g} s",
        )
    return slice(int(first), int(last))


def _rest(peaks: Peaks, values: Floats) -> float:
    """Where the motion, `values` (n,), comes to rest, in its unit: between its last peaks."""
    p = peaks.values
    if len(p) < 3:
        return float(np.mean(values[-max(1, len(values) // 10) :]))
    return float(0.25 * (p[-3] + 2.0 * p[-2] + p[-1]))


def _grows(start: float, end: float) -> InputError:
    return InputError.single(
        f"the motion grows from {start:g} to {end:g} s: it is no free decay",
        "fit the part after the release: --from and --to, or start and end",
    )


def _no_peaks(time: Floats, values: Floats, count: int) -> InputError:
    """The error of a record with too few peaks: it has come to rest without them, or ends early.

    `values` (n,) are in the motion's unit, at `time` (n,) [s].
    """
    last = values[-max(2, len(values) // 5) :]
    text = f"{count} peak{'s' * (count != 1)} after the release, at least 2 are needed"
    if np.ptp(last) < SETTLED * np.ptp(values):
        return InputError.single(
            f"the motion comes to rest without an oscillation: {text}",
            "it is damped by half of critical or more: a period is not in this record",
        )
    return InputError.single(f"the record ends at {time[-1]:g} s, too early: {text}", REMEDY)
