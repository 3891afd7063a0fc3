"""The time loop over a network: integer time, observers, clean ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import cast

from m4e_fmi.cosim.checkpoint.memory import memory, remember
from m4e_fmi.cosim.checkpoint.state import Memory, State
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.error_estimate.estimator import ErrorEstimator, error_estimator, without_rollback
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport
from m4e_fmi.cosim.exchange.events import ended
from m4e_fmi.cosim.exchange.fmu_log import FmuMessage, Journal, Warn
from m4e_fmi.cosim.exchange.interruption import closing_down, same_folder, setting_up, stepping
from m4e_fmi.cosim.exchange.loading.binary import Binary, binaries
from m4e_fmi.cosim.exchange.network import Change, Network
from m4e_fmi.cosim.master import ticking
from m4e_fmi.cosim.master.checkpoints import Checkpoints, saving
from m4e_fmi.cosim.master.discarded import at_every_length
from m4e_fmi.cosim.master.instances import initialised
from m4e_fmi.cosim.master.resume import Resumed
from m4e_fmi.cosim.master.told import certified, early_end, network_notes, unbalanced
from m4e_fmi.cosim.monitoring.instability import Stability
from m4e_fmi.cosim.monitoring.late_dependence import SecondLook
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.stepping.algorithm import Algorithm, ErrorEstimating, Undoing
from m4e_fmi.cosim.stepping.algorithm_choice import error_estimating, made
from m4e_fmi.cosim.stepping.step_control import StepControl
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.cosim.time_loop.energy import BLOCK as ENERGY_BLOCK
from m4e_fmi.cosim.time_loop.energy import BondEnergy, EnergyBalance
from m4e_fmi.cosim.time_loop.time_events import NEXT_EVENT_TIME
from m4e_fmi.cosim.time_loop.time_loop import TimeLoop
from m4e_fmi.errors import RunError
from m4e_fmi.signals import not_lost

Observer = Callable[[float, Network], None]
"""Called at every communication point with the time [s] and the network."""
SECOND_SET = "_again"
"""Ending of the names that FMUs receive for the instances of a shadow run."""


class Master:
    """Owns the instances of a system from `with` to the end of the block."""

    def __init__(
        self,
        prepared: Prepared,
        *,
        certify: bool = True,
        changeable: bool = False,
        recorded: Mapping[str, Collection[str]] | None = None,
        watched: bool = False,
        warn: Warn | None = None,
    ) -> None:
        """With `certify`, steps are made twice, from which `certificate` follows.

        A run is `changeable` if values may be set between its steps. `recorded` are the outputs by
        component that its results will have (None: all scalars), `watched` tells that observers may
        read all others. `warn` is called with the first of each kind of warning or error that an
        FMU logs (`journal`).
        """
        self._prepared = prepared
        simulation = prepared.system.simulation
        self._certify, self._changeable = certify, changeable
        self._journal = Journal(warn, lambda: simulation.start_time)
        self._recorded, self.watched = recorded, watched or changeable
        if recorded is not None:
            names = prepared.descriptions
            self._recorded = {c: {*recorded.get(c, ()), NEXT_EVENT_TIME} for c in names}
        self._changes: list[Change] = []
        self.is_stepping = False
        """True while steps are made, and where they were left unfinished."""
        self._open = ExitStack()
        self._stop = round(simulation.stop_time * NS_PER_SECOND)

    def __enter__(self) -> Master:
        with setting_up(), ExitStack() as stack:
            prepared = self._prepared
            self._loaded = binaries(prepared.descriptions, stack, None, prepared.hosts)
            self.network = self._initialised(prepared, self._loaded, stack, self._journal, "")
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

    def _initialised(
        self,
        prepared: Prepared,
        loaded: Mapping[str, Binary],
        stack: ExitStack,
        journal: Journal | None,
        suffix: str,
    ) -> Network:
        return initialised(
            prepared,
            loaded,
            stack,
            journal,
            recorded=self._recorded,
            watched=self.watched,
            suffix=suffix,
        )

    def _prepare(self, stack: ExitStack) -> None:
        simulation = self._prepared.system.simulation
        self._control, self._algorithm = None, self._make(self.network)
        if simulation.coupling_tolerance is not None:
            largest = round(simulation.step_size * NS_PER_SECOND)
            order = cast("ErrorEstimating", self._algorithm).estimate_order
            self._control = StepControl(self.network, simulation.coupling_tolerance, largest, order)
        if isinstance(self._algorithm, Undoing) and self._shortens:
            for instance in self.network.instances.values():
                instance.stop_at_events()
        bonds = self.network.scenario.untouched(self._prepared.wiring.bonds)
        self._energy = EnergyBalance(self.network, bonds, self._algorithm.followed)
        self.estimator: ErrorEstimator | None = None
        self._unwatched = ""
        self._second_look = SecondLook(self.network)
        if self._certify and self.network.links:
            found = error_estimator(
                self.network,
                self._make,
                self._prepared,
                lambda other: self._second(other, stack),
                order=self.order,
                changeable=self._changeable,
            )
            if isinstance(found, str):
                self._unwatched = found
            else:
                self.estimator = found

    def _make(self, network: Network) -> Algorithm:
        """The algorithm of the system, with an estimate of its error if the steps are adaptive."""
        simulation = self._prepared.system.simulation
        if simulation.coupling_tolerance is None:
            return made(simulation.algorithm, network)
        return error_estimating(simulation.algorithm, network)

    def _without_rollback(self) -> list[str]:
        return without_rollback(self._prepared.descriptions)

    @property
    def _shortens(self) -> bool:
        """True if all components can go back, and make a shorter step then."""
        own = all(rate.shortens for rate in self._prepared.rates.values())
        return own and not self._without_rollback()

    def _second(self, prepared: Prepared, stack: ExitStack) -> Network:
        """A second network at the start time; `stack` closes it."""
        loaded = binaries(prepared.descriptions, stack, self._loaded, prepared.hosts)
        return self._initialised(prepared, loaded, stack, None, SECOND_SET)

    def certificate(self) -> CouplingErrorReport | str:
        """The coupling errors of the run that has ended, or why they are not known."""
        with same_folder(), not_lost():
            return certified(
                self.estimator,
                self.network,
                self._prepared.system.connections,
                unwatched=self._unwatched,
                switched=bool(self._time_loop.switches.count),
            )

    def _stated(self) -> float | None:
        """The largest coupling error up to the present point, over the range, if it is known."""
        found = self.certificate()
        known = isinstance(found, CouplingErrorReport) and found.errors
        return known[0].error if known else None

    @property
    def rejected(self) -> int:
        """Number of steps that were taken back and made again, smaller."""
        return self._time_loop.shortened + (self._control.rejected if self._control else 0)

    @property
    def steps(self) -> int:
        """Number of macro steps from the start to the present point."""
        return self._time_loop.steps

    @property
    def done(self) -> bool:
        """True if the stop time is reached, or an FMU has asked for the end."""
        return self._time_loop.now >= self._stop or self._time_loop.over

    @property
    def ended(self) -> str:
        """The FMUs that asked for the end of the simulation, with times; empty if none did."""
        return ended(self.network.instances.values())

    @property
    def order(self) -> int:
        """The power of the step with which the coupling error falls, at least."""
        return self._algorithm.order

    @property
    def notes(self) -> tuple[str, ...]:
        """Components' own steps, what the algorithm does without, and events; one line each."""
        own = [f"{name} {rate}" for name, rate in self._prepared.rates.items()]
        seen = network_notes(self.network, self._time_loop.switches)
        seen += unbalanced(self.network, self._prepared.wiring.bonds)
        return (*own, *self._algorithm.notes, *seen, *([self.ended] if self.ended else []))

    @property
    def scenario(self) -> tuple[str, ...]:
        """When the actions of the scenario began and ended up to the present point, a line each."""
        return self.network.scenario.told()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the run up to the present point, one line each."""
        grown = self._stability.warning()
        stop = self._prepared.system.simulation.stop_time
        early = early_end(self.network, stop, steps=self.steps)
        certificate = self.certificate() if self._certify else ""
        found = [grown]
        if isinstance(certificate, CouplingErrorReport):
            found += [certificate.warning(advice=not grown), certificate.partial()]
        return (*early, *self._second_look.notes, *filter(None, found))

    @property
    def messages(self) -> tuple[FmuMessage, ...]:
        """Warnings and errors that the FMUs have logged, in the order in which they began."""
        return self._journal.messages(self.network.instances.values())

    @property
    def energy(self) -> tuple[BondEnergy, ...]:
        """The energy balance up to the present point, one entry per power bond."""
        return self._energy.result()

    def run(
        self,
        *,
        results: ResultsWriter | None = None,
        observers: Sequence[Observer] = (),
        progress: ticking.Progress | None = None,
        checkpoints: Checkpoints | None = None,
        resumed: Resumed | None = None,
    ) -> None:
        """Step to the stop time; KeyboardInterrupt and Terminated stop at a communication point.

        `checkpoints` are taken on the way, at the stop time, and where a signal stops the run. It
        begins where it is `resumed`.
        """
        self.begin(results, singly=bool(observers))
        if resumed:
            resumed.bring(self)
        tell, limits = ticking.ticker(progress), [one for one in (resumed, checkpoints) if one]
        self._observe(observers)
        with self._stepping() as check, saving(checkpoints, self, results) as save:
            while not self.done:
                self._advance(min([one.rest(self) for one in limits]) if limits else math.inf)
                if resumed:
                    resumed.compare(self)
                self._observe(observers)
                tell(self._time_loop.now / NS_PER_SECOND)
                save()
                check()

    @contextmanager
    def _stepping(self) -> Generator[Callable[[], None]]:
        """Signals wait for the ends of steps; the yielded call raises them there."""
        loop = self._time_loop
        with stepping(loop.halt, lambda: f" (after t = {loop.time:.9g} s)") as check:
            self.network.pause = check  # it ends steps early that are none of the run
            try:
                yield check
            finally:
                self.network.pause = lambda: None

    @not_lost()
    def begin(self, results: ResultsWriter | None = None, *, singly: bool) -> None:
        """Make ready for steps that are recorded in `results`, one at a time if `singly`."""
        self._results = results
        self._time_loop = TimeLoop(
            self.network,
            self._algorithm,
            self._energy,
            self._prepared.system.simulation,
            results=results,
            watcher=self.estimator,
            control=self._control,
            returns=self._shortens,
            singly=singly,
            most_time=ticking.PROGRESS_INTERVAL,
            hopeless=lambda: self._stability.is_lost(),
        )
        self._stability = Stability(self.network, self._prepared.system.simulation, self._stated)
        self._journal.clock = lambda: self._time_loop.time
        if results is not None and not results.taken_over:
            results.record(self.network.time)

    def _advance(self, most: float = math.inf) -> None:
        """Make as many steps as can be made at once, `most` at most, and look at what has come."""
        try:
            self._time_loop.prepare()
            self.is_stepping = True
            room = self._second_look.room(self.steps) or ENERGY_BLOCK
            self._time_loop.advance(room if room <= most else int(most))
            self.network.flush()
        except RunError as failure:
            step_size = self._prepared.system.simulation.step_size
            error = at_every_length(failure, self._time_loop, step_size)
            told = self._stability.explained(error, self._results)
            if told is failure:
                raise
            raise told from failure
        finally:
            self._journal.check()
        self._stability.look(self.steps)
        if self._second_look.wanted:
            self._second_look.look(self.steps, last=self.done)
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
        self._energy.jump()
        if self.estimator:
            self.estimator.changed(self._changes)
        self._changes = []

    @not_lost()
    def save(self) -> State:
        """The present state of everything; RunError naming FMUs that cannot save theirs."""
        if fixed := self._without_rollback():
            who = " and ".join(fixed)
            raise RunError(
                f"the state cannot be saved: {who} cannot roll back (canGetAndSetFMUstate)",
                "use FMUs that can, or run again from the start",
            )
        point = self.network.keep()
        row = self._results.mark() if self._results else None
        return State(
            self,
            point,
            self._algorithm.snapshot(),
            self._control.snapshot() if self._control else None,
            self._energy.snapshot(),
            self._time_loop.snapshot(),
            self._second_look.snapshot(),
            row,
            self.estimator.snapshot() if self.estimator else None,
        )

    @not_lost()
    def restore(self, state: State) -> None:
        """Return to a state of this run; RunError if there is no way back to it."""
        if state.master is not self:
            raise RunError("the state belongs to another run", "restore it where it was saved")
        if self._results and state.row:
            self._results.back(state.row)
        self.network.restore(state.point)
        self._algorithm.restore(state.algorithm)
        if self._control and state.control:
            self._control.restore(state.control)
        self._energy.restore(state.energy)
        self._time_loop.restore(state.time_loop)
        self._second_look.restore(state.second_look)
        self._stability.back(state.time, self.steps)
        if self.estimator and state.seen:
            self.estimator.restore(state.seen)
        self._changes = []

    def memory(self) -> Memory:
        """All that the run remembers beside its `State`."""
        return memory(self.network, self._journal, self._stability, self._results)

    def remember(self, kept: Memory, warn: Warn | None) -> None:
        """Go on with the memory of the same run in another process; `warn` hears FMUs then."""
        remember(kept, self.network, self._journal, self._stability, self._results, warn)

    def _observe(self, observers: Sequence[Observer]) -> None:
        for observer in observers:
            observer(self.network.time, self.network)
