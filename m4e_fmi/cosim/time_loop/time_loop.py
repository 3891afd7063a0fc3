"""Macro steps of a run, many at once where each is like the one before."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, cast

import numpy as np

from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.cosim.exchange.discrete import Switches
from m4e_fmi.cosim.exchange.events import event_count, is_over, telling
from m4e_fmi.cosim.exchange.failures import DiscardedError, EndWithinError, EventWithinError
from m4e_fmi.cosim.exchange.native_executor import State
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.exchange.operations import Operation
from m4e_fmi.cosim.exchange.step_loop import Schedule, StepLoop
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.stepping.algorithm import Algorithm, ErrorEstimating, Undoing
from m4e_fmi.cosim.stepping.scheduled import Scheduled, step_loop
from m4e_fmi.cosim.stepping.step_control import SMALLEST, StepControl
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND, Simulation
from m4e_fmi.cosim.time_loop.energy import BLOCK as ENERGY_BLOCK
from m4e_fmi.cosim.time_loop.energy import EnergyBalance
from m4e_fmi.cosim.time_loop.time_events import NEVER, TimeEvents, in_nanoseconds

MOST_DISCARDED = 128
"""Attempts that may be discarded within one step of the simulation's size, if they become SHORT."""
SHORT = 1e-3
"""Share of the simulation's step: a run creeps where such steps are discarded again and again."""


class Watcher(Protocol):
    """Looks at every step of a run; where many are made at once, as far as there is `room`.

    Its `operations` are performed after each step, in rows of a block.
    """

    @property
    def operations(self) -> tuple[Operation, ...]: ...
    @property
    def room(self) -> int: ...
    def before(self) -> None: ...
    def halt(self) -> None: ...
    def after(
        self, steps: int, size: int, row: int, *, jumped: bool = False, within: bool = False
    ) -> None: ...


@dataclass(frozen=True)
class TimeLoopSnapshot:
    """The place in the run: times in ns, numbers of steps, and switches so far.

    `most` is the number of steps that are made at once.
    """

    now: int
    row: int
    steps: int
    shortened: int
    jump: int
    switches: Switches
    discarded: int
    full: int
    cap: int
    most: int


