"""Macro steps of a run, many at once where each is like the one before."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from m4e_fmi.cosim.error.estimator import ErrorEstimator
from m4e_fmi.cosim.network.failures import DiscardedError, EndWithinError, EventWithinError
from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.schedule import LoopState, Schedule, StepLoop
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.stepping.algorithm import (
    BLOCK,
    Algorithm,
    ErrorEstimating,
    Scheduled,
    Undoing,
    step_loop,
)
from m4e_fmi.cosim.stepping.step_control import SMALLEST, StepControl
from m4e_fmi.cosim.stepping.time_events import TimeEvents, in_nanoseconds
from m4e_fmi.cosim.system.simulation import NEVER, NS_PER_SECOND, Simulation
from m4e_fmi.cosim.time_loop.energy import EnergyBalance
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.errors import RunError

MOST_DISCARDED = 128
"""Attempts that may be discarded within one step of the simulation's size, if they become SHORT."""
LONGEST = 0.1
"""Seconds of wall time that many steps at once may take."""
SHORT = 1e-3
"""Share of the simulation's step: a run creeps where such steps are discarded again and again."""


@dataclass
class Switches:
    """Steps of a run at whose end values had changed, within the step: `count`, the `first`.

    `late` is the longest of these steps [s]. What a component gives at points of its own, or with
    its events, does not count: it changes at that very time.
    """

    count: int = 0
    first: str = ""
    late: float = 0.0

    def note(self, changed: Sequence[Port], time: float, size: float) -> None:
        """Account for these changes at the end of a step of `size` [s], at `time` [s]."""
        if not changed:
            return
        self.count += 1
        self.first = self.first or f"{changed[0]} at t = {time:.9g} s"
        self.late = max(self.late, size)

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about them, one line each."""
        if not self.count:
            return ()
        steps = "one step" if self.count == 1 else f"{self.count} steps"
        ours = self.first.startswith("scenario.")
        what = "actions of the scenario came due" if ours else "values that are not Real changed"
        return (
            f"{what} within {steps} (first {self.first}): they act from "
            f"the end of the step on, up to {self.late:g} s later than the values they follow",
        )


@dataclass
class Position:
    """The place of a run in time: times in ns, numbers of steps; a copy is a snapshot.

    Steps lead to `now`, the last row of the results is at `row`, or one is due later than there.
    `shortened` counts the steps that were made again, shorter; `discarded` those since the last
    step of full size, which ended at `full`, since when a step as long as `cap` was discarded. The
    next jump is at `jump`. `most` steps are made at once. `switches` are the steps within which
    values changed that are not Real.
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
    """Macro steps of a run, and the rows of its results.

    Steps of a `Scheduled` algorithm are made many at once, for a while of LONGEST; with `singly`
    one by one. They are adaptive with a `control`. Where all FMUs can go back (`returns`), a step
    that one of them discards is made again, shorter. That ends where
    MOST_DISCARDED are not enough.
    """

    def __init__(
        self,
        network: Network,
        algorithm: Algorithm,
        energy: EnergyBalance,
        simulation: Simulation,
        *,
        results: ResultsWriter | None = None,
        estimator: ErrorEstimator | None = None,
        control: StepControl | None = None,
        returns: bool = False,
        singly: bool = False,
    ) -> None:
        self._network, self._algorithm, self._energy = network, algorithm, energy
        self._results, self._estimator, self._control = results, estimator, control
        self._returns, self._singly = returns, singly
        self._start, self._stop = simulation.start_ns, simulation.stop_ns
        self._size = simulation.step_ns
        in_steps = simulation.output_interval is None and control is not None
        self._every = 1 if in_steps else simulation.output_ns
        self._time_events = TimeEvents(network)
        self._has_time_events = bool(self._time_events)
        self._note = Schedule(estimator.operations if estimator else ())
        self._running: LoopState | None = None
        start = self._start
        self.position = Position(start, start, 0, 0, NEVER, Switches(), 0, start, NEVER, 1)

    @property
    def time(self) -> float:
        """Simulated time [s] up to which whole steps are made, also while many are being made."""
        return (self._running or self.position).now / NS_PER_SECOND

    @cached_property
    def _loop(self) -> StepLoop | None:
        if self._control or self._has_time_events:
            return None
        watched = self._estimator.operations if self._estimator else ()
        noted = (*self._energy.operations(self._algorithm.held), *watched)
        rows = self._results.schedule if self._results else None
        every = -(-self._every // self._size)
        loop = step_loop(self._algorithm, self._network, noted, rows, every=every)
        if loop:
            anywhere = self._singly or self._network.telling  # where rows end is not known before
            loop.state.rows_from = self._start if anywhere else self._stop
        return loop

    def halt(self) -> None:
        """End what `advance` does at the next point, called by another thread."""
        loop: StepLoop | None = self.__dict__.get("_loop")
        if loop:
            loop.state.halt = 1
        if self._estimator:
            self._estimator.halt()

    def advance(self, most: int = BLOCK) -> None:
        """Make as many steps as can be made at once, `most` at most, or one; fewer at the end."""
        at = self.position
        if at.jump <= at.now:
            at.jump = NEVER
        if self._has_time_events:
            at.jump = min(at.jump, self._time_events.next(at.now))
        size, loop = self._wanted(), self._loop
        try:
            if loop and cast("Scheduled", self._algorithm).repeats(size / NS_PER_SECOND):
                try:
                    self._repeat(loop, size, most)
                except DiscardedError as discarded:
                    size = self._shorter(size, discarded)
                else:
                    return
            self._single(size)
        except EndWithinError as end:
            if end.reached is not None:
                self._end(in_nanoseconds(end.reached))

    def _end(self, reached: int) -> None:
        """An FMU asked for the end within a step, at `reached` [ns], where not all can go back to.

        The present point is the last one, unless there is no other component to be anywhere.
        """
        network, at = self._network, self.position
        if len(network.instances) > 1 or reached <= at.now:
            return
        size, at.now = (reached - at.now) / NS_PER_SECOND, reached
        for name in network.instances:
            Schedule(network.arrival(name)).run(at.now / NS_PER_SECOND)
        network.size = size
        network.advance(at.now / NS_PER_SECOND)
        self._energy.add(self._algorithm.held, size)
        at.steps += 1
        self._record()

    def _repeat(self, loop: StepLoop, size: int, most: int) -> None:
        """Make equal steps of `size` [ns], `most` at most."""
        at, results, state, began = self.position, self._results, loop.state, clock.perf_counter()
        first = at.now
        state.now, state.size, state.noted, state.halt = first, size, self._energy.noted, 0
        state.since = max(0, state.every - -(-(at.row + self._every - first) // size))
        state.written = row = results.row if results else 0
        start, noted = first - state.since * size, state.noted
        self._running = state
        try:
            loop.advance(min(most, self._count(loop, size)))
        finally:
            self._running = None
            made = (state.now - first) // size
            at.now, self._network.time = state.now, state.now / NS_PER_SECOND
            at.steps += made
            self._energy.note(made, size / NS_PER_SECOND)
            if results and state.written > row:
                apart = state.every * size
                at.row = start + (state.written - row) * apart
                results.keep(np.arange(start + apart, at.row + 1, apart) / NS_PER_SECOND)
            changed = self._network.settle()
            switched = self._switched(changed, size)
            if self._estimator:
                self._estimator.after(made, size, noted, jumped=bool(changed), within=switched)
        if results and at.row != at.now and (at.now == self._stop or self._network.is_over):
            self._record()
        spent = clock.perf_counter() - began
        if not self._singly and spent < LONGEST / 2:
            at.most = min(2 * at.most, BLOCK)
        elif spent > LONGEST:
            at.most = max(1, at.most // 2)

    def _count(self, loop: StepLoop, size: int) -> int:
        """Steps until the wall time, the run or a block may be over."""
        if size < self._size:  # to where steps would end had none been shortened
            return 1
        room = BLOCK - self._energy.noted
        if self._estimator:
            room = min(room, self._estimator.room)
        if self._results:
            room = min(room, self._results.room * loop.state.every - loop.state.since)
        return max(1, min(self.position.most, room, (self._stop - self.position.now) // size))

    def _single(self, size: int) -> None:
        """Make a step of `size` [ns], or what FMUs and control allow."""
        at, before = self.position, self._event_count()
        size = self._step(size)
        at.now += size
        full = (at.now - self._start) % self._size == 0
        at.cap = NEVER if full else max(at.cap, 2 * size)
        within = self._event_count() > before and at.now != at.jump
        jumped = within or at.now == at.jump
        if jumped:
            self._network.forget()
        changed = self._network.advance(at.now / NS_PER_SECOND)
        within = self._switched(changed, size) or within
        self._energy.add(self._algorithm.held, size / NS_PER_SECOND, self._network.left)
        at.steps += 1
        if self._estimator:
            self._note.run(self._network.time)
            self._estimator.after(1, size, 0, jumped=jumped or bool(changed), within=within)
        if at.now == self._stop or self._network.is_over or at.now >= at.row + self._every:
            self._record()

    def explained(self, error: RunError) -> RunError:
        """`error`, or the error of an FMU that discards steps of all lengths."""
        if not isinstance(error, DiscardedError) or isinstance(error, EventWithinError):
            return error
        step_size = self._size / NS_PER_SECOND
        sizes = f"{step_size:g} s down to {error.size:.3g} s"
        if error.size <= 2 * SMALLEST * step_size:
            tried = f"every step from there, of {sizes}"
        elif self.position.discarded >= MOST_DISCARDED:
            since = self.position.full / NS_PER_SECOND
            tried = f"{self.position.discarded} steps since t = {since:.9g} s, of {sizes}"
        else:
            return error
        first = "fix the problem stated by the FMU first"
        return RunError(
            f"{error.message}; {error.component} has discarded {tried}",
            f"{first}; "
            * error.remedy.startswith(first)
            + f"no step_size helps: check what {error.component} cannot compute there, and at "
            "its inputs in the results",
        )

    def _event_count(self) -> int:
        """How many events there were, in steps that were taken back, too."""
        return sum(instance.events.handled for instance in self._network.telling)

    def _switched(self, changed: Sequence[Port], size: int) -> bool:
        """Note outputs that have `changed` at the present point; whether within the last step."""
        within = self._network.within_step(changed)
        at = self.position
        at.switches.note(within, at.now / NS_PER_SECOND, size / NS_PER_SECOND)
        return bool(within)

    def _record(self) -> None:
        at = self.position
        if at.now >= at.row + self._every:  # a row at the end between two moves none after it
            at.row = at.now
        if self._results:
            self._results.record(self._network.time)

    def _step(self, size: int) -> int:
        """Step all components by `size` if that may be; the size of the step [ns]."""
        at, control, algorithm = self.position, self._control, self._algorithm
        discrete = self._network.discrete.values.copy()
        while True:
            try:
                algorithm.step(at.now / NS_PER_SECOND, size / NS_PER_SECOND)
            except DiscardedError as discarded:
                size = self._shorter(size, discarded)
                continue
            if control is None:
                return size
            algorithm = cast("ErrorEstimating", algorithm)
            switched = self._network.discrete.differs(discrete) and control.shrinks(size)
            if not switched and at.now + size == at.jump:
                control.pass_over(algorithm.end, at.jump)
                return size
            if not switched and control.accepts(algorithm.change, algorithm.end, at.now, size):
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
        at = self.position
        if self._control is None:
            rest = self._size - (at.now - self._start) % self._size
            return self._until_jump(min(rest, self._stop - at.now, at.cap))
        row = at.row + self._every
        end = min(row, self._stop) if row > at.now + 1 else self._stop
        return self._until_jump(min(self._control.size, end - at.now))

    def _until_jump(self, size: int) -> int:
        """A step of `size` [ns], or to just before the next jump, or over it."""
        ahead = self.position.jump - self.position.now
        if ahead > size or not all(rate.shortens for rate in self._network.rates.values()):
            return size
        return min(size, ahead - 1 if ahead > 1 else ahead)

    def _shorter(self, size: int, discarded: DiscardedError) -> int:
        """Take back the step of `size` that an FMU has discarded; the size to try next.

        That is up to where the FMU could go, or to its event, or half. Raises what it is given if
        there is no way back, the step is too short already, or the run only creeps on from here.
        """
        at, reached = self.position, discarded.reached
        is_event = isinstance(discarded, EventWithinError)
        is_end = isinstance(discarded, EndWithinError)
        smallest = 1 if is_event else max(1, round(SMALLEST * self._size))
        if not self._returns or size <= smallest or not isinstance(self._algorithm, Undoing):
            raise discarded
        self._algorithm.undo()
        at.shortened += 1
        if not (is_event or is_end):
            full = at.now - (at.now - self._start) % self._size
            if full != at.full:
                at.full, at.discarded = full, 0
            at.discarded += 1
            at.cap = size
            if at.discarded >= MOST_DISCARDED and size <= SHORT * self._size:
                raise discarded
        if is_event and reached is not None:
            at.jump = max(at.now + 1, in_nanoseconds(reached))
            return self._until_jump(size - 1)
        if is_end and reached is not None:
            possible = in_nanoseconds(reached) - at.now
        else:
            possible = round((reached or 0.0) * NS_PER_SECOND) - at.now
        return possible if smallest <= possible < size else max(smallest, size // 2)
