"""How a run goes on: step by step, or many steps of a schedule at once.

Both make macro steps from `now` [ns] and have the rows of the results written; `advance` comes back
at a communication point, where observers may look and the run may be interrupted.
"""

from __future__ import annotations

import time as clock
from typing import Protocol, cast

from m4e_fmi.cosim.algorithms import Algorithm, Returning, Undoing
from m4e_fmi.cosim.algorithms.scheduled import Scheduled
from m4e_fmi.cosim.energy import BLOCK as ENERGY_BLOCK
from m4e_fmi.cosim.energy import EnergyBalance
from m4e_fmi.cosim.instance import DiscardedError
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.operations import Operation
from m4e_fmi.cosim.results import ResultsWriter
from m4e_fmi.cosim.schedule import Loop, Schedule
from m4e_fmi.cosim.step_control import SMALLEST, StepControl
from m4e_fmi.cosim.system import SECOND, Simulation


class Watcher(Protocol):
    """What looks at every step of a run; where many are made at once, as far as there is `room`.

    `operations` are performed in each of these, in rows of a block that are counted from `row` on.
    """

    @property
    def operations(self) -> tuple[Operation, ...]: ...
    @property
    def room(self) -> int: ...
    def before(self) -> None: ...
    def after(self, steps: int = 1, row: int | None = None) -> None: ...


