"""What tells the coupling error while the run goes on: a second course at twice the step.

Two courses of an algorithm of order p from one point, y at the step H and z at 2H, differ by most
of the error of the second:

    error of y = |y − z| / (2^p − 1)

So at the end of a *window* of steps the FMUs go back to its start, make it again in half as many
steps of twice the length, and return; the run is not touched by it. Nothing is assumed of the FMUs,
and errors propagate in both courses as they do. The first 256 steps are a window. Then follow
octaves (256 to 512, 512 to 1024 ...) of which the first eighth is one, so that this costs half of
the first steps again, and a sixteenth of later ones. Jumps that FMUs announce are met by both
courses; steps between them whose number is odd leave one that is not longer, for which the
differences are scaled up.

Where steps of twice the length cannot be (they fail, most of them would end at jumps, values were
set between the run's steps, a component's own points are not met) a window is made again at H/2:

    error of y = |y − z| 2^p / (2^p − 1)

Values are set there as in the run. This costs twice the steps of the window again.

Beyond its window an error may go on growing. How it does, the longest window tells: if E doubles
with the time (as the phase of an undamped oscillation), the octave's error is E S/τ, with S its
length and τ that of the window, and octaves add up; if it does not grow (where oscillations are
damped and forced), the octave's error is E, and the largest counts. In between, with an exponent
γ = log₂ of what E grows by in the second half of the window,

    error = (Σ E^(1/γ) S/τ)^γ     over all octaves.

A run that goes back to a saved state takes what was seen since then back, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.cosim.algorithms.scheduled import Scheduled, looped
from m4e_fmi.cosim.energy import BLOCK
from m4e_fmi.cosim.events import ended
from m4e_fmi.cosim.network import HALF, TWICE, Change, Network, Point
from m4e_fmi.cosim.operations import Operation, gather
from m4e_fmi.cosim.schedule import Loop
from m4e_fmi.cosim.system import SECOND
from m4e_fmi.errors import RunError

if TYPE_CHECKING:
    from m4e_fmi.cosim.algorithms import Algorithm

FIRST, SHARE = 256, 8
"""Steps of the first window; octaves over windows after it."""
FAR = 2**62
"""More steps than a run has."""
LEAST, MOST = 0.05, 1.0
"""Bounds of the exponent."""
ROUNDING = 1e-14
"""Share of the largest value up to which a difference says nothing."""


@dataclass
class _Told:
    """What the two courses of a window tell of each source: `errors` (2, sources), the largest
    differences in its first half and in all of it; `extremes`, the smallest and largest values.

    The window is of `span` [ns], 0 if nothing is told yet.
    """

    errors: np.ndarray
    extremes: np.ndarray
    span: int = 0


@dataclass
class _Window:
    """Steps that are made again: `times` [ns] and source values of the run, piece by piece.

    `jumps` are the times to which a jump has led, `changes` what was set at some times.
    """

    start: Point
    times: list[np.ndarray]
    values: list[np.ndarray]
    told: _Told
    jumps: list[int] = field(default_factory=list)
    changes: dict[int, list[Change]] = field(default_factory=dict)

    def copy(self) -> _Window:
        """The same, which stays as it is while this goes on."""
        changes = {time: changes.copy() for time, changes in self.changes.items()}
        times, values, jumps = self.times.copy(), self.values.copy(), self.jumps.copy()
        told = replace(self.told)
        return replace(self, times=times, values=values, told=told, jumps=jumps, changes=changes)

    @property
    def began(self) -> int:
        """The time [ns] of its start."""
        return int(self.times[0][0])


def _coarse(times: np.ndarray, jumps: Sequence[int]) -> np.ndarray:
    """Times of steps of twice the length: every second one, and both ends of a jump."""
    last = len(times) - 1
    after = np.searchsorted(times, jumps)
    edges = np.concatenate([[0], np.column_stack((after - 1, after)).ravel(), [last]])
    kept = np.unique(np.concatenate([edges, *(np.arange(a, b, 2) for a, b in pairwise(edges))]))
    if len(kept) > 1 and kept[-1] - kept[-2] == 1 and last not in after:
        kept = kept[:-1]  # a single step at the end tells nothing
    return times[kept]


def _fine(times: np.ndarray, jumps: Sequence[int]) -> np.ndarray:
    """Times of steps of half the length, but over jumps."""
    smooth = ~np.isin(times[1:], jumps)
    middles = times[:-1] + np.diff(times) // 2
    return np.unique(np.concatenate([times, middles[smooth]]))


def _other_steps(times: np.ndarray, run: np.ndarray) -> int:
    """How long [ns] the steps take that lead along `times`, and that the run has not made."""
    place = np.searchsorted(run, times)
    met = run[np.minimum(place, len(run) - 1)] == times
    same = met[:-1] & met[1:] & (np.diff(place) == 1)
    return int(np.diff(times)[~same].sum())


def _nanoseconds(time: float) -> int:
    return round(time * SECOND)


def off(values: np.ndarray, others: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Magnitudes of differences, 0 where they may be rounding of values up to `largest`."""
    difference = np.abs(values - others)
    return np.where(difference <= ROUNDING * largest, 0.0, difference)