class TimeLoop:
    """Macro steps from `now` [ns] on, and the rows of the results.

    Steps of a `Scheduled` algorithm are made many at once, as long as `most_time` [s of wall time]
    allows; with `singly` one by one. They are adaptive with a `control`. Where all FMUs can go back
    (`returns`), a step that one of them discards is made again, shorter; `shortened` counts them.
    That ends where `hopeless` tells so, or where MOST_DISCARDED are not enough: `discarded` counts
    those since the time `since` [s], at which the last step of full size ended.
    `switches` are the steps within which values changed that are not Real.
    """

    def __init__(
        self,
        network: Network,
        algorithm: Algorithm,
        energy: EnergyBalance,
        simulation: Simulation,
        *,
        results: ResultsWriter | None = None,
        watcher: Watcher | None = None,
        control: StepControl | None = None,
        returns: bool = False,
        singly: bool = False,
        most_time: float,
        hopeless: Callable[[], bool] = lambda: False,
    ) -> None:
        self._network, self._algorithm, self._energy = network, algorithm, energy
        self._results, self._watcher, self._control = results, watcher, control
        self._returns, self._singly, self._most_time = returns, singly, most_time
        self._hopeless = hopeless
        self._start = round(simulation.start_time * NS_PER_SECOND)
        self._stop = round(simulation.stop_time * NS_PER_SECOND)
        self._size = round(simulation.step_size * NS_PER_SECOND)
        every = round((simulation.output_interval or simulation.step_size) * NS_PER_SECOND)
        self._every = every if simulation.output_interval or control is None else 1
        self._time_events = TimeEvents(network)
        self._has_time_events = bool(self._time_events)
        self._telling = telling(network.instances.values())
        self._events = tuple(instance.events for instance in network.instances.values())
        self._note = Schedule(watcher.operations if watcher else ())
        self._most = 1
        self._running: State | None = None
        self.now = self._row = self._start
        self._full = self._start
        self.steps = self.shortened = self.discarded = 0
        self.switches = Switches()
        self._jump = NEVER
        self._cap = NEVER  # [ns]: a step as long was discarded since the last full one

    def snapshot(self) -> TimeLoopSnapshot:
        """The place in the run as it is now."""
        return TimeLoopSnapshot(
            self.now,
            self._row,
            self.steps,
            self.shortened,
            self._jump,
            copy(self.switches),
            self.discarded,
            self._full,
            self._cap,
            self._most,
        )

    def restore(self, snapshot: TimeLoopSnapshot) -> None:
        """Continue as from where the snapshot was taken."""
        self.now, self._row, self.steps = snapshot.now, snapshot.row, snapshot.steps
        self.shortened, self.discarded = snapshot.shortened, snapshot.discarded
        self._jump, self._full, self._cap = snapshot.jump, snapshot.full, snapshot.cap
        self._most = 1 if self._singly else snapshot.most
        self.switches = copy(snapshot.switches)

    @property
    def time(self) -> float:
        """Simulated time [s] up to which whole steps are made, also while many are being made."""
        return (self._running.now if self._running else self.now) / NS_PER_SECOND

    @property
    def since(self) -> float:
        """The time [s] from which on steps are `discarded`."""
        return self._full / NS_PER_SECOND

    @cached_property
    def _loop(self) -> StepLoop | None:
        if self._control or self._has_time_events:
            return None
        watched = self._watcher.operations if self._watcher else ()
        noted = (*self._energy.operations(self._algorithm.held), *watched)
        rows = self._results.schedule if self._results else None
        every = -(-self._every // self._size)
        loop = step_loop(self._algorithm, self._network, noted, rows, every=every)
        if loop:
            anywhere = self._singly or self._telling  # where rows end is not known before
            loop.state.rows_from = self._start if anywhere else self._stop
        return loop

    @property
    def over(self) -> bool:
        """True if an FMU has asked for the end of the simulation."""
        return is_over(self._events)

    def halt(self) -> None:
        """End what `advance` does at the next point, called by another thread."""
        loop: StepLoop | None = self.__dict__.get("_loop")
        if loop:
            loop.state.halt = 1
        if self._watcher:
            self._watcher.halt()

    def prepare(self) -> None:
        """Do what the watcher does between steps; before each `advance`."""
        if self._watcher:
            self._watcher.before()

    def advance(self, most: int = ENERGY_BLOCK) -> None:
        """Make as many steps as can be made at once, `most` at most, or one; fewer at the end."""
        try:
            self._advance(most)
        except EndWithinError as end:
            self._end(end.reached)

    def _end(self, reached: float | None) -> None:
        """An FMU asked for the end within a step, and not all can go back to be where it is.

        The present point is the last one, unless there is no other component to be anywhere.
        """
        network, now = self._network, self.now
        self.now = in_nanoseconds(reached) if reached is not None else now
        if len(network.instances) > 1 or self.now <= now:
            self.now = now
            return
        for name in network.instances:
            Schedule(network.arrival(name)).run(self.now / NS_PER_SECOND)
        network.size = (self.now - now) / NS_PER_SECOND
        network.advance(self.now / NS_PER_SECOND)
        self._energy.add(self._algorithm.held, network.size)
        self.steps += 1
        self._record()

    def _advance(self, most: int) -> None:
        if self._jump <= self.now:
            self._jump = NEVER
        if self._has_time_events:
            self._jump = min(self._jump, self._time_events.next(self.now))
        size, loop = self._wanted(), self._loop
        if loop and cast("Scheduled", self._algorithm).repeats(size / NS_PER_SECOND):
            try:
                self._repeat(loop, size, most)
            except DiscardedError as discarded:
                size = self._shorter(size, discarded)
            else:
                return
        self._single(size)

    def _repeat(self, loop: StepLoop, size: int, most: int) -> None:
        """Make equal steps of `size` [ns], `most` at most."""
        state, began, first = loop.state, clock.perf_counter(), self.now
        state.now, state.size, state.noted, state.halt = first, size, self._energy.noted, 0
        state.since = max(0, state.every - -(-(self._row + self._every - first) // size))
        state.written = row = self._results.row if self._results else 0
        start, noted = first - state.since * size, state.noted
        self._running = state
        try:
            loop.advance(min(most, self._count(loop, size)))
        finally:
            self._running = None
            made = (state.now - first) // size
            self.now, self._network.time = state.now, state.now / NS_PER_SECOND
            self.steps += made
            self._energy.note(made, size / NS_PER_SECOND)
            if self._results and state.written > row:
                rows, apart = state.written - row, state.every * size
                self._row = start + rows * apart
                self._results.keep(np.arange(start + apart, self._row + 1, apart) / NS_PER_SECOND)
            changed = self._network.settle()
            switched = self._switched(changed, size)
            if self._watcher:
                self._watcher.after(made, size, noted, jumped=bool(changed), within=switched)
        if self._results and self._row != self.now and (self.now == self._stop or self.over):
            self._record()
        self._adapt(clock.perf_counter() - began)

    def _count(self, loop: StepLoop, size: int) -> int:
        """Steps until the wall time, the run or a block may be over."""
        if size < self._size:  # to where steps would end had none been shortened
            return 1
        room = ENERGY_BLOCK - self._energy.noted
        if self._watcher:
            room = min(room, self._watcher.room)
        if self._results:
            room = min(room, self._results.room * loop.state.every - loop.state.since)
        return max(1, min(self._most, room, (self._stop - self.now) // size))

    def _adapt(self, spent: float) -> None:
        if self._singly:
            return
        if spent < self._most_time / 2:
            self._most = min(2 * self._most, ENERGY_BLOCK)
        elif spent > self._most_time:
            self._most = max(1, self._most // 2)

    def _single(self, size: int) -> None:
        """Make a step of `size` [ns], or what FMUs and control allow."""
        before = event_count(self._telling)
        size = self._step(size)
        self.now += size
        full = (self.now - self._start) % self._size == 0
        self._cap = NEVER if full else max(self._cap, 2 * size)
        within = event_count(self._telling) > before and self.now != self._jump
        jumped = within or self.now == self._jump
        if jumped:
            self._network.forget()
        changed = self._network.advance(self.now / NS_PER_SECOND)
        within = self._switched(changed, size) or within
        self._energy.add(self._algorithm.held, size / NS_PER_SECOND, self._network.left)
        self.steps += 1
        if self._watcher:
            self._note.run(self._network.time)
            self._watcher.after(1, size, 0, jumped=jumped or bool(changed), within=within)
        last = self.now == self._stop or self.over
        if last or self.now >= self._row + self._every:
            self._record()

    def _switched(self, changed: Sequence[Port], size: int) -> bool:
        """Note outputs that have `changed` at the present point; whether within the last step."""
        within = self._network.within_step(changed)
        self.switches.note(within, self.now / NS_PER_SECOND, size / NS_PER_SECOND)
        return bool(within)

    def _record(self) -> None:
        if self.now >= self._row + self._every:  # a row at the end between two moves none after it
            self._row = self.now
        if self._results:
            self._results.record(self._network.time)

    def _step(self, size: int) -> int:
        """Step all components by `size` if that may be; the size of the step [ns]."""
        now, control, algorithm = self.now, self._control, self._algorithm
        discrete = self._network.discrete.values.copy()
        while True:
            try:
                algorithm.step(now / NS_PER_SECOND, size / NS_PER_SECOND)
            except DiscardedError as discarded:
                size = self._shorter(size, discarded)
                continue
            if control is None:
                return size
            algorithm = cast("ErrorEstimating", algorithm)
            if self._network.discrete.differs(discrete) and control.shrinks(size):
                algorithm.undo()
                size = self._wanted()
                continue
            if now + size == self._jump:
                control.pass_over(algorithm.end, self._jump)
                return size
            if control.accepts(algorithm.change, algorithm.end, now, size):
                if control.passed:
                    self._network.forget()
                return size
            algorithm.undo()
            size = self._wanted()

    def _wanted(self) -> int:
        """The size of the next step if no FMU objects.

        Adaptive steps end where the next row of the results is due; others where they would if none
        had been shortened; all just before a jump, and just after it.
        """
        now = self.now
        if self._control is None:
            rest = self._size - (now - self._start) % self._size
            size = min(rest, self._stop - now, self._cap)
            return self._until_jump(size)
        row = self._row + self._every
        end = min(row, self._stop) if row > now + 1 else self._stop
        return self._until_jump(min(self._control.size, end - now))

    def _until_jump(self, size: int) -> int:
        """A step of `size` [ns], or to just before the next jump, or over it."""
        ahead = self._jump - self.now
        if ahead > size or not all(rate.shortens for rate in self._network.rates.values()):
            return size
        return min(size, ahead - 1 if ahead > 1 else ahead)

    def _shorter(self, size: int, discarded: DiscardedError) -> int:
        """Take back the step of `size` that an FMU has discarded; the size to try next.

        That is up to where the FMU could go, or to its event, or half. Raises what it is given if
        there is no way back, or the step is too short already.
        """
        smallest = max(1, round(SMALLEST * self._size))
        event = isinstance(discarded, EventWithinError)
        if event:
            smallest = 1
        if not self._returns or size <= smallest or not isinstance(self._algorithm, Undoing):
            raise discarded
        self._algorithm.undo()
        self.shortened += 1
        if not isinstance(discarded, EventWithinError | EndWithinError):
            self._count_discarded(size, discarded)
        if event and discarded.reached is not None:
            self._jump = max(self.now + 1, in_nanoseconds(discarded.reached))
            return self._until_jump(size - 1)
        reached = round((discarded.reached or 0.0) * NS_PER_SECOND) - self.now
        if isinstance(discarded, EndWithinError) and discarded.reached is not None:
            reached = in_nanoseconds(discarded.reached) - self.now
        return reached if smallest <= reached < size else max(smallest, size // 2)

    def _count_discarded(self, size: int, discarded: DiscardedError) -> None:
        """Count a discarded step of `size` [ns]; raise it if the run only creeps on from here."""
        full = self.now - (self.now - self._start) % self._size
        if full != self._full:
            self._full, self.discarded = full, 0
        self.discarded += 1
        self._cap = size
        creeps = self.discarded >= MOST_DISCARDED and size <= SHORT * self._size
        if creeps or self._hopeless():
            raise discarded
