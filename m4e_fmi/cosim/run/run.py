"""`Run`: the FMUs of a system at a communication point, stepped, saved and restored."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import cast

from m4e_fmi.cosim.error.estimator import ErrorEstimator, error_estimator, without_rollback
from m4e_fmi.cosim.error.report import CouplingErrorReport, certificate
from m4e_fmi.cosim.monitoring.instability import Instability
from m4e_fmi.cosim.monitoring.late_dependence import SecondLook
from m4e_fmi.cosim.network.fmu_log import Journal, Warn
from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.interruption import (
    closing_down,
    quiet,
    same_folder,
    setting_up,
    stepping,
)
from m4e_fmi.cosim.network.loading import Binary, binaries
from m4e_fmi.cosim.network.network import Change, Network
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.run.checkpoint import Checkpoint, Checkpoints, Memory, Saved, State
from m4e_fmi.cosim.run.outcome import NOT_ASKED, Outcome
from m4e_fmi.cosim.stepping.algorithm import (
    BLOCK,
    Algorithm,
    ErrorEstimating,
    Undoing,
    error_estimating,
    made,
)
from m4e_fmi.cosim.stepping.step_control import StepControl
from m4e_fmi.cosim.stepping.time_events import NEXT_EVENT_TIME
from m4e_fmi.cosim.system.simulation import nanoseconds
from m4e_fmi.cosim.system.start_values import Value, start_values
from m4e_fmi.cosim.time_loop.energy import EnergyBalance
from m4e_fmi.cosim.time_loop.time_loop import TimeLoop
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import RunError
from m4e_fmi.report.animation.scene import Scene
from m4e_fmi.signals import Terminated, not_lost

Observer = Callable[[float, Network], None]
"""Called at every communication point with the time [s] and the network."""
PROGRESS_INTERVAL = 0.1
"""Wall seconds between calls of a progress callable."""
SECOND_SET = "_again"
"""Ending of the names that FMUs receive for the instances of a shadow run."""


@dataclass(frozen=True)
class RunOptions:
    """Options of a run; see `m4e_fmi.cosim.run.verbs.run`.

    A run is `changeable` if values may be set between its steps. `observers` are called at every
    communication point; where it is `watched`, they may read all outputs. It is resumed from the
    `checkpoint`. The results carry the `scene`, and replace the files `beside`.
    """

    results: str | Path | None = None
    scene: Scene | None = None
    certify: bool = True
    changeable: bool = False
    observers: Sequence[Observer] = ()
    watched: bool = False
    progress: Callable[[float], None] | None = None
    warn: Warn | None = None
    tell: Callable[[str], None] | None = None
    beside: Sequence[Path] = ()
    checkpoint: Checkpoint | None = None

    def warn_of(self, lines: Sequence[str]) -> None:
        """Tell each of some warnings."""
        if self.warn:
            for line in lines:
                self.warn(f"warning: {line}")


class Run:
    """Owns the instances of a system from `with` to the end of the block; it begins with `begin`.

    Rows go to `results`, the states of a run of this `identity` to `checkpoints`, if they are set
    before. `estimator` repeats steps for the certificate; `unwatched` is the reason without one.
    `is_stepping` is True while steps are made, and after unfinished steps. `warnings` are
    those from before the first step; `outcome` is set when the run has ended without error.
    """

    def __init__(self, prepared: Prepared, options: RunOptions | None = None) -> None:
        self.prepared, self.options = prepared, options or RunOptions()
        self.simulation = prepared.system.simulation
        self._stop = self.simulation.stop_ns
        # what FMUs log at the start was told before a checkpoint
        warn = None if self.options.checkpoint else self.options.warn
        self.journal = Journal(warn, lambda: self.simulation.start_time)
        self.results: ResultsWriter | None = None
        self.checkpoints: Checkpoints | None = None
        self.estimator: ErrorEstimator | None = None
        self.unwatched = "" if self.options.certify else NOT_ASKED
        self.is_stepping = False
        self.identity: dict[str, str] = {}
        self.warnings: tuple[str, ...] = ()
        self.outcome: Outcome | None = None
        self._changes: list[Change] = []
        self._loaded: Mapping[str, Binary] | None = None
        self._open = ExitStack()

    def __enter__(self) -> Run:
        with setting_up(), ExitStack() as stack:
            self.network = self._started(stack, self.prepared)
            self._prepare(stack)
            self._open = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with closing_down():
            self._open.__exit__(kind, error, trace)

    def _started(self, stack: ExitStack, prepared: Prepared) -> Network:
        """New instances of all components, connected, at the start time; `stack` closes them.

        Messages of a second set of instances are dropped.
        """
        second = self._loaded is not None
        loaded = binaries(prepared.descriptions, stack, self._loaded, prepared.hosts)
        self._loaded = self._loaded or loaded
        instances: dict[str, Instance] = {}
        for component in prepared.system.components:
            name, description = component.name, prepared.descriptions[component.name]
            listener = None if second else self.journal.listener(name)
            suffix = SECOND_SET if second else ""
            instance = Instance(name, description, loaded[name], listener, suffix=suffix)
            if not second and (worker := loaded[name].worker):
                worker.notice = self.journal.notice
            stack.enter_context(instance).setup(
                start=self.simulation.start_time,
                stop=self.simulation.last_time,
                tolerance=self.simulation.tolerance,
            )
            instance.set_values(start_values(component, description))
            instances[name] = instance
        recorded = {
            name: {NEXT_EVENT_TIME, *(v.name for v in prepared.recorded.get(name, ()))}
            for name in instances
        }
        watched = self.options.watched or self.options.changeable
        network = Network(prepared, instances, recorded=recorded, watched=watched)
        with quiet():
            network.initialise()
        return network

    def _prepare(self, stack: ExitStack) -> None:
        simulation = self.simulation
        self._control, self.algorithm = None, self._make(self.network)
        if simulation.coupling_tolerance is not None:
            order = cast("ErrorEstimating", self.algorithm).estimate_order
            self._control = StepControl(
                self.network, simulation.coupling_tolerance, simulation.step_ns, order
            )
        own = all(rate.shortens for rate in self.prepared.rates.values())
        self._shortens = own and not without_rollback(self.prepared.descriptions)
        if isinstance(self.algorithm, Undoing) and self._shortens:
            for instance in self.network.instances.values():
                instance.events.goes_on = False  # a step ends at an event within it
        bonds = self.network.scenario.untouched(self.prepared.wiring.bonds)
        self.energy = EnergyBalance(self.network, bonds, self.algorithm.followed)
        self.second_look = SecondLook(self.network)
        if self.options.certify and self.network.links:
            found = error_estimator(
                self.network,
                self._make,
                self.prepared,
                partial(self._started, stack),
                order=self.algorithm.order,
                changeable=self.options.changeable,
            )
            if isinstance(found, str):
                self.unwatched = found
            else:
                self.estimator = found

    def _make(self, network: Network) -> Algorithm:
        """The algorithm of the system, with an estimate of its error if the steps are adaptive."""
        choose = made if self.simulation.coupling_tolerance is None else error_estimating
        return choose(self.simulation.algorithm, network)

    @not_lost()
    def begin(self) -> None:
        """Make ready for steps, from the start time or the checkpoint on."""
        self.time_loop = TimeLoop(
            self.network,
            self.algorithm,
            self.energy,
            self.simulation,
            results=self.results,
            estimator=self.estimator,
            control=self._control,
            returns=self._shortens,
            singly=bool(self.options.observers) or self.options.changeable,
        )
        self.stability = Instability(self.network, self.simulation)
        self.journal.clock = lambda: self.time_loop.time
        if self.options.checkpoint:
            self._resume(self.options.checkpoint.saved)
        elif self.results:
            self.results.record(self.network.time)

    @property
    def done(self) -> bool:
        """True if the stop time is reached, or an FMU has asked for the end."""
        return self.time_loop.position.now >= self._stop or self.network.is_over

    @property
    def is_at_stop(self) -> bool:
        """True if the stop time is reached."""
        return nanoseconds(self.network.time) >= self._stop

    def certificate(self) -> CouplingErrorReport | str:
        """The coupling errors up to the present point, or why they are not known."""
        network, estimator = self.network, self.estimator
        if not network.links:
            return "no Real is exchanged" if network.discrete else CouplingErrorReport(())
        if estimator is None:
            return self.unwatched
        switched = bool(self.time_loop.position.switches.count)
        with same_folder(), not_lost():
            estimator.finish()
            if estimator.failure:
                return estimator.failure
            return certificate(
                network,
                self.prepared.system.connections,
                errors=estimator.errors(),
                halved=estimator.errors(halved=True),
                ranges=estimator.ranges(),
                leaps=estimator.leaps() if switched or network.sampled else None,
                coverage=estimator.coverage(),
                longer=estimator.longer,
                adaptive=self._control is not None,
            )

    @property
    def rejected(self) -> int:
        """Number of steps that were taken back and made again, smaller."""
        shortened = self.time_loop.position.shortened
        return shortened + (self._control.rejected if self._control else 0)

    @property
    def steps(self) -> int:
        """Number of macro steps from the start to the present point."""
        return self.time_loop.position.steps

    def finish(self) -> None:
        """Step to the stop time; KeyboardInterrupt and Terminated stop at a communication point.

        Checkpoints are taken on the way, at the stop time, and where a signal stops the run.
        """
        self._observe()
        progress, last, room = self.options.progress, clock.perf_counter(), math.inf
        with self._stepping() as check:
            try:
                while not self.done:
                    if self.checkpoints:
                        room = self.checkpoints.room(self.network.time)
                    self._advance(room)
                    self._observe()
                    wall = clock.perf_counter()
                    if progress and wall - last >= PROGRESS_INTERVAL:
                        last = wall
                        progress(self.network.time)
                    if self.checkpoints and self.checkpoints.due(self.network.time):
                        self._take_checkpoint()
                    check()
            except (KeyboardInterrupt, Terminated):
                if not self.is_stepping:
                    self._take_checkpoint()
                raise
            self._take_checkpoint()

    def _observe(self) -> None:
        for observer in self.options.observers:
            observer(self.network.time, self.network)

    @contextmanager
    def _stepping(self) -> Generator[Callable[[], None]]:
        """Signals wait for the ends of steps; the yielded call raises them there."""
        loop = self.time_loop
        with stepping(loop.halt, lambda: f" (after t = {loop.time:.9g} s)") as check:
            self.network.pause = check  # it ends steps early that are none of the run
            try:
                yield check
            finally:
                self.network.pause = lambda: None

    def _advance(self, most: float = math.inf) -> None:
        """Make as many steps as can be made at once, `most` at most, and look at what has come."""
        try:
            if self.estimator:
                self.estimator.before()
            self.is_stepping = True
            room = self.second_look.room(self.steps) or BLOCK
            self.time_loop.advance(room if room <= most else int(most))
            self.network.flush()
        except RunError as failure:
            error = self.time_loop.explained(failure)
            if error is failure:
                raise
            raise error from failure
        finally:
            self.journal.check()
        self.stability.look(self.steps)
        if self.second_look.wanted:
            self.second_look.look(self.steps, last=self.done)
        self.is_stepping = False

    def step(self) -> None:
        """Make one step; KeyboardInterrupt and Terminated come after it."""
        with self._stepping():
            self._advance()

    def set(self, component: str, values: Mapping[str, Value]) -> None:
        """Set variables of a component at the present point; `refresh` is to follow."""
        self.network.instances[component].set_values(values)
        self._changes.append((component, values))

    @not_lost()
    def refresh(self) -> None:
        """Make the present point consistent with what was set there, if anything was."""
        if not self._changes:
            return
        self.network.refresh(self._changes)
        self.energy.jump()
        if self.estimator:
            self.estimator.changed(self._changes)
        self._changes = []

    @not_lost()
    def save(self) -> State:
        """The present state of everything; RunError naming FMUs that cannot save theirs."""
        if fixed := without_rollback(self.prepared.descriptions):
            who = " and ".join(fixed)
            raise RunError(
                f"the state cannot be saved: {who} cannot roll back (canGetAndSetFMUstate)",
                "use FMUs that can, or run again from the start",
            )
        return State(
            run=self,
            point=self.network.keep(),
            algorithm=self.algorithm.snapshot(),
            control=self._control.snapshot() if self._control else None,
            energy=self.energy.snapshot(),
            position=deepcopy(self.time_loop.position),
            second_look=self.second_look.snapshot(),
            row=self.results.mark() if self.results else None,
            seen=self.estimator.snapshot() if self.estimator else None,
        )

    @not_lost()
    def restore(self, state: State) -> None:
        """Return to a state of this run; RunError if there is no way back to it."""
        if state.run is not self:
            raise RunError("the state belongs to another run", "restore it where it was saved")
        if self.results and state.row:
            self.results.restore(state.row)
        self.network.restore(state.point)
        self.algorithm.restore(state.algorithm)
        if self._control and state.control:
            self._control.restore(state.control)
        self.energy.restore(state.energy)
        self.time_loop.position = deepcopy(state.position)
        self.second_look.restore(state.second_look)
        self.stability.next = self.steps
        if self.estimator and state.seen:
            self.estimator.restore(state.seen)
        self._changes = []

    def _take_checkpoint(self) -> None:
        """Take a checkpoint here, unless there is one, or the results have no step yet."""
        if not (self.checkpoints and self.results and self.results.mark().rows > 1):
            return
        if self.checkpoints.taken != self.network.time:
            self.checkpoints.write(self.network.time, self._for_checkpoint)

    @not_lost()
    def _for_checkpoint(self) -> Saved:
        """The state for another process; RunError if an FMU or the disk refuses."""
        network, results = self.network, self.results
        assert results
        results.flush()
        mark, state = results.mark(), self.save()
        fmu_states = {
            point.place: {
                name: instance.rollback.serialized(instance.slot(point.place))
                for name, instance in network.instances.items()
            }
            for point in state.points
        }
        warned = {name: instance.warned for name, instance in network.instances.items()}
        memory = Memory(
            {name: (one.count, one.first, one.last) for name, one in warned.items()},
            self.journal.snapshot(),
            results.ranges(),
        )
        return Saved(
            identity=self.identity,
            rows=mark.rows,
            last=mark.last,
            digest=results.last_row(),
            texts=network.discrete.texts.content(),
            state=replace(state, run=None),
            fmu_states=fmu_states,
            memory=memory,
        )

    def _resume(self, saved: Saved) -> None:
        """Go to a checkpoint of the same run in another process."""
        saved.give(self.network)
        self.restore(replace(saved.state, run=self))
        memory = saved.memory
        for name, instance in self.network.instances.items():
            one = instance.warned
            one.count, one.first, one.last = memory.warned[name]
        self.journal.restore(memory.messages, self.options.warn)
        if self.results:
            self.results.restore_ranges(memory.ranges)
