"""The time loop over a network: integer time, observers, clean ends."""

from __future__ import annotations

import signal
import threading
import time as clock
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager

import numpy as np

from m4e_fmi.cosim.algorithms import ALGORITHMS
from m4e_fmi.cosim.algorithms.scheduled import Scheduled
from m4e_fmi.cosim.binary import binaries
from m4e_fmi.cosim.connect import Wiring
from m4e_fmi.cosim.energy import BondEnergy, EnergyBalance
from m4e_fmi.cosim.instance import Instance
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.results import ResultsWriter
from m4e_fmi.cosim.start_values import start_values
from m4e_fmi.cosim.step_control import StepControl
from m4e_fmi.cosim.stepping import Repeated, Stepwise
from m4e_fmi.cosim.structure import Structure
from m4e_fmi.cosim.system import SECOND, System
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
    ) -> None:
        self._system = system
        self._descriptions = descriptions
        self._wiring = wiring
        self._structure = structure
        self._open = ExitStack()
        self.steps = 0

    def __enter__(self) -> Master:
        with ExitStack() as stack:
            loaded = binaries(self._descriptions, stack)
            instances = {
                name: stack.enter_context(Instance(name, description, loaded[name]))
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
        self._algorithm = ALGORITHMS[simulation.algorithm](self.network)
        self._control = self._step_control()
        self._energy = EnergyBalance(self.network, self._wiring.bonds)

    def _step_control(self) -> StepControl | None:
        simulation = self._system.simulation
        tolerance = simulation.coupling_tolerance
        if tolerance is None:
            return None
        rigid = [name for name, d in self._descriptions.items() if not d.saves_state]
        if rigid:
            raise RunError(
                f"coupling_tolerance needs FMUs that can go back (canGetAndSetFMUstate), which "
                f"{' and '.join(rigid)} cannot",
                "leave coupling_tolerance out, and halve step_size to see the error",
            )
        return StepControl(self.network, tolerance, round(simulation.step_size * SECOND))

    @property
    def rejected(self) -> int:
        """Number of steps that were taken back and made again, smaller."""
        return self._control.rejected if self._control else 0

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
        """Step to the stop time; KeyboardInterrupt stops at a communication point."""
        stop = round(self._system.simulation.stop_time * SECOND)
        steps = self._stepping(results, singly=bool(observers))
        tell = _ticker(progress)
        if results is not None:
            results.record(self.network.time)
        self._observe(observers)
        # an overflow is found, and told with its place, where values are read from the FMUs
        with _interruption() as interrupted, np.errstate(over="ignore", invalid="ignore"):
            while steps.now < stop:
                try:
                    steps.advance()
                finally:
                    self.steps = steps.steps
                self._observe(observers)
                tell(steps.now / SECOND)
                if interrupted():
                    raise KeyboardInterrupt

    def _stepping(self, results: ResultsWriter | None, *, singly: bool) -> Stepwise | Repeated:
        algorithm, rest = self._algorithm, (self._energy, self._system.simulation, results)
        if not isinstance(algorithm, Scheduled):
            return Stepwise(self.network, algorithm, *rest, self._control)
        return Repeated(self.network, algorithm, *rest, singly=singly, most_time=PROGRESS_INTERVAL)

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
