"""One instance of an FMU under test: every call is journaled, and statuses are left to be judged.

Nothing stands between the checks and the library's functions, so that calls can be made that no
importer would make. Value references are the keys of `elements`. Where only some elements of an
array are set, the others get what they were last set to, or their start values: FMI 3.0 sets whole
arrays only.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.calls.functions import (
    FATAL,
    OK,
    REALS,
    WARNING,
    Arrays,
    Functions,
    Status,
)
from m4e_fmi.fmu.importer.calls.functions_2 import Functions2
from m4e_fmi.fmu.importer.calls.functions_3 import Functions3
from m4e_fmi.fmu.importer.messages import NO_STATUS, PENDING, STATUS, Messages

if TYPE_CHECKING:
    from m4e_fmi.fmu.validation.library import Library

INSTANTIATE = "instantiation"
TOLERANCE = 1e-8
"""Relative tolerance that the FMU is asked for."""
MOST_ITERATIONS = 100
"""Event iterations at one time."""

_GUARD = np.frombuffer(b"\x5a\xa5guard\x7f" * 4, dtype=np.float64)
"""Stands behind every array the FMU writes into."""


_Fill = Callable[[np.ndarray], Status]
"""Writes all elements of an array (n,), and tells the status."""


class RefusedError(Exception):
    """A call that the standard allows was answered with `status`."""

    def __init__(self, call: str, status: Status, words: Sequence[str]) -> None:
        self.call, self.status, self.words = call, status, tuple(words)
        super().__init__(f"{call} answered {STATUS.get(status, status)}")


class FatalError(RefusedError):
    """A call was answered with fmi2Fatal: this instance must not be called any more."""


class Probe:
    """One instance, in co-simulation without event mode unless `events`.

    Calls return their status; those in `must` raise RefusedError above Warning. Functions are named
    as in FMI 2.0, without prefix. `component` is None if there is no instance.
    """

    def __init__(
        self,
        library: Library,
        *,
        exchange: bool,
        name: str,
        guid: str | None = None,
        events: bool = False,
    ) -> None:
        self.library = library
        self.exchange = exchange
        self.time = 0.0
        self._dll = library.functions(exchange=exchange)
        self._told: list[tuple[Status, str]] = []
        self._messages = Messages()
        self._held: dict[int, np.ndarray] = {}
        self._function = self._last_call = ""
        subject = library.subject
        library.journal.write(f"instantiation({name[:40]!r}, guid={guid!r:.60})")
        token = subject.raw.guid if guid is None else guid
        self.functions: Functions
        if subject.fmi_3:
            self.functions = calls = Functions3(self._dll, self.call)
            folder = subject.folder / "resources"
            resources = f"{folder}/".encode() if folder.is_dir() else None
            self.component = calls.instantiate(
                name, token, resources, self._messages, exchange=exchange, event_mode=events
            )
        else:
            self.functions = calls = Functions2(self._dll, self.call)
            folder = subject.folder
            self.component = calls.instantiate(
                name, token, folder, self._messages, exchange=exchange
            )

    # ---- calls ----

    def call(self, function: str, *arguments: object, note: str = "") -> Status:
        """Status of `function` of this instance. FatalError after fmi2Fatal."""
        self._function = self.functions.name(function)
        self._last_call = f"{self._function}({note})"
        self.library.journal.write(self._last_call)
        status = getattr(self._dll, self._function)(self.component, *arguments)
        if not OK <= status <= PENDING:
            status = NO_STATUS
        if status in (FATAL, NO_STATUS):
            self.component = None
            raise FatalError(self._last_call, status, self.words())
        return status

    def must(self, function: str, *arguments: object, note: str = "") -> None:
        """Call a function that is allowed: RefusedError if it is not answered OK or Warning."""
        self.require(self.call(function, *arguments, note=note))

    def require(self, status: Status, deed: str = "") -> None:
        """RefusedError about an allowed `deed`, the last call, if its status is above Warning."""
        if status > WARNING:
            raise RefusedError(deed or self._last_call, status, self.words())

    def words(self) -> tuple[str, ...]:
        """The FMU's messages since the last time, troubles only if there are any."""
        self.listen()
        told, self._told = self._told, []
        trouble = [text for status, text in told if status != OK]
        return tuple(text[:300] for text in (trouble or [text for _, text in told])[-3:])

    def listen(self) -> Status:
        """The worst status among the messages not yet asked for with `words`."""
        self._told += self._messages.take()
        return max((status for status, _ in self._told), default=OK)

    # ---- the life of an instance ----

    def begin(
        self,
        start: Mapping[int, float] | None = None,
        *,
        stop: float | None = None,
        initial_inputs: np.ndarray | None = None,
    ) -> Probe:
        """This instance at its first step or, in model exchange, in continuous-time mode.

        `start` are values of Reals by value reference; `initial_inputs` (n_inputs,), in SI, are
        set in initialization mode.
        """
        self.setup(stop=stop)
        if start:
            self.require(self.set(list(start), np.array(list(start.values()))), "setting values")
        self.enter_initialization()
        if initial_inputs is not None:
            references = [v.valueReference for v in self.library.subject.inputs]
            self.require(self.set(references, initial_inputs), "setting inputs")
        self.leave_initialization()
        if self.exchange:
            self.settle()
            self.must("EnterContinuousTimeMode")
        return self

    def setup(self, *, stop: float | None = None) -> None:
        """Tell the experiment: the FMU's start time, and a stop time [s] if there is one."""
        self.time = start = self.library.subject.start_time
        status = self.functions.setup(start=start, stop=stop, tolerance=TOLERANCE)
        self.require(status)

    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        self.require(self.functions.enter_initialization())

    def leave_initialization(self) -> None:
        """Exit initialization mode."""
        self.must("ExitInitializationMode")

    def terminate(self) -> None:
        """Terminate the simulation."""
        self.must("Terminate")

    def settle(self) -> None:
        """Event iteration until nothing changes any more."""
        for _ in range(MOST_ITERATIONS):
            status, again = self.functions.needs_new_discrete_states()
            self.require(status)
            if not again:
                return
        deed = f"{self._function}, {MOST_ITERATIONS} times,"
        raise RefusedError(deed, WARNING, self.words())

    def step(self, size: float) -> Status:
        """One communication step of `size` [s]."""
        status = self.functions.do_step(self.time, size, 0)
        if status <= WARNING:
            self.time += size
        return status

    def advance(self, size: float) -> None:
        """One communication step of `size` [s]; RefusedError if it is not made."""
        self.require(self.step(size))

    def last_successful_time(self) -> tuple[Status, float]:
        """Time [s] up to which the step could be made that has just been discarded."""
        return self.functions.last_successful_time()

    def reset(self) -> None:
        """Bring the instance back to where it was when it was made."""
        self.must("Reset")
        self._held.clear()

    def free(self) -> None:
        """Free the instance, if there is one."""
        if self.component:
            function = self.functions.name("FreeInstance")
            self.library.journal.write(f"{function}()")
            getattr(self._dll, function)(self.component)
            self.component = None

    # ---- values ----

    def set(self, references: Sequence[int], values: np.ndarray, note: str = "") -> Status:
        """Set Reals by value reference to `values` (n_references,), in their units."""
        if not len(references):
            return OK
        arrays = self._arrays(references)
        data = np.concatenate(
            [self._last_set(r)[:n] for r, n in zip(arrays.references, arrays.sizes, strict=True)]
        )
        data[list(arrays.places)] = values
        status = self.functions.set_reals(arrays, data, note)
        if status <= WARNING:
            parts = np.split(data, np.cumsum(arrays.sizes)[:-1])
            self._held |= dict(zip(arrays.references, parts, strict=True))
        return status

    def _last_set(self, reference: int) -> np.ndarray:
        held = self._held.get(reference)
        return self.library.subject.array_start(reference) if held is None else held

    def get(self, references: Sequence[int]) -> tuple[Status, np.ndarray]:
        """Status, and values (n_references,) of Reals by value reference, in their units."""
        if not len(references):
            return OK, np.zeros(0)
        arrays = self._arrays(references)
        return self._filled(arrays, lambda values: self.functions.get_reals(arrays, values))

    def read(self, variables: Sequence[ModelVariable]) -> np.ndarray:
        """Values (n_variables,) of Reals, in their units; RefusedError if they cannot be had."""
        status, values = self.get([v.valueReference for v in variables])
        self.require(status, "getting values")
        return values

    def put(self, variables: Sequence[ModelVariable], values: np.ndarray) -> None:
        """Set Reals to `values` (n_variables,), in their units; RefusedError if not allowed."""
        status = self.set([v.valueReference for v in variables], values)
        self.require(status, "setting values")

    def _arrays(self, references: Sequence[int]) -> Arrays:
        return self.functions.arrays(references, self.library.subject.array_sizes)

    def _filled(self, arrays: Arrays, fill: _Fill) -> tuple[Status, np.ndarray]:
        """Status of `fill` for all elements, and the values of the wanted ones."""
        status, found = self._guarded(arrays.count, fill)
        return status, found[list(arrays.places)]

    def _guarded(self, count: int, fill: _Fill) -> tuple[Status, np.ndarray]:
        """Status of `fill`, which writes into an array with a guard behind it; the array."""
        room = np.concatenate([np.full(count, np.nan), _GUARD])
        status = fill(room[:count])
        if room[count:].tobytes() != _GUARD.tobytes():
            self.library.overruns.append(self._function)
        return status, room[:count]

    # ---- model exchange ----

    def state_vector(self) -> np.ndarray:
        """Continuous states (n_states,), in their units."""
        return self._vector("GetContinuousStates")

    def rate_vector(self) -> np.ndarray:
        """Time derivatives (n_states,) of the continuous states, in their units per second."""
        return self._vector("GetDerivatives")

    def nominal_vector(self) -> np.ndarray:
        """Nominal values (n_states,) of the continuous states, in their units."""
        return self._vector("GetNominalsOfContinuousStates")

    def _vector(self, function: str) -> np.ndarray:
        count = len(self.library.subject.states)

        def fill(values: np.ndarray) -> Status:
            return self.call(function, values.ctypes.data_as(REALS), count)

        status, found = self._guarded(count, fill)
        self.require(status, self._function)
        return found

    def set_state_vector(self, x: np.ndarray) -> None:
        """Set the continuous states to `x` (n_states,), in their units."""
        data = np.ascontiguousarray(x, dtype=np.float64)
        self.must("SetContinuousStates", data.ctypes.data_as(REALS), len(data))

    def set_time(self, time: float) -> None:
        """Set the time [s]."""
        self.must("SetTime", ctypes.c_double(time), note=f"t={time:.9g}")

    def completed_integrator_step(self) -> Status:
        """Tell that a step of the solver is complete."""
        event, terminate = self.functions.BOOLEAN(), self.functions.BOOLEAN()
        function = "CompletedIntegratorStep"
        return self.call(function, 1, ctypes.byref(event), ctypes.byref(terminate))

    # ---- derivatives ----

    def directional(
        self, unknowns: Sequence[ModelVariable], knowns: Sequence[ModelVariable], seed: np.ndarray
    ) -> np.ndarray:
        """Change (n_unknowns,) of `unknowns`, in their units.

        For the change `seed` (n_knowns,) of `knowns`, in their units.
        """
        z, v = self._arrays_of(unknowns), self._arrays_of(knowns)
        data = _spread(seed, v)
        status, found = self._filled(
            z, lambda found: self.functions.directional_derivative(z, v, data, found)
        )
        self.require(status, self._function)
        return found

    def adjoint(
        self, unknowns: Sequence[ModelVariable], knowns: Sequence[ModelVariable], seed: np.ndarray
    ) -> np.ndarray:
        """Derivatives (n_knowns,), in SI, of the weighted sum of `unknowns` by each of `knowns`.

        `seed` (n_unknowns,) [1] are the weights. For FMI 3.0 only.
        """
        functions = self.functions
        assert isinstance(functions, Functions3)
        z, v = self._arrays_of(unknowns), self._arrays_of(knowns)
        data = _spread(seed, z)
        status, found = self._filled(
            v, lambda found: functions.adjoint_derivative(z, v, data, found)
        )
        self.require(status, self._function)
        return found

    def output_derivatives(self, outputs: Sequence[ModelVariable], order: int) -> np.ndarray:
        """Time derivatives (n_outputs,) of an order of outputs, in SI."""
        y = self._arrays_of(outputs)
        status, found = self._filled(
            y, lambda found: self.functions.output_derivatives(y, order, found)
        )
        self.require(status, self._function)
        return found

    def set_input_derivatives(self, inputs: Sequence[ModelVariable], rates: np.ndarray) -> None:
        """Set first time derivatives of inputs to `rates` (n_inputs,), in SI; for FMI 2.0 only."""
        assert isinstance(self.functions, Functions2)
        data = np.ascontiguousarray(rates, dtype=np.float64)
        self.require(self.functions.set_input_derivatives(self._arrays_of(inputs), data))

    def _arrays_of(self, variables: Sequence[ModelVariable]) -> Arrays:
        return self._arrays([v.valueReference for v in variables])

    # ---- state ----

    def save(self) -> ctypes.c_void_p:
        """A saved state of the instance."""
        state = ctypes.c_void_p()
        self.must("GetFMUstate", ctypes.byref(state))
        return state

    def restore(self, state: ctypes.c_void_p) -> None:
        """Bring the instance back to a saved state."""
        self.must("SetFMUstate", state)

    def free_state(self, state: ctypes.c_void_p) -> None:
        """Free a saved state."""
        self.must("FreeFMUstate", ctypes.byref(state))


def _spread(seed: np.ndarray, arrays: Arrays) -> np.ndarray:
    """The seed of all elements (n_elements,), from that of the wanted ones."""
    data = np.zeros(arrays.count)
    np.add.at(data, list(arrays.places), seed)
    return data
