"""Calling an FMI 2.0 FMU by the book and against it: every call is journaled and none is checked.

FMPy loads the library; nothing stands between the checks and its functions, so that calls can be
made that no importer would make.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from fmpy import fmi2

from m4e_fmi.fmu.importer.messages import STATUS, Messages

if TYPE_CHECKING:
    from m4e_fmi.fmu.validation.library import Library

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
LAST_SUCCESSFUL_TIME = 2
INSTANTIATE = "instantiation"
TOLERANCE = 1e-8
"""Relative tolerance that the FMU is asked for."""

_GUARD = np.frombuffer(b"\x5a\xa5guard\x7f" * 4, dtype=np.float64)
"""Stands behind every array the FMU writes into."""
REALS = ctypes.POINTER(ctypes.c_double)


class RefusedError(Exception):
    """A call that the standard allows was answered with `status`."""

    def __init__(self, call: str, status: int, words: Sequence[str]) -> None:
        self.call, self.status, self.words = call, status, tuple(words)
        super().__init__(f"{call} answered {STATUS.get(status, status)}")


class FatalError(RefusedError):
    """A call was answered with fmi2Fatal: this instance must not be called any more."""


class Probe:
    """One instance. Calls return their status; those in `must` raise RefusedError above Warning.

    `heard` holds the statuses of the messages that the FMU logged since it was last cleared.
    Functions are named as in FMI 2.0, without prefix.
    """

    _PREFIX = "fmi2"
    BYTE: ClassVar[Any] = ctypes.c_char
    """Of a serialised state."""
    _BOOLEAN: ClassVar[Any] = fmi2.fmi2Boolean
    _RENAMED: ClassVar[dict[str, str]] = {}

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
        self._events = events
        self._dll = library.functions(exchange=exchange)
        self._told: list[tuple[int, str]] = []
        library.journal.write(f"instantiation({name[:40]!r}, guid={guid!r:.60})")
        self.component = self._instantiate(name, library.subject.raw.guid if guid is None else guid)

    def _instantiate(self, name: str, guid: str) -> Any:
        self._messages: Any = Messages()
        return self._dll.fmi2Instantiate(
            name.encode("utf-8"),
            fmi2.fmi2ModelExchange if self.exchange else fmi2.fmi2CoSimulation,
            guid.encode("utf-8"),
            (self.library.subject.folder / "resources").as_uri().encode("utf-8"),
            ctypes.byref(self._messages.callbacks),
            fmi2.fmi2False,
            fmi2.fmi2True,
        )

    # ---- calls ----

    def call(self, function: str, *arguments: Any, note: str = "") -> int:
        """Call `function` with this instance; its status. FatalError after fmi2Fatal."""
        function = self._PREFIX + self._RENAMED.get(function, function)
        self.library.journal.write(f"{function}({note})")
        status = getattr(self._dll, function)(self.component, *arguments)
        if status == FATAL:
            self.component = None
            raise FatalError(f"{function}({note})", FATAL, self.words())
        return status

    def must(self, function: str, *arguments: Any, note: str = "") -> None:
        """The same for a call that is allowed: RefusedError if it is not answered OK or Warning."""
        status = self.call(function, *arguments, note=note)
        self.require(status, f"{self._PREFIX}{function}({note})")

    def require(self, status: int, call: str) -> None:
        if status > WARNING:
            raise RefusedError(call, status, self.words())

    def words(self) -> tuple[str, ...]:
        """What the FMU has logged since the last time, troubles only if there are any."""
        self.listen()
        told, self._told = self._told, []
        trouble = [text for status, text in told if status != OK]
        return tuple(text[:300] for text in (trouble or [text for _, text in told])[-3:])

    def listen(self) -> int:
        """The worst status among the messages not yet asked for with `words`."""
        self._told += self._messages.take()
        return max((status for status, _ in self._told), default=OK)

    # ---- the book ----

    def begin(
        self,
        start: dict[int, float] | None = None,
        *,
        stop: float | None = None,
        initial_inputs: np.ndarray | None = None,
    ) -> Probe:
        """Set Reals by value reference, and go through initialization, to the first step or,
        in model exchange, to continuous-time mode."""
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
        self.time = self.library.subject.start_time
        self.must(
            "SetupExperiment",
            fmi2.fmi2True,
            TOLERANCE,
            self.time,
            int(stop is not None),
            stop or 0.0,
            note=f"start={self.time:g}, stop={stop}",
        )

    def enter_initialization(self) -> None:
        self.must("EnterInitializationMode")

    def leave_initialization(self) -> None:
        self.must("ExitInitializationMode")

    def terminate(self) -> None:
        self.must("Terminate")

    def settle(self) -> None:
        """Event iteration until nothing changes any more."""
        for _ in range(100):
            info = fmi2.fmi2EventInfo()
            self.must("NewDiscreteStates", ctypes.byref(info))
            if not info.newDiscreteStatesNeeded:
                return
        raise RefusedError("fmi2NewDiscreteStates, 100 times,", WARNING, self.words())

    def step(self, size: float) -> int:
        """One communication step of `size` [s]."""
        note = f"t={self.time:.9g}, h={size:.9g}"
        status = self.call("DoStep", self.time, size, fmi2.fmi2False, note=note)
        if status <= WARNING:
            self.time += size
        return status

    def advance(self, size: float) -> None:
        self.require(self.step(size), f"{self._PREFIX}DoStep(t={self.time:.9g}, h={size:.9g})")

    def reset(self) -> None:
        self.must("Reset")

    def free(self) -> None:
        if self.component:
            self.library.journal.write(f"{self._PREFIX}FreeInstance()")
            getattr(self._dll, f"{self._PREFIX}FreeInstance")(self.component)
            self.component = None

    # ---- values ----

    def set(self, references: Sequence[int], values: np.ndarray, note: str = "") -> int:
        if not len(references):
            return OK
        data = np.ascontiguousarray(values, dtype=np.float64)
        given = (ctypes.c_uint * len(references))(*references)
        pointer = data.ctypes.data_as(REALS)
        return self.call("SetReal", given, len(references), pointer, note=note)

    def get(self, references: Sequence[int]) -> tuple[int, np.ndarray]:
        if not len(references):
            return OK, np.zeros(0)
        given = (ctypes.c_uint * len(references))(*references)
        return self._filled("GetReal", len(references), given, len(references))

    def read(self, variables: Sequence[Any]) -> np.ndarray:
        """The values of Real variables; RefusedError if they cannot be had."""
        status, values = self.get([v.valueReference for v in variables])
        self.require(status, "getting values")
        return values

    def put(self, variables: Sequence[Any], values: np.ndarray) -> None:
        """Set Real variables; RefusedError if that is not allowed."""
        status = self.set([v.valueReference for v in variables], values)
        self.require(status, "setting values")

    def _filled(self, function: str, count: int, *before: Any) -> tuple[int, np.ndarray]:
        """Status and values of a function whose last argument is an array it writes into."""
        room = np.concatenate([np.full(count, np.nan), _GUARD])
        status = self.call(
            function,
            *before,
            room.ctypes.data_as(REALS),
            *self.counted(count),
            note=f"{count} values",
        )
        if room[count:].tobytes() != _GUARD.tobytes():
            self.library.overruns.append(function)
        return status, room[:count]

    def counted(self, count: int) -> tuple[int, ...]:  # noqa: ARG002
        """What follows an array of `count` values: in FMI 3.0 their number."""
        return ()

    # ---- model exchange ----

    def state_vector(self) -> np.ndarray:
        return self._vector("GetContinuousStates")

    def rate_vector(self) -> np.ndarray:
        return self._vector("GetDerivatives")

    def nominal_vector(self) -> np.ndarray:
        return self._vector("GetNominalsOfContinuousStates")

    def _vector(self, function: str) -> np.ndarray:
        count = len(self.library.subject.states)
        room = np.concatenate([np.full(count, np.nan), _GUARD])
        status = self.call(function, room.ctypes.data_as(REALS), count)
        if room[count:].tobytes() != _GUARD.tobytes():
            self.library.overruns.append(function)
        self.require(status, f"{self._PREFIX}{function}")
        return room[:count]

    def set_state_vector(self, x: np.ndarray) -> None:
        data = np.ascontiguousarray(x, dtype=np.float64)
        self.must("SetContinuousStates", data.ctypes.data_as(REALS), len(data))

    def set_time(self, time: float) -> None:
        self.must("SetTime", ctypes.c_double(time), note=f"t={time:.9g}")

    def completed_integrator_step(self) -> int:
        event, terminate = self._BOOLEAN(), self._BOOLEAN()
        function = "CompletedIntegratorStep"
        return self.call(function, 1, ctypes.byref(event), ctypes.byref(terminate))

    # ---- derivatives ----

    def directional(
        self, unknowns: Sequence[Any], knowns: Sequence[Any], seed: np.ndarray
    ) -> np.ndarray:
        """Directional derivative of `unknowns` for the change `seed` of `knowns`."""
        z = (ctypes.c_uint * len(unknowns))(*(v.valueReference for v in unknowns))
        v = (ctypes.c_uint * len(knowns))(*(v.valueReference for v in knowns))
        data = np.ascontiguousarray(seed, dtype=np.float64)
        arguments = (z, len(unknowns), v, len(knowns), data.ctypes.data_as(REALS))
        function = "GetDirectionalDerivative"
        status, found = self._filled(function, len(unknowns), *arguments)
        self.require(status, f"{self._PREFIX}{function}")
        return found

    def adjoint(
        self, unknowns: Sequence[Any], knowns: Sequence[Any], seed: np.ndarray
    ) -> np.ndarray:
        """Derivative of the sum of `unknowns`, weighted by `seed`, by each of `knowns`; FMI 3.0."""
        raise NotImplementedError

    def output_derivatives(self, outputs: Sequence[Any], order: int) -> np.ndarray:
        count = len(outputs)
        y = (ctypes.c_uint * count)(*(v.valueReference for v in outputs))
        orders = (ctypes.c_int * count)(*[order] * count)
        function = "GetRealOutputDerivatives"
        status, found = self._filled(function, count, y, count, orders)
        self.require(status, f"{self._PREFIX}{function}")
        return found

    def set_input_derivatives(self, inputs: Sequence[Any], rates: np.ndarray) -> None:
        count = len(inputs)
        u = (ctypes.c_uint * count)(*(v.valueReference for v in inputs))
        orders = (ctypes.c_int * count)(*[1] * count)
        data = np.ascontiguousarray(rates, dtype=np.float64)
        pointer = data.ctypes.data_as(REALS)
        self.must("SetRealInputDerivatives", u, count, orders, pointer)

    # ---- state ----

    def save(self) -> ctypes.c_void_p:
        state = ctypes.c_void_p()
        self.must("GetFMUstate", ctypes.byref(state))
        return state

    def restore(self, state: ctypes.c_void_p) -> None:
        self.must("SetFMUstate", state)

    def free_state(self, state: ctypes.c_void_p) -> None:
        self.must("FreeFMUstate", ctypes.byref(state))

    def last_successful_time(self) -> tuple[int, float]:
        value = ctypes.c_double(np.nan)
        status = self.call("GetRealStatus", LAST_SUCCESSFUL_TIME, ctypes.byref(value))
        return status, value.value
