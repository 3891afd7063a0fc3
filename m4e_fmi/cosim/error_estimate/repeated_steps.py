"""A part of a run made a second time, in steps of other lengths, and which lengths these are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from m4e_fmi.cosim.exchange.events import ended
from m4e_fmi.cosim.exchange.failures import EventWithinError
from m4e_fmi.cosim.exchange.network import Change, Network
from m4e_fmi.cosim.exchange.operations import gather
from m4e_fmi.cosim.exchange.step_loop import StepLoop
from m4e_fmi.cosim.stepping.algorithm import Algorithm, Undoing
from m4e_fmi.cosim.stepping.scheduled import Scheduled, step_loop
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.time_loop.energy import BLOCK
from m4e_fmi.cosim.time_loop.time_events import NEVER, in_nanoseconds
from m4e_fmi.errors import RunError

ROUNDING = 1e-14
"""Share of the largest value up to which a difference says nothing."""
FAR = 2**62
"""More steps than a run has."""
PARTS = 16
"""Steps in place of one about a kink."""
LEAST = 100
"""Length [ns] below which a step is not divided."""
BEFORE, AFTER = 2, 2
"""Steps before and after one that is rough at once which a kink may lie in, or act on."""


@dataclass(frozen=True)
class Recorded:
    """Recorded steps: `times` [ns] (n + 1,), and `values` there (n + 1, n_sources)."""

    times: np.ndarray
    values: np.ndarray

    @property
    def steps(self) -> int:
        """How many lead from the first time to the last."""
        return len(self.times) - 1

    @cached_property
    def bounds(self) -> np.ndarray:
        """The smallest and the largest value of each source (2, sources)."""
        return np.array([self.values.min(axis=0), self.values.max(axis=0)])

    @property
    def ranges(self) -> np.ndarray:
        """How far the values of each source are apart (sources,)."""
        return self.bounds[1] - self.bounds[0]

    @property
    def largest(self) -> np.ndarray:
        """The largest magnitude of each source (sources,)."""
        return np.abs(self.bounds).max(axis=0)

    def off(self, other: Recorded, times: np.ndarray | None = None) -> np.ndarray:
        """Magnitudes of differences (times, sources) at some times, or at all that both have.

        But not on both sides of a jump that takes one nanosecond: the other's may be another.
        """
        if times is None:
            jumps = np.flatnonzero(np.diff(self.times) == 1)
            both = _among(self.times, other.times)
            both[jumps] = both[jumps + 1] = False
            times = self.times[both]
        mine, theirs = (one.values[np.searchsorted(one.times, times)] for one in (self, other))
        return off(theirs, mine, self.largest)


def _among(times: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which of some times (n,) are among others, both in order."""
    place = np.searchsorted(others, times)
    return others[np.minimum(place, len(others) - 1)] == times


def off(values: np.ndarray, others: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Magnitudes of differences, 0 where they may be rounding of values up to `largest`."""
    difference = np.abs(values - others)
    return np.where(difference <= ROUNDING * largest, 0.0, difference)


def doubled(times: np.ndarray, jumps: Sequence[int], *, phase: int | None = None) -> np.ndarray:
    """Times [ns] of steps of twice the length: every second one, and both ends of each jump.

    With a `phase`, 0 or 1, they are every second one from that on, also after a jump: components
    that step more rarely have their points there.
    """
    last = len(times) - 1
    after = np.searchsorted(times, jumps)
    edges = np.concatenate([[0], np.column_stack((after - 1, after)).ravel(), [last]])
    begins = edges if phase is None else edges + (edges + phase) % 2
    met = np.zeros(last + 1, dtype=bool)
    met[edges] = True
    for begin, end in zip(begins[:-1], edges[1:], strict=True):
        met[begin:end:2] = True
    kept = np.flatnonzero(met)
    if len(kept) > 1 and kept[-1] - kept[-2] == 1 and last not in after:
        kept = kept[:-1]  # a single step at the end tells nothing
    return times[kept]


def halved(times: np.ndarray, jumps: Sequence[int]) -> np.ndarray:
    """Times [ns] of steps of half the length, but over jumps."""
    smooth = ~np.isin(times[1:], jumps)
    middles = times[:-1] + np.diff(times) // 2
    return np.unique(np.concatenate([times, middles[smooth]]))


def about(kinks: np.ndarray, steps: int) -> np.ndarray:
    """The steps, of so many, in which a kink may lie or act: those about the `kinks` (k,)."""
    near = (kinks[:, None] + np.arange(-BEFORE, AFTER + 1)).ravel()
    return np.unique(near[(near >= 0) & (near < steps)])


def events(kinks: np.ndarray) -> int:
    """How many have made these (k,), in order: those that act on each other's steps are one."""
    return int(len(kinks) > 0) + int((np.diff(kinks) > BEFORE + AFTER).sum())


def first_of_each(kinks: np.ndarray) -> np.ndarray:
    """Of these (k,), in order, the first that each event has made."""
    return kinks[np.diff(kinks, prepend=-FAR) > BEFORE + AFTER]


def first_events(kinks: np.ndarray, count: int) -> np.ndarray:
    """Of these (k,), in order, those that the first so many events have made."""
    number = np.concatenate([[0], np.cumsum(np.diff(kinks) > BEFORE + AFTER)])[: len(kinks)]
    return kinks[number < count]


def refined(times: np.ndarray, jumps: Sequence[int], steps: np.ndarray) -> np.ndarray:
    """Times [ns] with PARTS steps in place of some `steps` (k,), but over jumps.

    Where these are many, there are fewer, so that all steps are three times as many at most.
    """
    found, most = [times], 1 + 2 * (len(times) - 1) // max(1, len(steps))
    for k in steps[~np.isin(times[1:][steps], jumps)].tolist():
        begin, end = int(times[k]), int(times[k + 1])
        parts = min(PARTS, most, (end - begin) // LEAST)
        if parts > 1:
            found.append(np.round(np.linspace(begin, end, parts + 1)).astype(np.int64))
    return np.unique(np.concatenate(found))


def other_steps(times: np.ndarray, run: np.ndarray) -> int:
    """How long [ns] the steps take that lead along `times`, and that the run has not made."""
    met = _among(times, run)
    same = met[:-1] & met[1:] & (np.diff(np.searchsorted(run, times)) == 1)
    return int(np.diff(times)[~same].sum())


class SecondCourse:
    """Steps over times given, from where `network` is, by an algorithm that `make` makes anew.

    `length` over the simulation's is that of most steps; `sources` (n,) are the places of the
    outputs that are told.
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
        """The course over these times [ns], a step from each to the next.

        Some are `jumps`, at some `changes` are made.
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
                raise RunError(ended(network.instances.values()))
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
