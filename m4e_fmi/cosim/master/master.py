"""The time loop over a network: integer time, observers, clean ends."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from m4e_fmi.cosim.connections.links import Wiring
from m4e_fmi.cosim.connections.structure import Structure
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport, Spans, certificate
from m4e_fmi.cosim.error_estimate.shadow_run import ShadowRun
from m4e_fmi.cosim.error_estimate.step_doubling import Seen, StepDoublingEstimator
from m4e_fmi.cosim.exchange.events import ended, ended_at_once, event_notes
from m4e_fmi.cosim.exchange.failures import DiscardedError, EventWithinError
from m4e_fmi.cosim.exchange.fmu_log import FmuMessage, Journal, Warn
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.interruption import quiet, same_folder, setting_up, stepping
from m4e_fmi.cosim.exchange.layout import NetworkSnapshot
from m4e_fmi.cosim.exchange.loading.binary import Binary, binaries
from m4e_fmi.cosim.exchange.network import HALF, TWICE, Change, Network
from m4e_fmi.cosim.monitoring.instability import Stability
from m4e_fmi.cosim.monitoring.late_dependence import SecondLook, SecondLookSnapshot
from m4e_fmi.cosim.results.writer import Mark, ResultsWriter
from m4e_fmi.cosim.stepping.algorithm import (
    Algorithm,
    AlgorithmSnapshot,
    ErrorEstimating,
    Undoing,
)
from m4e_fmi.cosim.stepping.algorithm_choice import error_estimating, made
from m4e_fmi.cosim.stepping.step_control import SMALLEST, StepControl, StepControlSnapshot
from m4e_fmi.cosim.system.component_steps import ComponentSteps
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.system.start_values import Value, start_values
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.time_loop.energy import BLOCK as ENERGY_BLOCK
from m4e_fmi.cosim.time_loop.energy import BondEnergy, EnergyBalance, EnergySnapshot
from m4e_fmi.cosim.time_loop.time_events import NEXT_EVENT_TIME
from m4e_fmi.cosim.time_loop.time_loop import MOST_DISCARDED, TimeLoop, TimeLoopSnapshot
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.signals import not_lost

Observer = Callable[[float, Network], None]
"""Called at every communication point with the time [s] and the network."""
Progress = Callable[[float], None]
"""Called now and then with the simulated time [s]."""

PROGRESS_INTERVAL = 0.1
"""Wall seconds between calls of a progress callable."""
SECOND_SET = "_again"
"""What the names end with that FMUs hear of instances beside the run."""


@dataclass(frozen=True, eq=False)
class State:
    """The state of a whole system at a communication point of a run, until that ends.

    It holds the states of the FMUs, the exchanged values, what the algorithm knows of the past,
    the energy balance, the integer time, the row of the results, and what is known of the errors.
    """

    master: Master = field(repr=False)
    point: NetworkSnapshot = field(repr=False)
    algorithm: AlgorithmSnapshot = field(repr=False)
    control: StepControlSnapshot | None = field(repr=False)
    energy: EnergySnapshot = field(repr=False)
    time_loop: TimeLoopSnapshot = field(repr=False)
    second_look: SecondLookSnapshot = field(repr=False)
    row: Mark | None = field(repr=False)
    seen: Seen | None = field(repr=False)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.point.time


class Master:
    """Owns the instances of a system from `with` to the end of the block."""

    def __init__(
        self,
        system: System,
        descriptions: dict[str, Description],
        wiring: Wiring,
        structure: Structure,
        rates: ComponentSteps,
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
        self._system = system
        self._descriptions = descriptions
        self._wiring = wiring
        self._structure = structure
        self._rates = rates
        self._certify, self._changeable = certify, changeable
        self._journal = Journal(warn, lambda: system.simulation.start_time)
        self._recorded, self._watched = recorded, watched or changeable
        if recorded is not None:
            self._recorded = {c: {*recorded.get(c, ()), NEXT_EVENT_TIME} for c in descriptions}
        self._changes: list[Change] = []
        self._open = ExitStack()
        self._stop = round(system.simulation.stop_time * NS_PER_SECOND)

    def __enter__(self) -> Master:
        with setting_up(), ExitStack() as stack:
            self._loaded = binaries(self._descriptions, stack)
            self.network = self._initialised(self._loaded, stack)
            self._prepare(stack)
            self._open = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        with same_folder():
            self._open.close()

    def _initialised(
        self, loaded: Mapping[str, Binary], stack: ExitStack, suffix: str = ""
    ) -> Network:
        """New instances of all components, connected, at the start time; `stack` closes them."""
        simulation = self._system.simulation
        instances: dict[str, Instance] = {}
        for component in self._system.components:
            name, description = component.name, self._descriptions[component.name]
            listener = None if suffix else self._journal.listener(name)
            instance = Instance(name, description, loaded[name], listener, suffix=suffix)
            stack.enter_context(instance).setup(
                start=simulation.start_time,
                stop=simulation.stop_time,
                tolerance=simulation.tolerance,
            )
            instance.set_values(start_values(component, description))
            instances[name] = instance
        known = (self._wiring, self._structure, self._rates)
        network = Network(
            instances,
            *known,
            time=simulation.start_time,
            recorded=self._recorded,
            watched=self._watched,
        )
        with quiet():
            network.initialise()
        return network

    def _prepare(self, stack: ExitStack) -> None:
        simulation = self._system.simulation
        self._control, self._algorithm = None, self._make(self.network)
        if simulation.coupling_tolerance is not None:
            self._control = self._step_control(cast("ErrorEstimating", self._algorithm))
        if isinstance(self._algorithm, Undoing) and self._shortens:
            for instance in self.network.instances.values():
                instance.stop_at_events()
        self._energy = EnergyBalance(self.network, self._wiring.bonds, self._algorithm.followed)
        self._witness: StepDoublingEstimator | ShadowRun | None = None
        self._unwatched = ""
        self._second_look = SecondLook(self.network)
        if self._certify and self.network.links:
            self._watch(stack)

    def _make(self, network: Network) -> Algorithm:
        """The algorithm of the system, with an estimate of its error if the steps are adaptive."""
        simulation = self._system.simulation
        if simulation.coupling_tolerance is None:
            return made(simulation.algorithm, network)
        self._refuse_rigid()
        return error_estimating(simulation.algorithm, network)

    def _rigid(self) -> list[str]:
        """The components that cannot go back."""
        return [name for name, d in self._descriptions.items() if not d.saves_state]

    @property
    def _shortens(self) -> bool:
        """Whether all components can go back, and make a shorter step then."""
        return not self._rigid() and all(rate.shortens for rate in self._rates.values())

    @property
    def _coarse(self) -> str:
        """Why there are no steps of a small part of the length; empty if there are."""
        inside = ((n, d.internal_step) for n, d in self._descriptions.items() if d.internal_step)
        own = [f"{name} goes by steps of {step:g} s inside" for name, step in inside]
        return "; ".join([f"{n} {r}" for n, r in self._rates.items() if not r.shortens] or own)

    def _lengths(self) -> list[float] | str:
        """Lengths of steps, over the run's, that can tell its error; or why there are none."""
        rates = self._rates.items()
        odd = [f"{n} {r}" for n, r in rates if r.is_sampled and r.every % 2]
        whole = [f"{n} {r}" for n, r in rates if not r.shortens]
        if self._rigid() and round(self._system.simulation.step_size * NS_PER_SECOND) % 2:
            whole.append("FMUs that cannot go back, and steps of an odd number of nanoseconds")
        if odd and whole:
            return (
                f"steps of twice the length do not meet all points of a component ({odd[0]}), and "
                f"there are none of half the length ({whole[0]})"
            )
        return [length for length, no in ((TWICE, odd), (HALF, whole)) if not no]

    def _watch(self, stack: ExitStack) -> None:
        lengths = self._lengths()
        if isinstance(lengths, str):
            self._unwatched = lengths
            return
        places = [self.network.index(port) for _, port in self.network.monitored_outputs]
        sources = np.array(places, dtype=np.intp)
        rigid = self._rigid()
        if not rigid:
            self._witness = StepDoublingEstimator(
                self.network,
                self._make,
                sources,
                lengths,
                order=self.order,
                spans=Spans(self.network),
                coarse=self._coarse,
            )
            return
        try:
            loaded = binaries(self._descriptions, stack, self._loaded)
            other = self._initialised(loaded, stack, SECOND_SET)
        except RunError as error:
            self._unwatched = (
                f"{' and '.join(rigid)} cannot go back (canGetAndSetFMUstate), and a second set of "
                f"FMUs fails ({error.message})"
            )
            return
        settings = self._system.simulation
        single = settings.stop_time - settings.start_time <= settings.step_size
        length = lengths[-1] if self._changeable or single else lengths[0]
        self._witness = ShadowRun(
            self.network,
            other,
            self._make,
            settings,
            sources,
            length=length,
            spans=Spans(self.network),
        )

    def certificate(self) -> CouplingErrorReport | str:
        """The coupling errors of the run that has ended, or why they are not known."""
        witness, network = self._witness, self.network
        if not network.links and not network.discrete:
            return CouplingErrorReport(())
        if not network.links:
            return "no Real is exchanged"
        if witness is None:
            return self._unwatched
        with same_folder(), not_lost():
            witness.finish()
        if witness.failure:
            return witness.failure
        if isinstance(witness, ShadowRun) and self._time_loop.switches.count:
            witness.switched = True  # the two sets switch at different times
        return certificate(
            network,
            self._system.connections,
            errors=witness.errors(),
            halved=witness.errors(halved=True),
            ranges=witness.ranges(),
            coverage=witness.coverage(),
        )

    def _stated(self) -> float | None:
        """The largest coupling error up to the present point, over the range, if it is known."""
        found = self.certificate()
        return (
            found.errors[0].error
            if isinstance(found, CouplingErrorReport) and found.errors
            else None
        )

    def _step_control(self, algorithm: ErrorEstimating) -> StepControl:
        simulation = self._system.simulation
        tolerance = simulation.coupling_tolerance
        assert tolerance is not None
        largest = round(simulation.step_size * NS_PER_SECOND)
        return StepControl(self.network, tolerance, largest, algorithm.estimate_order)

    def _refuse_rigid(self) -> None:
        rigid = self._rigid()
        if rigid:
            raise RunError(
                f"coupling_tolerance needs FMUs that can go back (canGetAndSetFMUstate), which "
                f"{' and '.join(rigid)} cannot",
                "leave coupling_tolerance out, and halve step_size to see the error",
            )

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
        """Whether the stop time is reached, or an FMU has asked for the end."""
        return self._time_loop.now >= self._stop or self._time_loop.over

    @property
    def ended(self) -> str:
        """Which FMUs asked for the end of the simulation, and when; empty if none did."""
        return ended(self.network.instances.values())

    @property
    def order(self) -> int:
        """The power of the step with which the coupling error falls, at least."""
        return self._algorithm.order

    @property
    def notes(self) -> tuple[str, ...]:
        """Components' own steps, what the algorithm does without, and events; one line each."""
        own = [f"{name} {rate}" for name, rate in self._rates.items()]
        seen = [*event_notes(self.network.instances.values())]
        seen += self._time_loop.switches.notes
        if rough := self.network.roughness:
            seen.append(
                f"inputs are solved for to {rough:.1e} of their size only: what FMUs answer to "
                "nearly the same inputs jumps by as much"
            )
        return (*own, *self._algorithm.notes, *seen, *([self.ended] if self.ended else []))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is wrong with the course up to the present point, by all appearances."""
        grown = self._stability.warning()
        at_once = [] if self.steps else ended_at_once(self.network.instances.values())
        stop = self._system.simulation.stop_time
        if self.steps and self.ended and round((stop - self.network.time) * NS_PER_SECOND) > 0:
            at_once = [f"the run ended before its stop time of {stop:.9g} s: {self.ended}"]
        certificate = self.certificate() if self._certify else ""
        if isinstance(certificate, CouplingErrorReport):
            useless = certificate.warning(advice=not grown)
        else:
            useless = ""
        return (*at_once, *self._second_look.notes, *filter(None, (grown, useless)))

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
        progress: Progress | None = None,
    ) -> None:
        """Step to the stop time; KeyboardInterrupt and Terminated stop at a communication point."""
        self.begin(results, singly=bool(observers))
        tell = _ticker(progress)
        self._observe(observers)
        with stepping(self._time_loop.halt, self._where) as check, self._pausing(check):
            while not self.done:
                self._advance()
                self._observe(observers)
                tell(self._time_loop.now / NS_PER_SECOND)
                check()

    def _where(self) -> str:
        """Where the run is, for a message."""
        return f" (after t = {self._time_loop.time:.9g} s)"

    @contextmanager
    def _pausing(self, check: Callable[[], None]) -> Iterator[None]:
        """Within this, `check` ends steps early that are none of the run."""
        self.network.pause = check
        try:
            yield
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
            self._system.simulation,
            results=results,
            witness=self._witness,
            control=self._control,
            returns=self._shortens,
            singly=singly,
            most_time=PROGRESS_INTERVAL,
            hopeless=lambda: self._stability.is_lost(),
        )
        self._stability = Stability(self.network, self._system.simulation, self._stated)
        self._journal.clock = lambda: self._time_loop.time
        if results is not None:
            results.record(self.network.time)

    def _advance(self) -> None:
        """Make as many steps as can be made at once, and look at what has come of them."""
        try:
            self._time_loop.advance(self._second_look.room(self.steps) or ENERGY_BLOCK)
        except RunError as failure:
            error = self._at_every_length(failure)
            told = self._stability.explained(error, self._results)
            if told is failure:
                raise
            raise told from failure
        finally:
            self._journal.check()
        self._stability.look(self.steps)
        if self._second_look.wanted:
            self._second_look.look(self.steps, last=self.done)

    def _at_every_length(self, error: RunError) -> RunError:
        """`error`, or if an FMU discards steps of all lengths that were tried, what says so."""
        simulation = self._system.simulation
        if not isinstance(error, DiscardedError) or isinstance(error, EventWithinError):
            return error
        course, sizes = self._time_loop, f"{simulation.step_size:g} s down to {error.size:.3g} s"
        if error.size <= 2 * SMALLEST * simulation.step_size:
            tried = f"every step from there, of {sizes}"
        elif course.discarded >= MOST_DISCARDED:
            tried = f"{course.discarded} steps since t = {course.since:.9g} s, of {sizes}"
        else:
            return error
        first = "the FMU tells why: see to that first"
        return RunError(
            f"{error.message}; {error.component} has discarded {tried}",
            f"{first}; "
            * error.remedy.startswith(first)
            + f"no step_size helps: look at what {error.component} cannot compute there, and at "
            "its inputs in the results",
        )

    def step(self) -> None:
        """Make one step; KeyboardInterrupt and Terminated come after it."""
        with stepping(self._time_loop.halt, self._where) as check, self._pausing(check):
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
        if self._witness:
            self._witness.changed(self._changes)
        self._changes = []

    @not_lost()
    def save(self) -> State:
        """The present state of everything; RunError naming FMUs that cannot save theirs."""
        rigid = self._rigid()
        if rigid:
            raise RunError(
                f"the state cannot be saved: {' and '.join(rigid)} cannot go back "
                "(canGetAndSetFMUstate)",
                "use FMUs that can, or run again from the start",
            )
        point = self.network.keep()
        row = self._results.mark() if self._results else None
        seen = self._witness.seen() if isinstance(self._witness, StepDoublingEstimator) else None
        return State(
            self,
            point,
            self._algorithm.snapshot(),
            self._control.snapshot() if self._control else None,
            self._energy.snapshot(),
            self._time_loop.snapshot(),
            self._second_look.snapshot(),
            row,
            seen,
        )

    @not_lost()
    def restore(self, state: State) -> None:
        """Return to a state of this run; RunError if there is no way back to it."""
        if state.master is not self:
            raise RunError("that state is of another run", "restore it where it was saved")
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
        if isinstance(self._witness, StepDoublingEstimator) and state.seen:
            self._witness.back(state.seen)
        self._changes = []

    def _observe(self, observers: Sequence[Observer]) -> None:
        for observer in observers:
            observer(self.network.time, self.network)


def _ticker(progress: Progress | None) -> Callable[[float], None]:
    """A callable of the simulated time that calls `progress` ten times a second."""
    if progress is None:
        return lambda _: None
    last = clock.perf_counter()

    def tick(time: float) -> None:
        nonlocal last
        wall = clock.perf_counter()
        if wall - last >= PROGRESS_INTERVAL:
            last = wall
            progress(time)

    return tick