@dataclass(frozen=True)
class Seen:
    """What a witness knows at a point of the run; `open` is the open window as it is there."""

    steps: int
    begins: int
    ends: int
    windows: tuple[_Window, ...]
    open: _Window | None


class _UntoldError(Exception):
    """A course of steps of some length cannot tell the errors of a window; why not."""


class Witness:
    """Follows a run of `network` by an algorithm of this `order`, which `make` makes anew.

    While it is `open`, the `operations` are to be performed after each step of the run. `lengths`
    are those of the other course's steps over the run's, TWICE and HALF, to be tried in this order.
    """

    def __init__(
        self,
        network: Network,
        make: Callable[[Network], Algorithm],
        sources: np.ndarray,
        lengths: Sequence[float],
        *,
        order: int,
    ) -> None:
        self._network = network
        self._others = {c: _Other(network, make, sources, length=c) for c in lengths}
        self._order = order
        self._sources = sources
        self._values = np.zeros((BLOCK, len(sources)))
        self.operations: tuple[Operation, ...] = (gather(self._values, network.values, sources),)
        self._steps = 0
        self._begins, self._ends = 0, FIRST
        self._window: _Window | None = None
        self._windows: list[_Window] = []
        self._start = _nanoseconds(network.time)
        self.failure = ""
        """Why nothing can be told, if so."""

    @property
    def open(self) -> bool:
        """Whether the present steps are those of a window."""
        return self._window is not None

    def before(self) -> None:
        """Before a step of the run: keeps the point where a window begins."""
        if self._steps == self._begins and not self.open and not self.failure:
            start = self._network.keep()
            now, values = _nanoseconds(start.time), self._network.values[self._sources][None]
            told = _Told(np.zeros((2, values.shape[1])), np.repeat(values, 2, axis=0))
            self._window = _Window(start, [np.array([now])], [values], told)
            self._windows.append(self._window)

    def changed(self, changes: Sequence[Change]) -> None:
        """Some values were set at the present point, and exchanged."""
        if self._window:
            now = _nanoseconds(self._network.time)
            self._window.changes.setdefault(now, []).extend(changes)

    def seen(self) -> Seen:
        """What it knows at the present point, to which the run may go `back`."""
        closed = tuple(window for window in self._windows if window is not self._window)
        kept = self._window.copy() if self._window else None
        return Seen(self._steps, self._begins, self._ends, closed, kept)

    def back(self, seen: Seen) -> None:
        """The run has gone back to where it had `seen` so much."""
        self._steps, self._begins, self._ends = seen.steps, seen.begins, seen.ends
        self._window = seen.open.copy() if seen.open else None
        self._windows = [*seen.windows, *([self._window] if self._window else [])]

    @property
    def room(self) -> int:
        """How many steps may be made at once before `after` is told."""
        if self.failure:
            return FAR
        return (self._ends if self.open else self._begins) - self._steps

    def after(self, steps: int, size: int, row: int, *, jumped: bool = False) -> None:
        """After so many steps of `size` [ns]; the operations have filled rows from `row` on.

        The last has `jumped`: what was before it is forgotten.
        """
        self._steps += steps
        window = self._window
        if window is None or not steps:
            return
        last = int(window.times[-1][-1])
        window.times.append(last + size * np.arange(1, steps + 1))
        if jumped:
            window.jumps.append(last + size * steps)
        window.values.append(self._values[row : row + steps].copy())
        if self._steps == self._ends:
            self._close()

    def _close(self) -> None:
        """Make the steps of the open window again, of another length."""
        window, self._window = self._window, None
        self._begins = max(2 * self._begins, FIRST)
        self._ends = self._begins + self._begins // SHARE
        if window is None or len(window.times) < 2:
            return
        times, values = np.concatenate(window.times), np.concatenate(window.values)
        if len(times) == 2 and HALF not in self._others:
            return  # a single step tells nothing
        end, why = self._network.keep(), []
        for length in tuple(self._others):
            try:
                self._judge(window, times, values, length)
                break
            except _UntoldError as error:
                why.append(str(error))
        else:
            self.failure = ", and ".join(why)
        try:
            self._network.restore(end)
        except RunError as error:
            raise RunError(
                f"the coupling error is told by steps of another length: {', and '.join(why)}; "
                f"there is no way back from that ({error.message})",
                "an FMU should discard a step that it cannot make, and not answer Fatal",
            ) from error
        window.values.clear()

    def _judge(self, window: _Window, run: np.ndarray, values: np.ndarray, length: float) -> None:
        """Note the largest differences to a course with steps of this `length`, or _UntoldError."""
        twice = length == TWICE
        if twice and window.changes:
            raise _UntoldError("values were set between steps")
        times = (_coarse if twice else _fine)(run, window.jumps)
        span, other = int(times[-1] - times[0]), _other_steps(times, run)
        if other < span / 2 or not span:
            if twice:
                raise _UntoldError("most steps end at jumps")
            return  # there is nothing but jumps
        try:
            self._network.restore(window.start)
            again = self._others[length].course(times, window.jumps, window.changes)
        except RunError as error:
            del self._others[length]
            name = "twice" if twice else "half"
            raise _UntoldError(f"steps of {name} the length fail ({error.message})") from error
        _, mine, theirs = np.intersect1d(run, times, assume_unique=True, return_indices=True)
        errors = off(again[theirs], values[mine], np.abs(values).max(axis=0))
        first = errors[: len(errors) // 2 + 1].max(axis=0)
        scale = span / other * (1.0 if twice else 2.0**self._order)
        told, better = window.told, values if twice else again
        told.errors = scale * np.array([first, errors.max(axis=0)])
        told.extremes = np.array([better.min(axis=0), better.max(axis=0)])
        told.span = span

    def finish(self) -> None:
        """At the end of the run: judge the window that is open."""
        try:
            self._close()
        except RunError as error:
            self.failure = error.message
        if not self.failure and not any(window.told.span for window in self._windows):
            self.failure = "the run has but one step" if self._steps else "the run has no steps"

    def difference(self) -> np.ndarray:
        """What the two courses would differ by at most, for each source, had both gone all the way.

        To be called after `finish`, without a `failure`.
        """
        windows = [window for window in self._windows if window.told.span]
        told = [window.told for window in windows]
        last = _nanoseconds(self._network.time)
        edges = [self._start, *(window.began for window in windows[1:]), last]
        octaves = [end - begin for begin, end in pairwise(edges)]
        first, whole = max(told, key=lambda one: one.span).errors
        grown = np.divide(whole, first, out=np.ones_like(whole), where=first > 0.0)
        exponent = np.clip(np.log2(np.maximum(grown, 1.0)), LEAST, MOST)
        largest = np.max([one.errors[1] for one in told], axis=0)
        scale = np.where(largest > 0.0, largest, 1.0)
        total = sum(
            (one.errors[1] / scale) ** (1 / exponent) * max(octave / one.span, 1.0)
            for one, octave in zip(told, octaves, strict=True)
        )
        return scale * np.where(largest > 0.0, total, 0.0) ** exponent

    def ranges(self) -> np.ndarray:
        """How far the values of each source have been apart in the windows."""
        extremes = np.array([window.told.extremes for window in self._windows])
        return extremes[:, 1].max(axis=0) - extremes[:, 0].min(axis=0)


class _Other:
    """The second course, made where the run has just been, with steps of another `length`."""

    def __init__(
        self,
        network: Network,
        make: Callable[[Network], Algorithm],
        sources: np.ndarray,
        *,
        length: float,
    ) -> None:
        self._network, self._make, self._sources = network, make, sources
        self._length = length
        self._values = np.zeros((BLOCK, len(sources)))

    @cached_property
    def _algorithm(self) -> Algorithm:
        return self._network.made(self._make, self._length)

    @cached_property
    def _loop(self) -> Loop | None:
        noted = gather(self._values, self._network.values, self._sources)
        return looped(self._algorithm, self._network, [noted])

    def course(
        self, times: np.ndarray, jumps: Sequence[int], changes: Mapping[int, Sequence[Change]]
    ) -> np.ndarray:
        """Values of the sources at these times [ns], a step from each to the next.

        Some are `jumps`, at some `changes` are made.
        """
        sizes = np.diff(times)
        found = [self._network.values[self._sources][None]]
        other = np.flatnonzero(np.diff(sizes)) + 1
        changing = np.searchsorted(times, sorted(changes))
        for first, last in pairwise(sorted({0, *other.tolist(), *changing.tolist(), len(sizes)})):
            now, size, left = int(times[first]), int(sizes[first]), last - first
            if now in changes:
                self._network.change(changes[now])
            while left:
                found.append(self._steps(now, size, left, jumps))
                now += len(found[-1]) * size
                left -= len(found[-1])
        return np.concatenate(found)

    def _steps(self, now: int, size: int, most: int, jumps: Sequence[int]) -> np.ndarray:
        """Values after each of some steps of `size` from `now` [ns], one at least."""
        network, algorithm = self._network, self._algorithm
        loop = None if jumps else self._loop
        if loop and isinstance(algorithm, Scheduled) and algorithm.repeats(size / SECOND):
            made = min(most, BLOCK)
            loop.state.now, loop.state.size, loop.state.noted = now, size, 0
            loop.advance(made)
            network.time = loop.state.now / SECOND
            if network.settle():
                made = (loop.state.now - now) // size
            if loop.state.now < now + made * size:
                raise RunError(ended(network.instances.values()))
            return self._values[:made].copy()
        algorithm.step(now / SECOND, size / SECOND)
        if now + size in jumps:
            network.forget()
        network.advance((now + size) / SECOND)
        return network.values[self._sources][None]
