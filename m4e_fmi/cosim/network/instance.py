"""One instance of a co-simulation FMU, called directly in its shared library.

The calls of the time loop go to the library's functions with addresses prepared once. Functions
have the names of FMI 2.0, whatever the version of the FMU is.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import NoReturn

import numpy as np

from m4e_fmi.cosim.network.failures import (
    ANSWERS,
    KEEP,
    DiscardedError,
    EndWithinError,
    EventWithinError,
    Explanation,
    WarnedSteps,
    failed_step,
    value_out_of_range,
    worker_lost,
)
from m4e_fmi.cosim.network.loading import Binary
from m4e_fmi.cosim.wiring.links import InputScales
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.calls import (
    DISCARD,
    DOES_NOT_FIT,
    EARLY,
    FATAL,
    NEAR,
    STANDARDS,
    WARNING,
    Access,
    Fmi2,
    RawCall,
    Standard,
    Status,
    Taken,
    Texts,
    Value,
)
from m4e_fmi.fmu.importer.calls.access import RawComponent
from m4e_fmi.fmu.importer.messages import Listener, Messages
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import LATE, LOST
from m4e_fmi.signals import not_lost


class Instance:
    """An instance of a loaded FMU for the component `name`; `close` it, or use it in a with block.

    The FMU hears the name with a `suffix`, of instances beside that of the run; nobody else does.
    `scales` are factors and offsets of the links to its inputs, which give factor·v + offset for a
    value v of their source. A `listener` hears what the FMU logs with another status than OK;
    `warned` counts the steps that it has answered with Warning.

    Every method raises RunError with component, time, the FMU's own words and a remedy when the
    FMU answers with more than a warning. After Fatal the FMU is never called again.
    """

    def __init__(
        self,
        name: str,
        description: Description,
        binary: Binary,
        listener: Listener | None = None,
        *,
        suffix: str = "",
    ) -> None:
        self.name = name
        self.description = description
        self._told_name = name + suffix
        self._messages = Messages(listener, self._told_name)
        self.warned = WarnedSteps()
        self.time = self._start = 0.0
        self._broken = self._initialised = False
        self.scales = InputScales()
        self._states: dict[int, ctypes.c_void_p] = {}
        self._binary = binary
        kind = STANDARDS[description.version]
        self._fmu = kind(binary.loaded, description.variables, self.fail)
        self._why = Explanation(description, self._fmu, self._messages, self._told_name)
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            self.close()
        except RunError:
            if kind is None:  # else the error that ended the run is raised
                raise

    @not_lost()
    def _open(self) -> None:
        self._binary.in_use += 1
        if worker := self._binary.worker:
            worker.next_instance()
        try:
            events = self.description.has_events
            self._fmu.instantiate(self._told_name, self._messages, events=events)
        except Exception as error:
            self._fmu.component = None
            self._check_worker("fmi2Instantiate")
            message = f"{self._origin}: cannot be instantiated{self._why.words()}"
            remedy = f"check the FMU alone: `fmpy simulate` on the file{self._surroundings}"
            raise RunError(message, remedy) from error

    @property
    def _origin(self) -> str:
        return f"{self.name} ({self.description.path.name})"

    @contextmanager
    def rehearsing(self) -> Generator[None, None, None]:
        """Within this, what the FMU says is not heard: its steps are no steps of the run."""
        kept = bytes(self.warned)
        self._messages.muted = True
        try:
            yield
        finally:
            self._messages.muted = False
            ctypes.memmove(ctypes.addressof(self.warned), kept, len(kept))

    @not_lost()
    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        """Tell the experiment: times [s], relative tolerance (None: the FMU's own)."""
        self.time = self._start = start
        self._usable.setup(start=start, stop=stop, tolerance=tolerance)

    @not_lost()
    def set_values(self, values: Mapping[str, Value]) -> None:
        """Set variables of any type by name, those that FMI allows to be set at this time."""
        if values:
            self._usable.set_values(values)

    @not_lost()
    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        self._usable.enter_initialization()

    @not_lost()
    def exit_initialization(self) -> None:
        """Exit initialization mode, ready for the first step."""
        self._usable.exit_initialization()
        self._initialised = True

    def _check_usable(self) -> None:
        """RunError if the FMU has failed."""
        worker, what = self._binary.worker, "can no longer be used"
        if self._broken and worker and worker.ending:
            raise worker_lost(self._origin, what, worker, "")
        if self._broken:
            raise RunError(f"{self._origin} has failed before and {what}")

    @property
    def _usable(self) -> Standard:
        """The FMU; RunError if it has failed."""
        self._check_usable()
        return self._fmu

    @property
    def rollback(self) -> Standard:
        """The FMU's saved states; only where it declares them."""
        return self._fmu

    @property
    def events(self) -> RawComponent:
        """Events that the FMU has told of."""
        return self._fmu.events

    @property
    def has_ended(self) -> bool:
        """True if the FMU asked for the end of the simulation."""
        return math.isfinite(self._fmu.events.ended)

    def ends_at(self, time: float) -> bool:
        """True if the step to `time` [s] that the FMU has discarded is whole, and to be the last.

        The FMU makes no further step then, and nothing may be set in it.
        """
        reached = self._fmu.reached() if self._why.asks_for_end else None
        if reached is None or reached < time - NEAR:
            return False
        self._fmu.events.ended = reached
        return True

    def typed(
        self,
        names: Sequence[str],
        texts: Texts,
        *,
        taken: Sequence[Taken] = (),
        changed: np.ndarray | None = None,
    ) -> Access:
        """Access to variables that are not Real, or that take the values of such.

        `changed` (1,) [1] becomes 0 where a value that is read has changed.
        """
        return self._fmu.typed(names, texts, taken=taken, changed=changed)

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        """The C function that does what `function` of FMI 2.0 does, for Real variables `names`."""
        return self._fmu.raw(function, names)

    def step_beginner(self) -> int | None:
        """The C function that asks for a step, where the FMU is in another process; else None."""
        return self._fmu.step_beginner() if self._binary.worker else None

    def set_derivative(self, name: str, order: int, value: float) -> Status:
        """Give the Real input `name` a time derivative of an `order` for the next step.

        `value` is in the FMU's own unit per s or s².
        """
        assert isinstance(self._fmu, Fmi2)  # which alone declare that they interpolate inputs
        reference = self.description.variables[name].value_reference
        return self._fmu.set_input_derivatives([reference], order, np.array([value]))

    def slot(self, place: int = 0) -> ctypes.c_void_p:
        """Where the FMU's state is that is kept in a place."""
        if place not in self._states:
            self._states[place] = self.rollback.slot()
        return self._states[place]

    def save_state(self, place: int = 0) -> None:
        """Keep the FMU's state, instead of the one kept before in the same place."""
        self._check_usable()
        status = self.rollback.save(self.slot(place))
        if status > WARNING:
            self.fail(status, "fmi2GetFMUstate")

    def flush(self) -> Status:
        """Have the FMU take values that were set, where that waits for its next call.

        OK or WARNING, RunError if it refuses.
        """
        worker = self._binary.worker
        status = worker.flush() if worker and not self._broken else 0
        if status > WARNING:
            self.fail(status, "fmi2SetReal")
        return status

    def restore_state(self, time: float, place: int = 0) -> None:
        """Bring the FMU back to the state kept in a place at `time` [s], also after a failed step.

        It may be restored again. After Fatal there is no way back.
        """
        self._broken = self._fmu.component is None
        self._check_usable()
        status = self.rollback.restore(self.slot(place))
        if status > WARNING:
            self.fail(status, "fmi2SetFMUstate")
        self.time = time

    @not_lost()
    def directional_derivative(self, output: str, known: str) -> float:
        """∂output/∂known of two Real variables at the present instant, in their units."""
        self._check_usable()
        of = self.description.variables
        return self.rollback.directional_derivative(of[output], of[known])

    @not_lost()
    def values(self, names: Sequence[str]) -> list[Value]:
        """The present values of variables in their types; an item of an enumeration by number."""
        return self._fmu.values(names)

    def fail(self, status: Status, function: str, size: float = 0.0) -> NoReturn:
        """Raise the error of this status of `function`; `size` is that of a failed step [s]."""
        self._broken = True
        worker = self._binary.worker
        if worker and status == LATE:
            status, function = worker.late
        if worker and worker.ending:
            self._fmu.component = None
            when = failed_step(self.time, size) if function == "fmi2DoStep" else self._when
            raise worker_lost(self._origin, when, worker, self._surroundings)
        what = f"{self._fmu.name(function)} answered {ANSWERS.get(status, status)}"
        words = self._why.words(status)
        remedy = "fix the problem stated by the FMU" if words else "check its inputs and parameters"
        if function == "fmi2DoStep":
            what = f"{failed_step(self.time, size)} ({what})"
            remedy = self._why.step_remedy(status, size, first_step=self.time == self._start)
        else:
            what += f" {self._when}"
            if not self._initialised:
                remedy = f"check its parameters and start values{self._surroundings}"
        if FATAL <= status < EARLY:
            self._fmu.component = None
        message = f"{self._origin}: {what}{words}"
        if function == "fmi2DoStep" and status in (DISCARD, EARLY):
            kind = DiscardedError if status == DISCARD else EventWithinError
            reached = self._fmu.reached()
            if status == DISCARD and self._why.asks_for_end:
                kind, self._broken = EndWithinError, False
                self._fmu.events.ended = self.time if reached is None else reached
            raise kind(message, remedy, reached, self.name, size)
        raise RunError(message, remedy)

    @property
    def _surroundings(self) -> str:
        """A further remedy for an FMU that cannot begin, and may miss what others have."""
        return KEEP if self._binary.worker and not self._initialised else ""

    def _check_worker(self, function: str) -> None:
        """RunError if the FMU's worker is gone."""
        if self._binary.worker and self._binary.worker.ending:
            self.fail(LOST, function)

    @property
    def _when(self) -> str:
        return f"at t = {self.time:.9g} s" if self._initialised else "during initialisation"

    def not_finite(self, names: Sequence[str], values: np.ndarray) -> NoReturn:
        """Raise for the first of `names` whose value is not finite.

        `values` (n_names,) are in the FMU's units.
        """
        self._broken = True
        raise self._why.not_finite(self.name, self._when, names, values)

    def fail_typed(self, status: Status, access: Access, cells: np.ndarray) -> NoReturn:
        """Raise the error of this status of an access to `cells` (n_cells,), int64 codes."""
        if status < 0 and status != DOES_NOT_FIT:
            raise MemoryError
        if status != DOES_NOT_FIT:
            self.fail(status, access.function(sets=bool(access.taken)))
        raise value_out_of_range(self.description, self.name, self._when, access, cells)

    @not_lost()
    def close(self) -> None:
        """Terminate and free, if the FMU's condition allows it; a refusal becomes a message."""
        fmu, states = self._fmu, list(self._states.values())
        self._states.clear()
        if fmu.component is None:
            return
        status = fmu.terminate() if self._initialised and not self._broken else 0
        if told := ANSWERS.get(status) if status > WARNING else "":
            self._messages.add(status, f"{fmu.name('fmi2Terminate')} answered {told}")
        for state in () if self._broken else states:
            self.rollback.free_state(state)
        if status < FATAL or status == LATE:
            fmu.free()
            self._binary.in_use -= 1
        fmu.component = None
        self._check_worker("fmi2FreeInstance")
