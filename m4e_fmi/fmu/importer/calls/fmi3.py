"""FMI 3.0 for co-simulation: arrays as their elements, event mode where the FMU has it.

Events within a step end it early: the whole system's, or, where that cannot be, the FMU goes on
after its event. `step` does in Python what m4e_do_step_3 does in C.
"""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException

from m4e_fmi.fmu.importer.calls.access3 import EVENT_FIELDS, Access, Part, RawComponent, RawState
from m4e_fmi.fmu.importer.calls.standard import (
    EARLY,
    NEAR,
    RESTLESS,
    WARNING,
    Call,
    RawCall,
    Standard,
    Status,
    Value,
    check_view,
)
from m4e_fmi.fmu.importer.calls.typed import Caller, Layout
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import STRUCTURAL, Variable
from m4e_fmi.runtime.library import library

MOST_EVENTS = 1000
_NAMES = {
    "fmi2GetReal": "fmi3GetFloat64",
    "fmi2SetReal": "fmi3SetFloat64",
    "fmi2GetFMUstate": "fmi3GetFMUState",
    "fmi2SetFMUstate": "fmi3SetFMUState",
    "fmi2FreeFMUstate": "fmi3FreeFMUState",
}
_METHODS = {"Enumeration": "Int64"}
_LAYOUTS = {
    **{f"Int{bits}": Layout[f"I{bits}"] for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": Layout[f"U{bits}"] for bits in (8, 16, 32, 64)},
    "Float32": Layout.F32,
    "Float64": Layout.F64,
    "Boolean": Layout.U8,
    "Enumeration": Layout.I64,
    "String": Layout.TEXT,
}
_DoStep = Callable[[float, float, int], tuple[Status, bool, bool, float]]
"""Time, size [s], final → status, event to be handled, end wanted, time reached."""
_RAW = {
    "fmi2GetReal": "m4e_get_3",
    "fmi2SetReal": "m4e_set_3",
    "fmi2DoStep": "m4e_do_step_3",
    "fmi2GetFMUstate": "m4e_save_3",
    "fmi2SetFMUstate": "m4e_restore_3",
}


class Fmi3(Standard):
    """See the module."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._sizes: dict[int, int] = {}
        for variable in self._description.variables.values():
            reference, index = locate(variable.value_reference)
            self._sizes[reference] = max(self._sizes.get(reference, 0), index + 1)
        self._kept: list[Any] = []
        self._raw = RawComponent(next_event=math.inf, ended=math.inf, goes_on=True)
        self.events = self._raw
        self._raw.has_events = self._description.has_events
        self._experiment = (False, 0.0, 0.0, True, 0.0)

    def instantiate(self, name: str, messages: Messages) -> None:
        self._functions.instanceName = name
        try:
            self._instantiate(messages)
        except Exception:
            if not self._raw.has_events:
                raise
            self._raw.has_events = False  # there are FMUs that declare event mode and refuse it
            self._instantiate(messages)
        self.component = self._raw.instance = self._functions.component
        self._raw.do_step = self.address("fmi2DoStep")
        self._raw.enter_event_mode = self.address("fmi3EnterEventMode")
        self._raw.update_discrete_states = self.address("fmi3UpdateDiscreteStates")
        self._raw.enter_step_mode = self.address("fmi3EnterStepMode")
        self._raw.get_state = self.address("fmi2GetFMUstate")
        self._raw.set_state = self.address("fmi2SetFMUstate")

    def _instantiate(self, messages: Messages) -> None:
        events = bool(self._raw.has_events)
        self._functions.instantiate(
            loggingOn=True,
            eventModeUsed=events,
            earlyReturnAllowed=events,
            logMessage=messages.add_3,
        )

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        self._experiment = (tolerance is not None, tolerance or 0.0, start, True, stop)
        self._raw.reached = start

    def enter_initialization(self) -> None:
        self.must("fmi2EnterInitializationMode", *self._experiment)

    def exit_initialization(self) -> None:
        self.must("fmi2ExitInitializationMode")
        if self._raw.has_events:
            self._check(self._settle(self._raw.reached), "fmi3UpdateDiscreteStates")
        self._raw.stepping = True

    def _check(self, status: Status, function: str) -> None:
        if status > WARNING:
            self._failed(status, function)

    def terminate(self) -> Status:
        return self._dll.fmi3Terminate(self.component)

    def free(self) -> None:
        self._functions.fmi3FreeInstance(self.component)
        self.component = self._raw.instance = None

    # ---- values ----

    def set_values(self, values: Mapping[str, Value]) -> None:
        variables = self._description.variables
        sizes = [name for name in values if variables[name].causality == STRUCTURAL]
        if sizes:
            self.must("fmi3EnterConfigurationMode")
            self._set_all({name: values[name] for name in sizes})
            self.must("fmi3ExitConfigurationMode")
        self._set_all({name: value for name, value in values.items() if name not in sizes})

    def _set_all(self, values: Mapping[str, Value]) -> None:
        arrays: dict[int, dict[int, Value]] = {}
        for variable, value in zip(self.variables(list(values)), values.values(), strict=True):
            reference, index = locate(variable.value_reference)
            arrays.setdefault(reference, {})[index] = value
        with self._event_mode():
            for reference, elements in arrays.items():
                self._set_array(reference, elements)

    @contextmanager
    def _event_mode(self) -> Iterator[None]:
        """Where there is event mode, nothing but continuous inputs is set in any other."""
        events = self._raw.has_events and self._raw.stepping and self._raw.ended == math.inf
        if events:
            self.must("fmi3EnterEventMode")
        yield
        if events:
            self._check(self._settle(self._raw.reached), "fmi3UpdateDiscreteStates")

    def _set_array(self, reference: int, elements: Mapping[int, Value]) -> None:
        """Set elements of an array by index; the others get what they have, or their start."""
        members = [
            variable
            for variable in self._description.variables.values()
            if locate(variable.value_reference)[0] == reference
        ]
        kind = members[0].fmi_type
        count = self._sizes[reference]
        given: list[Any] = [None] * count
        if len(elements) < count and self._raw.stepping:
            given = self._array(reference, kind)
        elif len(elements) < count:
            starts = {locate(v.value_reference)[1]: v.start for v in members}
            given = [_start(kind, starts[k]) for k in range(count)]
        for index, value in elements.items():
            given[index] = bytes.fromhex(str(value)) if kind == "Binary" else value
        self._call(f"set{_METHODS.get(kind, kind)}", [reference], given)

    def _array(self, reference: int, kind: str) -> list[Any]:
        """The present values of all elements."""
        count = self._sizes[reference]
        return list(self._call(f"get{_METHODS.get(kind, kind)}", [reference], nValues=count))

    def _call(self, method: str, *arguments: Any, **more: Any) -> Any:
        """One of FMPy's methods; what is more than a warning has `failed`."""
        try:
            return getattr(self._functions, method)(*arguments, **more)
        except FMICallException as error:
            self._failed(error.status, error.function)

    def text(self, variable: Variable) -> str:
        reference, value = (ctypes.c_uint * 1)(variable.value_reference), (ctypes.c_char_p * 1)()
        status = self._dll.fmi3GetString(self.component, reference, 1, value, 1)
        text = value[0]
        return text.decode("utf-8", errors="replace").strip() if status <= WARNING and text else ""

    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        check_view(view, len(names))
        return partial(self._access(names).get, view)

    def setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        check_view(view, len(names))
        return partial(self._access(names).set, view, self._in_event_mode)

    def _caller(self) -> Caller:
        assert self.component
        return Caller(
            "fmi3",
            self.layout,
            self.address,
            self.component,
            self._sizes,
            lambda: 0,
            component=self._raw,
            enter=lambda: self._dll.fmi3EnterEventMode(self.component),
            settle=lambda: self._settle(self._raw.reached),
        )

    def layout(self, variable: Variable) -> tuple[str, Layout]:
        kind = variable.fmi_type
        return _METHODS.get(kind, kind), _LAYOUTS[kind]

    def _access(self, names: Sequence[str]) -> Access:
        return Access(self.variables(names), self._sizes, self.address, self._raw)

    # ---- steps and events ----

    def stepper(self) -> Callable[[float, float, int], Status]:
        step = self.function("fmi2DoStep")
        flags = [ctypes.c_bool() for _ in range(3)]
        reached = ctypes.c_double()
        outcome = tuple(ctypes.byref(place) for place in (*flags, reached))
        event, end, early = flags

        def do_step(time: float, size: float, final: int) -> tuple[Status, bool, bool, float]:
            early.value = event.value = end.value = False
            reached.value = time + size
            status = step(self.component, time, size, final, *outcome)
            last = reached.value if early.value or status > WARNING else time + size
            return status, event.value, end.value, last

        return partial(self._step, do_step)

    def _step(self, do_step: _DoStep, time: float, size: float, final: int) -> Status:
        """The whole step, or up to an event in it; as m4e_do_step_3."""
        c, stop, now = self._raw, time + size, time
        if c.ended < math.inf:
            return 0
        still = 0
        while still < MOST_EVENTS:
            timed = c.has_events and now < c.next_event < stop
            aim = c.next_event if timed else stop
            status, event, end, last = do_step(
                now, size if aim - now == stop - time else aim - now, final
            )
            c.reached = last
            if status > WARNING:
                return status
            within = last < stop - NEAR
            if within and last > time and c.has_events and not c.goes_on:
                return EARLY
            if end:
                c.ended = last
                return status
            if c.has_events and (event or _is_at(last, c.next_event)):
                status = self._in_event_mode()
                if status > WARNING or c.ended < math.inf:
                    return status
            if _is_at(last, stop):
                return status
            c.interruptions += within
            still = 0 if last > now else still + 1
            now = last
        return RESTLESS

    def _in_event_mode(self, part: Part | None = None) -> Status:
        """Event iteration, after a part was set."""
        status = self._dll.fmi3EnterEventMode(self.component)
        if status <= WARNING and part:
            status = part.set(self.component)
        return self._settle(self._raw.reached) if status <= WARNING else status

    def _settle(self, time: float) -> Status:
        """Event iteration, in event mode, and back to step mode."""
        self._raw.handled += 1
        again, end, _nominals, _values, defined = flags = [ctypes.c_bool() for _ in range(5)]
        following = ctypes.c_double()
        places = [ctypes.byref(place) for place in (*flags, following)]
        for _ in range(MOST_EVENTS):
            status = self._dll.fmi3UpdateDiscreteStates(self.component, *places)
            if status > WARNING:
                return status
            if end.value:
                self._raw.ended = time
                return 0
            self._raw.next_event = following.value if defined.value else math.inf
            if not again.value:
                return self._dll.fmi3EnterStepMode(self.component)
        return RESTLESS

    def reached(self) -> float | None:
        return self._raw.reached if math.isfinite(self._raw.reached) else None

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        found = library()
        assert found is not None
        place = ctypes.cast(getattr(found, _RAW[function]), ctypes.c_void_p).value
        assert place
        none = np.zeros(0, dtype=np.uint32)
        if not names:
            return RawCall(place, ctypes.addressof(self._raw), none)
        access = self._access(names)
        self._kept.append(access)
        return RawCall(place, ctypes.addressof(access.raw), none)

    # ---- states and derivatives ----

    def slot(self) -> ctypes.c_void_p:
        state = RawState()
        self._kept.append(state)
        return ctypes.c_void_p(ctypes.addressof(state))

    def saver(self, slot: ctypes.c_void_p) -> Call:
        state, get = _state(slot), self.function("fmi2GetFMUstate")
        place = ctypes.cast(ctypes.addressof(state), ctypes.POINTER(ctypes.c_void_p))

        def save() -> Status:
            for name in EVENT_FIELDS:
                setattr(state, name, getattr(self._raw, name))
            return get(self.component, place)

        return save

    def restorer(self, slot: ctypes.c_void_p) -> Call:
        state, set_ = _state(slot), self.function("fmi2SetFMUstate")

        def restore() -> Status:
            for name in EVENT_FIELDS:
                setattr(self._raw, name, getattr(state, name))
            return set_(self.component, state.state)

        return restore

    def free_state(self, slot: ctypes.c_void_p) -> None:
        place = ctypes.c_void_p(_state(slot).state)
        if place:
            self.function("fmi2FreeFMUstate")(self.component, ctypes.byref(place))

    def directional_derivative(self, output: Variable, known: Variable) -> float:
        (z, row), (v, column) = (locate(x.value_reference) for x in (output, known))
        seed = [0.0] * self._sizes[v]
        seed[column] = 1.0
        count = self._sizes[z]
        return self._call("getDirectionalDerivative", [z], [v], seed, nSensitivity=count)[row]

    def function(self, function: str) -> Any:
        return getattr(self._dll, self.name(function))

    def name(self, function: str) -> str:
        return _NAMES.get(function, function.replace("fmi2", "fmi3"))


def _state(slot: ctypes.c_void_p) -> RawState:
    assert slot.value
    return RawState.from_address(slot.value)


def _is_at(time: float, goal: float) -> bool:
    return time >= goal - 4 * sys.float_info.epsilon * abs(goal)


def _start(kind: str, text: str | None) -> Value | bytes:
    """A start value as FMPy's methods take it."""
    if kind == "String":
        return text or ""
    if kind == "Binary":
        return bytes.fromhex(text or "")
    if kind == "Boolean":
        return text in ("true", "1")
    if kind.startswith("Float"):
        return float(text or 0.0)
    return int(text or 0)
