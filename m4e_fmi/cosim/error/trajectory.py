"""The second trajectory: steps of twice or half the length of the run's, over the same times.

Its FMUs are the run's own, which go back to a point of the run and return afterwards, or a second
set, which goes beside the run from the start. Both are treated alike: a network at some point, and
times.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from m4e_fmi.cosim.network.failures import EndWithinError, EventWithinError
from m4e_fmi.cosim.network.network import Change, Network
from m4e_fmi.cosim.network.operations import gather
from m4e_fmi.cosim.network.schedule import StepLoop
from m4e_fmi.cosim.stepping.algorithm import BLOCK, Algorithm, Scheduled, Undoing, step_loop
from m4e_fmi.cosim.stepping.time_events import in_nanoseconds
from m4e_fmi.cosim.system.simulation import NEVER, NS_PER_SECOND


class Trajectory:
    """Steps of `network`, from where it is, by an algorithm that `make` makes anew.

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

    @property
    def is_over(self) -> bool:
        """True if an FMU has asked for the end of the simulation."""
        return self._network.is_over

    def halt(self) -> None:
        """End steps that are made at once at the next point, called by another thread."""
        loop: StepLoop | None = self.__dict__.get("_loop")
        if loop:
            loop.state.halt = 1

    def along(
        self, times: np.ndarray, jumps: Collection[int], changes: Mapping[int, Sequence[Change]]
    ) -> np.ndarray:
        """Values (m, n_sources) at the first m of `times` (n,) [ns], with a step between any two.

        Some times are `jumps`, at some `changes` are made, but for the last. The values end early
        if an FMU asks for the end of the simulation.
        """
        sizes, network = np.diff(times), self._network
        found = [network.values[self._sources][None]]
        edges = {0, len(sizes), *(np.flatnonzero(np.diff(sizes)) + 1).tolist()}
        edges.update(np.searchsorted(times, [t for t in changes if times[0] <= t < times[-1]]))
        for first, last in pairwise(sorted(edges)):
            now, size, left = int(times[first]), int(sizes[first]), last - first
            if now in changes:
                network.change(changes[now])
            while left and not self.is_over:
                network.pause()
                try:
                    found.append(self._steps(now, size, left, jumps))
                except EndWithinError:
                    return np.concatenate(found)
                now += len(found[-1]) * size
                left -= len(found[-1])
        return np.concatenate(found)

    def _steps(self, now: int, size: int, most: int, jumps: Collection[int]) -> np.ndarray:
        """Values after each of some steps of `size` from `now` [ns], one at least."""
        network, algorithm = self._network, self._algorithm
        loop = None if jumps else self._loop
        if loop and isinstance(algorithm, Scheduled) and algorithm.repeats(size / NS_PER_SECOND):
            loop.state.now, loop.state.size, loop.state.noted, loop.state.halt = now, size, 0, 0
            try:
                loop.advance(min(most, BLOCK))
            except EventWithinError:
                if not isinstance(algorithm, Undoing):
                    raise
                algorithm.undo()
            network.time = loop.state.now / NS_PER_SECOND
            network.settle()
            if made := (loop.state.now - now) // size:
                return self._values[:made].copy()
        self._step(now, size, jumps)
        return network.values[self._sources][None]

    def _step(self, now: int, size: int, jumps: Collection[int]) -> None:
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


def doubled_steps(times: np.ndarray, jumps: Iterable[int], met: np.ndarray) -> np.ndarray:
    """Times (m,) [ns] of steps of twice the length, along those of `times` (n,) [ns].

    They are every second one, from each edge on: both ends of each of the `jumps`, the last, and
    the times that are to be `met`, (k,) [ns].
    """
    after, at = np.searchsorted(times, sorted(jumps)), np.flatnonzero(np.isin(times, met))
    edges = np.unique(np.concatenate([[0, len(times) - 1], after - 1, after, at]).astype(np.intp))
    chosen = [np.arange(begin, end, 2) for begin, end in pairwise(edges.tolist())]
    return times[np.concatenate([*chosen, edges[-1:]])]


def halved_steps(times: np.ndarray, jumps: Iterable[int]) -> np.ndarray:
    """Times (m,) [ns] of steps of half the length of those of `times` (n,) [ns], but over jumps."""
    smooth = ~np.isin(times[1:], list(jumps))
    middles = times[:-1] + np.diff(times) // 2
    return np.unique(np.concatenate([times, middles[smooth]]))


def length_of_others(times: np.ndarray, run: np.ndarray) -> int:
    """Length [ns] of all steps along `times` (n,) [ns] that are not steps of `run` (m,) [ns]."""
    places, met = _places(times, run)
    same = met[:-1] & met[1:] & (np.diff(places) == 1)
    return int(np.diff(times)[~same].sum())


def between_jumps(times: np.ndarray) -> np.ndarray:
    """Mask (n,) of `times` (n,) [ns]: False at both ends of steps of one nanosecond.

    These lead over jumps, which may be elsewhere in another run.
    """
    smooth, jumps = np.ones(len(times), dtype=bool), np.flatnonzero(np.diff(times) == 1)
    smooth[jumps] = smooth[jumps + 1] = False
    return smooth


def differences(
    times: np.ndarray, values: np.ndarray, others: np.ndarray, again: np.ndarray, smooth: np.ndarray
) -> np.ndarray:
    """Magnitudes (m, n_sources), in the sources' units, of differences at the times of both runs.

    `values` (n, n_sources) are at `times` (n,) [ns], `again` (k, n_sources) at `others` (k,) [ns];
    all are in the sources' units. Times that are not `smooth` (n,) [1] are left out.
    """
    places, met = _places(times, others)
    both = smooth & met
    return np.abs(values[both] - again[places[both]])


def _places(times: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places (n,) of `times` (n,) among `others` (m,), all [ns] and in order; if they are there."""
    places = np.searchsorted(others, times)
    return places, others.take(places, mode="clip") == times