class Stepwise:
    """One macro step at a time, of any algorithm; adaptive with a `control`.

    Where all FMUs can go back (`returns`), a step that one of them discards is made again, shorter;
    `shortened` counts them.
    """

    REMEMBERED = ("now", "_row", "steps", "shortened")

    def __init__(
        self,
        network: Network,
        algorithm: Algorithm,
        energy: EnergyBalance,
        simulation: Simulation,
        results: ResultsWriter | None,
        witness: Watcher | None,
        control: StepControl | None,
        *,
        returns: bool,
    ) -> None:
        self._network, self._algorithm, self._energy = network, algorithm, energy
        self._results, self._witness, self._control = results, witness, control
        self._returns = returns
        self._start = round(simulation.start_time * SECOND)
        self._stop = round(simulation.stop_time * SECOND)
        self._size = round(simulation.step_size * SECOND)
        every = round((simulation.output_interval or simulation.step_size) * SECOND)
        self._every = every if simulation.output_interval or control is None else 1
        self.now = self._row = self._start
        self.steps = self.shortened = 0

    def advance(self, most: int = 1) -> None:
        """Make a step."""
        del most
        if self._witness:
            self._witness.before()
        size = self._step()
        self.now += size
        self._network.advance(self.now / SECOND)
        self._energy.add(self._algorithm.held, size / SECOND)
        self.steps += 1
        if self._witness:
            self._witness.after()
        if self.now >= self._row + self._every or self.now == self._stop:
            self._row = self.now
            if self._results is not None:
                self._results.record(self._network.time)

    def _step(self) -> int:
        """Step all components; the size of the step [ns]."""
        now, control, algorithm = self.now, self._control, self._algorithm
        size = self._wanted()
        while True:
            try:
                algorithm.step(now / SECOND, size / SECOND)
            except DiscardedError as discarded:
                size = self._shorter(size, discarded)
                continue
            if control is None:
                return size
            algorithm = cast("Returning", algorithm)
            if control.accepts(algorithm.change, algorithm.end, size):
                return size
            algorithm.undo()
            size = self._wanted()

    def _wanted(self) -> int:
        """The size of the next step if no FMU objects.

        Adaptive steps end where the next row of the results is due; others where they would if none
        had been shortened.
        """
        now = self.now
        if self._control is None:
            return min(self._size - (now - self._start) % self._size, self._stop - now)
        row = self._row + self._every
        end = min(row, self._stop) if row > now + 1 else self._stop
        return min(self._control.size, end - now)

    def _shorter(self, size: int, discarded: DiscardedError) -> int:
        """Take back the step of `size` that an FMU has discarded; the size to try next.

        That is up to where the FMU could go, or half. Raises what it is given if there is no way
        back, or the step is too short already.
        """
        smallest = max(1, round(SMALLEST * self._size))
        if not self._returns or size <= smallest or not isinstance(self._algorithm, Undoing):
            raise discarded
        self._algorithm.undo()
        self.shortened += 1
        reached = round((discarded.reached or 0.0) * SECOND) - self.now
        return reached if smallest <= reached < size else max(smallest, size // 2)


class Repeated:
    """Many equal steps of a schedule in one call, as long as `most_time` [s of wall time] allows.

    With `singly` it comes back after each step.
    """

    REMEMBERED = ("_place", "steps", "shortened")

    def __init__(
        self,
        network: Network,
        algorithm: Scheduled,
        energy: EnergyBalance,
        simulation: Simulation,
        results: ResultsWriter | None,
        witness: Watcher | None,
        *,
        singly: bool,
        most_time: float,
    ) -> None:
        self._network, self._algorithm, self._energy = network, algorithm, energy
        self._results, self._singly, self._most_time = results, singly, most_time
        self._witness = witness
        self._stop = round(simulation.stop_time * SECOND)
        self._size = round(simulation.step_size * SECOND)
        every = round((simulation.output_interval or simulation.step_size) * SECOND)
        step = (*algorithm.operations, *network.operations, *energy.operations(algorithm.held))
        step += witness.operations if witness else ()
        self._loop = Loop(
            Schedule(step),
            results.schedule if results else None,
            now=round(simulation.start_time * SECOND),
            every=-(-every // self._size),
        )
        self._most = 1
        self.steps = self.shortened = 0

    @property
    def now(self) -> int:
        """The present communication point [ns]."""
        return self._loop.state.now

    @property
    def _place(self) -> tuple[int, int]:
        """The present point [ns], and the steps since the last row of the results."""
        return self._loop.state.now, self._loop.state.since

    @_place.setter
    def _place(self, place: tuple[int, int]) -> None:
        self._loop.state.now, self._loop.state.since = place

    def advance(self, most: int = ENERGY_BLOCK) -> None:
        """Make as many steps as can be made at once, at `most` so many."""
        if self._witness:
            self._witness.before()
        state, began = self._loop.state, clock.perf_counter()
        first, unrecorded = state.now, state.since
        state.size = min(self._size, self._stop - first)
        state.noted = noted = self._energy.noted
        state.written = row = self._results.row if self._results else 0
        steady = self._algorithm.prepare(state.size / SECOND)
        try:
            self._loop.advance(min(most, self._count()) if steady else 1)
        finally:
            made = (state.now - first) // state.size
            self.steps += made
            self._energy.note(made, state.size / SECOND)
            self._network.time = state.now / SECOND
            if self._results:
                start, interval = first - unrecorded * state.size, state.every * state.size
                rows = range(1, state.written - row + 1)
                self._results.keep([(start + k * interval) / SECOND for k in rows])
        if self._witness:
            self._witness.after((state.now - first) // state.size, noted)
        if state.now == self._stop and state.since and self._results:
            self._results.record(state.now / SECOND)
        self._adapt(clock.perf_counter() - began)

    def _count(self) -> int:
        """Steps until the wall time, the run or a block may be over."""
        state = self._loop.state
        room = ENERGY_BLOCK - state.noted
        if self._witness:
            room = min(room, self._witness.room)
        if self._results:
            room = min(room, self._results.room * state.every - state.since)
        return max(1, min(self._most, room, (self._stop - state.now) // state.size))

    def _adapt(self, spent: float) -> None:
        if self._singly:
            return
        if spent < self._most_time / 2:
            self._most = min(2 * self._most, ENERGY_BLOCK)
        elif spent > self._most_time:
            self._most = max(1, self._most // 2)
