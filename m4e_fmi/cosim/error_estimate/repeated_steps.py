"""A part of a run that is repeated in steps of another length, and the recorded values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from m4e_fmi.cosim.error_estimate.step_times import among
from m4e_fmi.cosim.exchange.failures import EventWithinError
from m4e_fmi.cosim.exchange.network import Change, Network
from m4e_fmi.cosim.exchange.operations import gather
from m4e_fmi.cosim.exchange.schedule import StepLoop
from m4e_fmi.cosim.stepping.algorithm import Algorithm, Scheduled, Undoing, step_loop
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.time_loop.energy import BLOCK
from m4e_fmi.cosim.time_loop.time_events import NEVER, in_nanoseconds
from m4e_fmi.errors import RunError

ROUNDING = 1e-14
"""Share of the largest value up to which a difference may be rounding."""
FAR = 2**62
"""More steps than a run has."""


@dataclass(frozen=True)
class Recorded:
    """Recorded steps: `times` (n + 1,) [ns], and `values` (n + 1, n_sources), in their units."""

    times: np.ndarray
    values: np.ndarray

    @property
    def steps(self) -> int:
        """Number of steps from the first time to the last."""
        return len(self.times) - 1

    def first(self, steps: int) -> Recorded:
        """The first so many steps."""
        return Recorded(self.times[: steps + 1], self.values[: steps + 1])

    @cached_property
    def bounds(self) -> np.ndarray:
        """Smallest and largest value of each source (2, n_sources), in the sources' units."""
        return np.array([self.values.min(axis=0), self.values.max(axis=0)])

    @property
    def ranges(self) -> np.ndarray:
        """Range of the values of each source (n_sources,), in the sources' units."""
        return self.bounds[1] - self.bounds[0]

    @cached_property
    def leaps(self) -> np.ndarray:
        """Largest change of each source within one step (n_sources,), in the sources' units."""
        return leaps_of(self.values)

    @property
    def largest(self) -> np.ndarray:
        """Largest magnitude of each source (n_sources,), in the sources' units."""
        return np.abs(self.bounds).max(axis=0)

    def off(self, other: Recorded, times: np.ndarray | None = None) -> np.ndarray:
        """Magnitudes of differences (n_times, n_sources), in the sources' units.

        They are those at `times` (n_times,) [ns], or at all that both have. But not on both sides
        of a jump that takes one nanosecond: the other run's may be elsewhere.
        """
        if times is None:
            jumps = np.flatnonzero(np.diff(self.times) == 1)
            both = among(self.times, other.times)
            both[jumps] = both[jumps + 1] = False
            times = self.times[both]
        mine, theirs = (one.values[np.searchsorted(one.times, times)] for one in (self, other))
        return off(theirs, mine, self.largest)


def leaps_of(values: np.ndarray) -> np.ndarray:
    """Largest changes (n,) from one row of `values` (n_times, n) to the next, in their units."""
    return np.abs(np.diff(values, axis=0)).max(axis=0, initial=0.0)


def off(values: np.ndarray, others: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Magnitudes (n_times, n) of differences, 0 where they may be rounding; in the outputs' units.

    `values` (n_times, n) and `others` (n_times, n), and the magnitudes `largest` (n,) of all
    values, are in the outputs' units.
    """
    difference = np.abs(values - others)
    return np.where(difference <= ROUNDING * largest, 0.0, difference)


class RepeatedRun:
    """Steps over given times, from where `network` is, by an algorithm that `make` makes anew.

    `length` over the simulation's is that of most steps; `sources` (n,) are indices of the recorded
    outputs in the network's values.
    """

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
    def _loop(self) -> StepLoop | None:
        noted = gather(self._values, self._network.values, self._sources)
        return step_loop(self._algorithm, self._network, [noted])

    def halt(self) -> None:
        """End steps that are made at once at the next point, called by another thread."""
        loop: StepLoop | None = self.__dict__.get("_loop")
        if loop:
            loop.state.halt = 1

    def along(
        self, times: np.ndarray, jumps: Iterable[int], changes: Mapping[int, Sequence[Change]]
    ) -> Recorded:
        """Values at `times` (n,) [ns], with a step from each to the next.

        Some times are `jumps`, at some `changes` are made.
        """
        sizes, jumps = np.diff(times), frozenset(jumps)
        found = [self._network.values[self._sources][None]]
        other = np.flatnonzero(np.diff(sizes)) + 1
        changing = np.searchsorted(times, sorted(changes))
        for first, last in pairwise(sorted({0, *other.tolist(), *changing.tolist(), len(sizes)})):
            now, size, left = int(times[first]), int(sizes[first]), last - first
            if now in changes:
                self._network.change(changes[now])
            while left:
                self._network.pause()
                found.append(self._steps(now, size, left, jumps))
                now += len(found[-1]) * size
                left -= len(found[-1])
        return Recorded(times, np.concatenate(found))

    def _steps(self, now: int, size: int, most: int, jumps: frozenset[int]) -> np.ndarray:
        """Values after each of some steps of `size` from `now` [ns], one at least."""
        network, algorithm = self._network, self._algorithm
        loop = None if jumps else self._loop
        if loop and isinstance(algorithm, Scheduled) and algorithm.repeats(size / NS_PER_SECOND):
            made = min(most, BLOCK)
            loop.state.now, loop.state.size, loop.state.noted, loop.state.halt = now, size, 0, 0
            try:
                loop.advance(made)
            except EventWithinError:
                made = (loop.state.now - now) // size
                if not isinstance(algorithm, Undoing):
                    raise
                algorithm.undo()
            network.time = loop.state.now / NS_PER_SECOND
            if network.settle() or loop.state.halt:
                made = (loop.state.now - now) // size
            if loop.state.now < now + made * size:
                raise RunError(network.ended)
            if made:
                return self._values[:made].copy()
        self._step(now, size, jumps)
        return network.values[self._sources][None]

    def _step(self, now: int, size: int, jumps: frozenset[int]) -> None:
        """One step; in pieces where FMUs have events within it: to just before them, and over."""
        network, algorithm, end, event = self._network, self._algorithm, now + size, NEVER
        while now < end:
            network.pause()
            size = end - now
            if event > now:
                size = min(size, event - 1 - now if event - 1 > now else 1)
            try:
                algorithm.step(now / NS_PER_SECOND, size / NS_PER_SECOND)
            except EventWithinError as found:
                if found.reached is None or not isinstance(algorithm, Undoing) or size == 1:
                    raise
                algorithm.undo()
                event = min(max(now + 1, in_nanoseconds(found.reached)), now + size - 1)
                continue
            now += size
            if now == event:
                event = NEVER
                network.forget()
            elif now in jumps:
                network.forget()
            network.advance(now / NS_PER_SECOND)
