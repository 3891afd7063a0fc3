"""The time loop over a network: integer time, observers, clean ends."""

from __future__ import annotations

import signal
import threading
import time as clock
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import cast

import numpy as np

from m4e_fmi.cosim.algorithms import ALGORITHMS, Algorithm, Returning, Undoing, returning
from m4e_fmi.cosim.certificate import Certificate, certificate
from m4e_fmi.cosim.connect import Wiring
from m4e_fmi.cosim.energy import BondEnergy, EnergyBalance
from m4e_fmi.cosim.instance import DiscardedError, Instance
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.results import ResultsWriter
from m4e_fmi.cosim.start_values import start_values
from m4e_fmi.cosim.step_control import SMALLEST, StepControl
from m4e_fmi.cosim.structure import Structure
from m4e_fmi.cosim.system import SECOND, System
from m4e_fmi.cosim.witness import Witness
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.reading import Description

Observer = Callable[[float, Network], None]
"""Called at every communication point with the time [s] and the network."""
Progress = Callable[[float], None]
"""Called now and then with the simulated time [s]."""

PROGRESS_INTERVAL = 0.1
"""Wall seconds between calls of a progress callable."""


class Master:
    """Owns the instances of a system from `with` to the end of the block."""

    def __init__(
        self,
        system: System,
        descriptions: dict[str, Description],
        wiring: Wiring,
        structure: Structure,
        *,
        certify: bool = True,
    ) -> None:
        """With `certify`, some steps are made twice, from which `certificate` follows."""
        self._system = system
        self._descriptions = descriptions
        self._wiring = wiring
        self._structure = structure
        self._certify = certify
        self._open = ExitStack()
        self.steps = 0
        self._discarded = 0

    def __enter__(self) -> Master:
        with ExitStack() as stack:
            instances = {
                name: stack.enter_context(Instance(name, description))
                for name, description in self._descriptions.items()
            }
            self._initialise(instances)
            self._open = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def _initialise(self, instances: dict[str, Instance]) -> None:
        simulation = self._system.simulation
        for component in self._system.components:
            instance = instances[component.name]
            instance.setup(
                start=simulation.start_time,
                stop=simulation.stop_time,
                tolerance=simulation.tolerance,
            )
            instance.set_start(start_values(component, instance.description))
        self.network = Network(instances, self._wiring, self._structure, time=simulation.start_time)
        self.network.initialise()
        self._control, self._algorithm = None, self._make(self.network)
        if simulation.coupling_tolerance is not None:
            self._control = self._step_control(cast("Returning", self._algorithm))
        self._energy = EnergyBalance(self.network, self._wiring.bonds)
        self._witness, self._unwatched = None, ""
        if self._certify and self.network.links:
            self._watch()

    def _make(self, network: Network) -> Algorithm:
        """The algorithm of the system, with an estimate of its error if the steps are adaptive."""
        simulation = self._system.simulation
        if simulation.coupling_tolerance is None:
            return ALGORITHMS[simulation.algorithm](network)
        self._refuse_rigid()
        return returning(simulation.algorithm, network)

    def _watch(self) -> None:
        rigid = [name for name, d in self._descriptions.items() if not d.saves_state]
        if rigid:
            self._unwatched = f"{' and '.join(rigid)} cannot go back (canGetAndSetFMUstate)"
            return
        sources = [self.network.index(link.source) for link in self.network.links]
        self._witness = Witness(self.network, self._make, np.array(sources, dtype=np.intp))

    def certificate(self) -> Certificate | str:
        """The coupling errors of the run that has ended, or why they are not known."""
        witness, network = self._witness, self.network
        if not network.links:
            return Certificate((), 1.0)
        if witness is None:
            return self._unwatched
        witness.finish()
        if witness.failure:
            return witness.failure
        errors = witness.difference() / (2.0**self.order - 1)
        connections = self._system.connections
        ranges = witness.ranges()
        return certificate(network, connections, errors=errors, ranges=ranges, order=self.order)

    def _step_control(self, algorithm: Returning) -> StepControl:
        simulation = self._system.simulation
        tolerance = simulation.coupling_tolerance
        assert tolerance is not None
        largest = round(simulation.step_size * SECOND)
        return StepControl(self.network, tolerance, largest, algorithm.estimate_order)

    def _refuse_rigid(self) -> None:
        rigid = [name for name, d in self._descriptions.items() if not d.saves_state]
        if rigid:
            raise RunError(
                f"coupling_tolerance needs FMUs that can go back (canGetAndSetFMUstate), which "
                f"{' and '.join(rigid)} cannot",
                "leave coupling_tolerance out, and halve step_size to see the error",
            )

    @property
    def rejected(self) -> int:
        """Number of steps that were taken back and made again, smaller."""
        return self._discarded + (self._control.rejected if self._control else 0)

    @property
    def order(self) -> int:
        """The power of the step with which the coupling error falls, at least."""
        return self._algorithm.order

    @property
    def notes(self) -> tuple[str, ...]:
        """What the algorithm does without because an FMU cannot, one line each."""
        return self._algorithm.notes

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
        """Step to the stop time; KeyboardInterrupt stops at the next communication point."""
        simulation = self._system.simulation
        start, stop = round(simulation.start_time * SECOND), round(simulation.stop_time * SECOND)
        every = round((simulation.output_interval or simulation.step_size) * SECOND)
        every = every if simulation.output_interval or self._control is None else 1
        network, algorithm, energy = self.network, self._algorithm, self._energy
        witness = self._witness
        tell = _ticker(progress)
        now, row = start, start
        self._observe(results, observers)
        # an overflow is found, and told with its place, where values are read from the FMUs
        with _interruption() as interrupted, np.errstate(over="ignore", invalid="ignore"):
            while now < stop:
                if witness:
                    witness.before()
                size = self._step(now, stop, row + every)
                now += size
                network.advance(now / SECOND)
                energy.add(algorithm.held, size / SECOND)
                self.steps += 1
                if witness:
                    witness.after()
                recorded = now >= row + every or now == stop
                row = now if recorded else row
                self._observe(results if recorded else None, observers)
                tell(now / SECOND)
                if interrupted():
                    raise KeyboardInterrupt

    def _step(self, now: int, stop: int, row: int) -> int:
        """Step all components from `now`, not beyond `stop`; the size of the step. All in ns.

        Adaptive steps end where the next row of the results is due, at `row`; others where they
        would if none had been shortened by an FMU.
        """
        control, algorithm = self._control, self._algorithm
        size = self._wanted(now, stop, row)
        while True:
            try:
                algorithm.step(now / SECOND, size / SECOND)
            except DiscardedError as discarded:
                size = self._shorter(now, size, discarded)
                continue
            if control is None:
                return size
            algorithm = cast("Returning", algorithm)
            if control.accepts(algorithm.change, algorithm.end, size):
                return size
            algorithm.undo()
            size = self._wanted(now, stop, row)

    def _wanted(self, now: int, stop: int, row: int) -> int:
        """The size of the step from `now` if no FMU objects."""
        simulation = self._system.simulation
        if self._control is not None:
            end = min(row, stop) if row > now + 1 else stop
            return min(self._control.size, end - now)
        regular = round(simulation.step_size * SECOND)
        done = now - round(simulation.start_time * SECOND)
        return min(regular - done % regular, stop - now)

    def _shorter(self, now: int, size: int, discarded: DiscardedError) -> int:
        """Take back the step of `size` that an FMU has discarded; the size to try next.

        That is up to where the FMU could go, or half. Raises what it is given if there is no way
        back, or the step is too short already.
        """
        smallest = max(1, round(SMALLEST * self._system.simulation.step_size * SECOND))
        stuck = not all(d.saves_state for d in self._descriptions.values())
        if stuck or size <= smallest or not isinstance(self._algorithm, Undoing):
            raise discarded
        self._algorithm.undo()
        self._discarded += 1
        reached = round((discarded.reached or 0.0) * SECOND) - now
        return reached if smallest <= reached < size else max(smallest, size // 2)

    def _observe(self, results: ResultsWriter | None, observers: Sequence[Observer]) -> None:
        network = self.network
        if results is not None:
            results.record(network.time)
        for observer in observers:
            observer(network.time, network)


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


@contextmanager
def _interruption() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed; a second time it interrupts at once, as usual.

    An exception raised inside an FMU written in Python would be fatal to it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = False
    usual = signal.getsignal(signal.SIGINT)

    def note(*_: object) -> None:
        nonlocal pressed
        pressed = True
        signal.signal(signal.SIGINT, usual)

    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, usual)
