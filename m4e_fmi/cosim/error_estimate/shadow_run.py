"""Online estimate of the coupling error where FMUs cannot go back, or step less often than the
system without being sampled: a second set of instances.

It begins at the start time as the run does, and makes steps twice as long (or half as long: see
`step_doubling` for the meaning of the difference). It costs half of the run again (or twice), but
covers all of it: nothing has to be concluded from a part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.kinks import NOISE, SMALL, halved_kinks
from m4e_fmi.cosim.error_estimate.repeated_steps import FAR, leaps_of, off
from m4e_fmi.cosim.error_estimate.report import over
from m4e_fmi.cosim.error_estimate.roughness import HISTORY, Roughness, fourth_differences
from m4e_fmi.cosim.exchange.network import TWICE, Change, Network
from m4e_fmi.cosim.exchange.operations import Operation, gather
from m4e_fmi.cosim.stepping.algorithm import Algorithm
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND, Simulation
from m4e_fmi.cosim.time_loop.energy import BLOCK, EnergyBalance
from m4e_fmi.cosim.time_loop.time_loop import TimeLoop
from m4e_fmi.errors import RunError

KINKED = 1.0
"""Order of the error of a kink within a step, which other FMUs see at its ends only."""


class Recorder:
    """Keeps the values of some outputs, `sources`, at the points that a run comes to: `count`.

    `kinks` (n,) are the largest fourth differences of the sources in suddenly rough steps, in
    their units.
    """

    room = FAR

    def __init__(self, network: Network, sources: np.ndarray) -> None:
        self._network, self._sources = network, sources
        self._roughness = Roughness(network)
        self._last = np.zeros((0, len(sources)))
        self._size = 0
        self.kinks = np.zeros(len(sources))
        self._block = np.zeros((BLOCK, len(sources)))
        self._now = round(network.time * NS_PER_SECOND)
        self._times = [np.zeros(0, dtype=np.int64)]
        self._values = [np.zeros((0, len(sources)))]
        self.count = 0

    @property
    def operations(self) -> tuple[Operation, ...]:
        """Operations that note a step in a row of a block."""
        gathered = gather(self._block, self._network.values, self._sources)
        return gathered, self._roughness.operation

    def before(self) -> None:
        """Before a step."""

    def halt(self) -> None:
        """It makes no steps."""

    def after(
        self, steps: int, size: int, row: int, *, jumped: bool = False, within: bool = False
    ) -> None:
        """After so many steps of `size` [ns]; the operations have filled rows from `row` on."""
        values = self._block[row : row + steps].copy()
        if within:
            self._note(np.array([steps - 1]), values)
        same = size == self._size
        self._note(self._roughness.sudden(row, steps, same=same, jumped=jumped), values)
        if jumped or not same:
            self._roughness.forget()
        self._last, self._size = np.concatenate((self._last, values))[-HISTORY:], size
        self._times.append(self._now + size * np.arange(1, steps + 1))
        self._now += size * steps
        self._values.append(values)
        self.count += steps

    def _note(self, sudden: np.ndarray, values: np.ndarray) -> None:
        """Account for steps (k,) that are suddenly rough."""
        if len(sudden):
            rough = fourth_differences(np.concatenate((self._last, values)))
            found = rough[len(self._last) + sudden].max(axis=0)
            found[found <= NOISE * np.abs(values).max(axis=0)] = 0.0
            self.kinks = np.maximum(self.kinks, found)

    def take(self, until: int) -> tuple[np.ndarray, np.ndarray]:
        """Times [ns] up to `until` (n,) and the values there (n, sources); they are dropped."""
        times, values = np.concatenate(self._times), np.concatenate(self._values)
        count = int(np.searchsorted(times, until, side="right"))
        self._times, self._values = [times[count:]], [values[count:]]
        self.count -= count
        return times[:count], values[:count]


class ShadowRun:
    """Follows a run of `network` with `other`, a network of the same system at its start.

    `make` gives the algorithm that steps `other`; `simulation` is that of the run. Errors are of
    this `order`, steps have this `length` over the run's, TWICE or HALF. `spans` gives the range of
    all outputs of its unit for the range of each source.
    """

    def __init__(
        self,
        network: Network,
        other: Network,
        make: Callable[[Network], Algorithm],
        simulation: Simulation,
        sources: np.ndarray,
        *,
        order: int,
        length: float,
        spans: Callable[[np.ndarray], np.ndarray],
    ) -> None:
        self._network, self._copy = network, other
        self._run, self._other = Recorder(network, sources), Recorder(other, sources)
        algorithm = other.made(make, length)
        size = min(length * simulation.step_size, simulation.stop_time - simulation.start_time)
        longer = replace(simulation, step_size=size, output_interval=None)
        no_bonds = EnergyBalance(other, ())
        self._time_loop = TimeLoop(other, algorithm, no_bonds, longer, watcher=self._other)
        self._size, stop = round(size * NS_PER_SECOND), round(simulation.stop_time * NS_PER_SECOND)
        self._rest = stop if all(rate.shortens for rate in other.rates.values()) else None
        self._twice, self._order = length == TWICE, order
        self._spans = spans
        self._steps = 0
        values = network.values[sources]
        self._difference = np.zeros(len(values))
        self._start = round(network.time * NS_PER_SECOND)
        self._extremes = np.array([values, values])
        self._leaps = np.zeros(len(values))
        self.failure = ""
        """Why the errors are not known, if so."""
        self.switched = False
        """True if discrete values have changed, at other times in the other set."""
        self.longer: Mapping[str, str] = {}

    @property
    def operations(self) -> tuple[Operation, ...]:
        """Note a step of the run in a row of a block."""
        return self._run.operations

    @property
    def room(self) -> int:
        """Steps of the run up to where the second set is to follow."""
        return FAR if self.failure else max(1, BLOCK - self._run.count)

    def before(self) -> None:
        """Before a step of the run."""

    def halt(self) -> None:
        """End steps that are made at once at the next point, called by another thread."""
        self._time_loop.halt()

    def stop(self, why: str) -> None:
        """The second set cannot follow the run any more: the errors are not known."""
        self.failure = self.failure or why

    def after(
        self, steps: int, size: int, row: int, *, jumped: bool = False, within: bool = False
    ) -> None:
        """After steps of the run, as `Recorder.after`."""
        self._steps += steps
        if not self.failure:
            self._run.after(steps, size, row, jumped=jumped, within=within)
            if self._run.count >= BLOCK:
                self._follow()

    def changed(self, changes: Sequence[Change]) -> None:
        """Some values were set at the present point of the run, and exchanged."""
        if self._twice:
            self.stop("values were set between steps, which longer steps cannot reproduce")
        if not self.failure:
            self._follow()
        if not self.failure:
            try:
                self._copy.change(changes)
            except RunError as error:
                self.stop(f"a second set of FMUs fails ({error.message})")

    def finish(self) -> None:
        """At the end of the run."""
        if self._steps < 1 + self._twice:
            self.stop("the run has only one step" if self._steps else "the run has no steps")
        if not self.failure:
            self._follow()

    def _follow(self) -> None:
        """Make all whole steps up to the time of the run; compare."""
        loop, now = self._time_loop, round(self._network.time * NS_PER_SECOND)
        at = loop.position
        try:
            while not loop.over and (now - at.now >= self._size or at.now < now == self._rest):
                self._network.pause()
                loop.prepare()
                loop.advance(max(1, (now - at.now) // self._size))
        except RunError as error:
            name = "twice" if self._twice else "half"
            self.stop(f"steps of {name} the length fail ({error.message})")
            return
        (times, values), (others, again) = (r.take(at.now) for r in (self._run, self._other))
        better = values if self._twice else again
        self._leaps = np.maximum(self._leaps, leaps_of(better))
        known = np.concatenate((self._extremes, better))
        self._extremes = np.array([known.min(axis=0), known.max(axis=0)])
        _, mine, theirs = np.intersect1d(times, others, assume_unique=True, return_indices=True)
        largest = np.abs(self._extremes).max(axis=0)
        differences = off(again[theirs], values[mine], largest)
        self._difference = np.maximum(self._difference, differences.max(axis=0, initial=0.0))

    def errors(self, *, halved: bool = False) -> np.ndarray:
        """Largest known errors (n,) of the sources, in their units, or those at half the step.

        Two runs alone do not show their order: it is the algorithm's, or that of components'
        longer steps. Where outputs have kinks it changes with where these fall in a step, and is
        taken as KINKED; none shows where they make errors of the size of the range.
        """
        found = self._at(self._order)
        spans = self._spans(self.ranges())
        shares = over(found, spans)
        kinked = (self._run.kinks > SMALL * shares.max(initial=0.0) * spans).any()
        # those of inputs held over longer steps fall with these
        if self.switched or (kinked and all(self.longer.values())):
            found = self._at(KINKED)
            return halved_kinks(found, spans) if halved else found
        return found / 2.0**self._order if halved else found

    def _at(self, order: float) -> np.ndarray:
        """The errors of an algorithm of this order."""
        return self._difference / (2.0**order - 1) * (1.0 if self._twice else 2.0**order)

    def coverage(self) -> Coverage:
        """All of the run was followed."""
        start, end = self._start, round(self._network.time * NS_PER_SECOND)
        return Coverage(start, end, followed=((start, end),))

    def leaps(self) -> np.ndarray:
        """Largest changes (n,) of the sources within one step, in their units."""
        return self._leaps

    def ranges(self) -> np.ndarray:
        """Ranges (n,) of the values of the sources, in their units."""
        return np.ptp(self._extremes, axis=0)
