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

Beyond its window an error may go on growing. How it does, the longest window tells: if E doubles
with the time (as the phase of an undamped oscillation), the octave's error is E S/τ, with S its
length and τ that of the window, and octaves add up; if it does not grow (where oscillations are
damped and forced), the octave's error is E, and the largest counts. In between, with an exponent
γ = log₂ of what E grows by in the second half of the window,

    error = (Σ E^(1/γ) S/τ)^γ     over all octaves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.cosim.algorithms.scheduled import Scheduled, looped
from m4e_fmi.cosim.energy import BLOCK
from m4e_fmi.cosim.network import Network, Point
from m4e_fmi.cosim.operations import Operation, gather
from m4e_fmi.cosim.schedule import Loop
from m4e_fmi.cosim.system import SECOND
from m4e_fmi.errors import RunError

if TYPE_CHECKING:
    from m4e_fmi.cosim.algorithms import Algorithm

FIRST, SHARE = 256, 8
"""Steps of the first window; octaves over windows after it."""
START, END = 1, 2
"""Where the FMUs keep the states at the ends of a window."""
FAR = 2**62
"""More steps than a run has."""
LEAST, MOST = 0.05, 1.0
"""Bounds of the exponent."""
ROUNDING = 1e-14
"""Share of the largest value up to which a difference says nothing."""


@dataclass
class _Window:
    """Steps that are made again: `times` [ns] and source values of the run while it is open.

    Then `errors` (2, sources) are the largest differences in its first half and in all of it,
    `extremes` the smallest and largest values; `span` and `octave` the times [ns] of the window and
    of all steps for which it stands. `jumps` are the points to which a jump has led.
    """

    start: Point
    times: list[int]
    values: list[np.ndarray]
    errors: np.ndarray
    extremes: np.ndarray
    jumps: list[int] = field(default_factory=list)
    span: int = 0
    octave: int = 0

    def coarse(self) -> list[int]:
        """The points of the other course: every second one, and both ends of a jump."""
        last = len(self.times) - 1
        edges = [0, *(k for jump in self.jumps for k in (jump - 1, jump)), last]
        chosen = [k for start, end in pairwise(edges) for k in (*range(start, end, 2), end)]
        kept = list(dict.fromkeys(chosen))
        if len(kept) > 1 and kept[-1] - kept[-2] == 1 and last not in self.jumps:
            kept.pop()  # a single step at the end tells nothing
        return kept


def off(values: np.ndarray, others: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Magnitudes of differences, 0 where they may be rounding of values up to `largest`."""
    difference = np.abs(values - others)
    return np.where(difference <= ROUNDING * largest, 0.0, difference)


class Witness:
    """Follows a run of `network` by an algorithm that `make` makes anew for the other course.

    While it is `open`, the `operations` are to be performed after each step of the run.
    """

    def __init__(
        self, network: Network, make: Callable[[Network], Algorithm], sources: np.ndarray
    ) -> None:
        self._network = network
        self._other = _Other(network, make, sources)
        self._sources = sources
        self._values = np.zeros((BLOCK, len(sources)))
        self.operations: tuple[Operation, ...] = (gather(self._values, network.values, sources),)
        self._steps = 0
        self._begins, self._ends = 0, FIRST
        self._window: _Window | None = None
        self._windows: list[_Window] = []
        self.failure = ""
        """Why nothing can be told, if so."""

    @property
    def open(self) -> bool:
        """Whether the present steps are those of a window."""
        return self._window is not None

    def before(self) -> None:
        """Before a step of the run: keeps the point where a window begins."""
        if self._steps == self._begins and not self.failure:
            now = self._network.snapshot(START)
            values = self._network.values[self._sources][None]
            nothing, same = np.zeros((2, values.shape[1])), np.repeat(values, 2, axis=0)
            self._window = _Window(now, [round(now.time * SECOND)], [values], nothing, same)
            self._windows.append(self._window)

    def stop(self, why: str) -> None:
        """The other course cannot follow the run any more: nothing can be told."""
        self._window, self.failure = None, self.failure or why

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
        if window is None:
            return
        last = window.times[-1]
        window.times += [last + k * size for k in range(1, steps + 1)]
        if jumped:
            window.jumps.append(len(window.times) - 1)
        window.values.append(self._values[row : row + steps].copy())
        if self._steps == self._ends:
            self._close()

    def _close(self) -> None:
        """Make the steps of the open window again, twice as long."""
        window, self._window = self._window, None
        self._begins = max(2 * self._begins, FIRST)
        self._ends = self._begins + self._begins // SHARE
        if window is None or len(window.times) < 3:
            return
        values = np.concatenate(window.values)
        window.extremes = np.array([values.min(axis=0), values.max(axis=0)])
        network = self._network
        end = network.snapshot(END)
        network.restore(window.start)
        try:
            times = [window.times[k] for k in window.coarse()]
            again = self._other.course(times, {window.times[k] for k in window.jumps})
        except RunError as error:
            self.failure = f"steps of twice the length fail ({error.message})"
        else:
            self._compare(window, again, values)
        network.restore(end)
        window.values.clear()

    def _compare(self, window: _Window, again: np.ndarray, values: np.ndarray) -> None:
        """Note the largest differences of the two courses, of which one is at `coarse` only."""
        coarse, times = window.coarse(), window.times
        errors = off(again, values[coarse], np.abs(values).max(axis=0))
        half = len(errors) // 2
        span = times[coarse[-1]] - times[0]
        doubled = sum(times[b] - times[a] for a, b in pairwise(coarse) if b - a == 2)
        if doubled < span / 2:
            self.failure = "most steps end at jumps, so that they cannot be made twice as long"
            return
        window.errors = np.array([errors[: half + 1].max(axis=0), errors.max(axis=0)]) * (
            span / doubled
        )
        window.span = span

    def finish(self) -> None:
        """At the end of the run: judge the window that is open."""
        self._close()
        if not self.failure and not any(window.span for window in self._windows):
            self.failure = "the run has but one step"

    def difference(self) -> np.ndarray:
        """What the two courses would differ by at most, for each source, had both gone all the way.

        To be called after `finish`, without a `failure`.
        """
        windows = [window for window in self._windows if window.span]
        begins = [window.times[0] for window in windows[1:]]
        last = round(self._network.time * SECOND)
        for window, end in zip(windows, [*begins, last], strict=True):
            window.octave = end - window.times[0]
        longest = max(windows, key=lambda window: window.span)
        first, whole = longest.errors
        grown = np.divide(whole, first, out=np.ones_like(whole), where=first > 0.0)
        exponent = np.clip(np.log2(np.maximum(grown, 1.0)), LEAST, MOST)
        largest = np.max([window.errors[1] for window in windows], axis=0)
        scale = np.where(largest > 0.0, largest, 1.0)
        total = sum(
            (w.errors[1] / scale) ** (1 / exponent) * max(w.octave / w.span, 1.0) for w in windows
        )
        return scale * np.where(largest > 0.0, total, 0.0) ** exponent

    def ranges(self) -> np.ndarray:
        """How far the values of each source have been apart in the windows."""
        extremes = np.array([window.extremes for window in self._windows])
        return extremes[:, 1].max(axis=0) - extremes[:, 0].min(axis=0)


class _Other:
    """The second course, made where the run has just been."""

    def __init__(
        self, network: Network, make: Callable[[Network], Algorithm], sources: np.ndarray
    ) -> None:
        self._network, self._make, self._sources = network, make, sources
        self._values = np.zeros((BLOCK, len(sources)))

    @cached_property
    def _algorithm(self) -> Algorithm:
        self._network.coarse = 2
        try:
            return self._make(self._network)
        finally:
            self._network.coarse = 1

    @cached_property
    def _loop(self) -> Loop | None:
        noted = gather(self._values, self._network.values, self._sources)
        return looped(self._algorithm, self._network, [noted])

    def course(self, times: list[int], jumps: set[int]) -> np.ndarray:
        """Values of the sources at these times [ns], a step from each to the next; some `jumps`."""
        now, found = times[0], [self._network.values[self._sources][None]]
        for size, steps in groupby(np.diff(times).tolist()):
            left = len(list(steps))
            while left:
                found.append(self._steps(now, size, left, jumps))
                now += len(found[-1]) * size
                left -= len(found[-1])
        return np.concatenate(found)

    def _steps(self, now: int, size: int, most: int, jumps: set[int]) -> np.ndarray:
        """Values after each of some steps of `size` from `now` [ns], one at least."""
        network, algorithm = self._network, self._algorithm
        loop = None if jumps else self._loop
        if loop and isinstance(algorithm, Scheduled) and algorithm.repeats(size / SECOND):
            made = min(most, BLOCK)
            loop.state.now, loop.state.size, loop.state.noted = now, size, 0
            loop.advance(made)
            network.time = loop.state.now / SECOND
            return self._values[:made].copy()
        algorithm.step(now / SECOND, size / SECOND)
        if now + size in jumps:
            network.forget()
        network.advance((now + size) / SECOND)
        return network.values[self._sources][None]
