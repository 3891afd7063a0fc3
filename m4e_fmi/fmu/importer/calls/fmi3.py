"""FMI 3.0 for co-simulation: arrays as their elements, event mode where the FMU has it.

Events within a step end it early: the whole system's, or, where that cannot be, the FMU goes on
after its event. `step` does in Python what m4e_do_step_3 does in C.
"""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException

from m4e_fmi.fmu.importer.calls.component_3 import EVENT_FIELDS, RawComponent, RawState
from m4e_fmi.fmu.importer.calls.functions import WARNING, Status
from m4e_fmi.fmu.importer.calls.functions_3 import DiscreteStates, Functions3
from m4e_fmi.fmu.importer.calls.parts import Caller, Layout, Part
from m4e_fmi.fmu.importer.calls.reals_3 import RealAccess
from m4e_fmi.fmu.importer.calls.standard import (
    EARLY,
    NEAR,
    RESTLESS,
    Call,
    CFunction,
    Failed,
    FmpyInstance,
    RawCall,
    Rollback,
    SerializedState,
    Standard,
    Value,
    check_view,
)
from m4e_fmi.fmu.importer.calls.typed import function as runtime_function
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import STRUCTURAL, Description, Variable

MOST_EVENTS = 1000
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
_RAW = {
    "fmi2GetReal": "m4e_get_3",
    "fmi2SetReal": "m4e_set_3",
    "fmi2DoStep": "m4e_do_step_3",
    "fmi2GetFMUstate": "m4e_save_3",
    "fmi2SetFMUstate": "m4e_restore_3",
}


_Element = Value | bytes | None


class Fmi3(Standard, Rollback):
    """One instance of FMI 3.0."""

    def __init__(self, functions: FmpyInstance, description: Description, failed: Failed) -> None:
        super().__init__(functions, description, failed)
        self._calls = Functions3(self._dll, self.call)
        self._sizes: dict[int, int] = {}
        for variable in self._description.variables.values():
            reference, index = locate(variable.value_reference)
            self._sizes[reference] = max(self._sizes.get(reference, 0), index + 1)
        self._kept: list[object] = []
        self._raw = RawComponent(next_event=math.inf, ended=math.inf, goes_on=True)
        self.events = self._raw
        self._raw.has_events = self._description.has_events

    def instantiate(self, name: str, messages: Messages) -> None:
        made = self._instantiate(name, messages)
        if not made and self._raw.has_events:
            self._raw.has_events = False  # there are FMUs that declare event mode and refuse it
            made = self._instantiate(name, messages)
        if not made:
            raise RuntimeError("fmi3InstantiateCoSimulation gave no instance")
        self._fmpy.component = self.component = self._raw.instance = made
        self._raw.do_step = self.address("fmi2DoStep")
        self._raw.enter_event_mode = self.address("fmi3EnterEventMode")
        self._raw.update_discrete_states = self.address("fmi3UpdateDiscreteStates")
        self._raw.enter_step_mode = self.address("fmi3EnterStepMode")
        self._raw.get_state = self.address("fmi2GetFMUstate")
        self._raw.set_state = self.address("fmi2SetFMUstate")

    def _instantiate(self, name: str, messages: Messages) -> int | None:
        folder, events = self._fmpy.unzipDirectory, bool(self._raw.has_events)
        resources = f"{Path(folder, 'resources')}{os.sep}".encode()
        return self._calls.instantiate(
            name, self._fmpy.guid, resources, messages, event_mode=events, early_return=events
        )

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        self._calls.setup(start=start, stop=stop, tolerance=tolerance)
        self._raw.reached = start

    def enter_initialization(self) -> None:
        self.check(self._calls.enter_initialization(), "fmi2EnterInitializationMode")

    def exit_initialization(self) -> None:
        self.check(self.call("ExitInitializationMode"), "fmi2ExitInitializationMode")
        if self._raw.has_events:
            self.check(self._settle(self._raw.reached), "fmi3UpdateDiscreteStates")
        self._raw.stepping = True

    def free(self) -> None:
        super().free()
        self._raw.instance = None

    # ---- values ----

    def set_values(self, values: Mapping[str, Value]) -> None:
        variables = self._description.variables
        sizes = [name for name in values if variables[name].causality == STRUCTURAL]
        if sizes:
            self.check(self.call("EnterConfigurationMode"), "fmi3EnterConfigurationMode")
            self._set_all({name: values[name] for name in sizes})
            self.check(self.call("ExitConfigurationMode"), "fmi3ExitConfigurationMode")
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
    def _event_mode(self) -> Generator[None, None, None]:
        """Where there is event mode, nothing but continuous inputs is set in any other."""
        events = self._raw.has_events and self._raw.stepping and self._raw.ended == math.inf
        if events:
            self.check(self.call("EnterEventMode"), "fmi3EnterEventMode")
        yield
        if events:
            self.check(self._settle(self._raw.reached), "fmi3UpdateDiscreteStates")

    def _set_array(self, reference: int, elements: Mapping[int, Value]) -> None:
        """Set elements of an array by index; the others get what they have, or their start."""
        members = [
            variable
            for variable in self._description.variables.values()
            if locate(variable.value_reference)[0] == reference
        ]
        kind = members[0].fmi_type
        count = self._sizes[reference]
        given: list[_Element] = [None] * count
        if len(elements) < count and self._raw.stepping:
            given = self._array(reference, kind)
        elif len(elements) < count:
            starts = {locate(v.value_reference)[1]: v.start for v in members}
            given = [_start(kind, starts[k]) for k in range(count)]
        for index, value in elements.items():
            given[index] = bytes.fromhex(str(value)) if kind == "Binary" else value
        self._call(f"set{_METHODS.get(kind, kind)}", [reference], given)

    def _array(self, reference: int, kind: str) -> list[_Element]:
        """The present values of all elements."""
        count = self._sizes[reference]
        return list(self._call(f"get{_METHODS.get(kind, kind)}", [reference], nValues=count))

    def _call(self, method: str, *arguments: object, **more: object) -> Any:
        """One of FMPy's methods; what is more than a warning has `failed`."""
        try:
            return getattr(self._fmpy, method)(*arguments, **more)
        except FMICallException as error:
            self._failed(error.status, error.function)

    def text(self, variable: Variable) -> str:
        reference, value = (ctypes.c_uint * 1)(variable.value_reference), (ctypes.c_char_p * 1)()
        status = self.call("GetString", reference, 1, value, 1)
        text = value[0]
        return text.decode("utf-8", errors="replace").strip() if status <= WARNING and text else ""

    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        check_view(view, len(names))
        return partial(self._access(names).get, view)

    def setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        check_view(view, len(names))
        return partial(self._access(names).set, view, self._in_event_mode)

    def _caller(self) -> Caller:
        return Caller(
            "fmi3",
            self._layout,
            self.address,
            self.component,
            self._sizes,
            lambda: 0,
            component=self._raw,
            enter=lambda: self.call("EnterEventMode"),
            settle=lambda: self._settle(self._raw.reached),
        )

    def _layout(self, variable: Variable) -> tuple[str, Layout]:
        kind = variable.fmi_type
        return _METHODS.get(kind, kind), _LAYOUTS[kind]

    def _access(self, names: Sequence[str]) -> RealAccess:
        return RealAccess(self.variables(names), self._caller(), self._raw)

    # ---- steps and events ----

    def stepper(self) -> Callable[[float, float, int], Status]:
        return self._step

    def step_beginner(self) -> int:
        self._raw.begin_step = super().step_beginner()
        return runtime_function("m4e_begin_step_3")

    def _step(self, time: float, size: float, final: int) -> Status:
        """The whole step, or up to an event in it; as m4e_do_step_3."""
        c, stop, now = self._raw, time + size, time
        if c.ended < math.inf:
            return 0
        still = 0
        while still < MOST_EVENTS:
            timed = c.has_events and now < c.next_event < stop
            aim = c.next_event if timed else stop
            part = size if aim - now == stop - time else aim - now
            status = self._calls.do_step(now, part, final, reached=now + part)
            outcome = self._calls.outcome
            told = outcome.early or status > WARNING
            c.reached = last = outcome.reached if told else now + part
            if status > WARNING:
                return status
            within = last < stop - NEAR
            if within and last > time and c.has_events and not c.goes_on:
                return EARLY
            if outcome.end:
                c.ended = last
                return status
            if c.has_events and (outcome.event or _is_at(last, c.next_event)):
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
        status = self.call("EnterEventMode")
        if status <= WARNING and part:
            status = part.set()
        return self._settle(self._raw.reached) if status <= WARNING else status

    def _settle(self, time: float) -> Status:
        """Event iteration, in event mode, and back to step mode."""
        self._raw.handled += 1
        states = DiscreteStates()
        for _ in range(MOST_EVENTS):
            status = self._calls.update_discrete_states(states)
            if status > WARNING:
                return status
            if states.end:
                self._raw.ended = time
                return 0
            self._raw.next_event = states.next_event
            if not states.again:
                return self.call("EnterStepMode")
        return RESTLESS

    def reached(self) -> float | None:
        return self._raw.reached if math.isfinite(self._raw.reached) else None

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        place = runtime_function(_RAW[function])
        none = np.zeros(0, dtype=np.uint32)
        if not names:
            return RawCall(place, ctypes.addressof(self._raw), none)
        access = self._access(names)
        self._kept.append(access)
        return RawCall(place, access.address, none)

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
            self.call("FreeFMUstate", ctypes.byref(place))

    def serialized(self, slot: ctypes.c_void_p) -> SerializedState:
        state = _state(slot)
        status, data = self._calls.state_bytes(ctypes.c_void_p(state.state))
        self.check(status, "fmi2SerializeFMUstate")
        return SerializedState(data, tuple(float(getattr(state, name)) for name in EVENT_FIELDS))

    def deserialize(self, slot: ctypes.c_void_p, state: SerializedState) -> None:
        kept, place = _state(slot), ctypes.c_void_p()
        *times, count = state.events
        for name, value in zip(EVENT_FIELDS, (*times, int(count)), strict=True):
            setattr(kept, name, value)
        self.check(self._calls.state_from(state.data, place), "fmi2DeSerializeFMUstate")
        kept.state = place.value

    def directional_derivative(self, output: Variable, known: Variable) -> float:
        z, v = (self._calls.arrays([x.value_reference], self._sizes) for x in (output, known))
        seed, found = np.zeros(v.count), np.zeros(z.count)
        seed[v.places[0]] = 1.0
        status = self._calls.directional_derivative(z, v, seed, found)
        self.check(status, "fmi3GetDirectionalDerivative")
        return float(found[z.places[0]])

    def function(self, function: str) -> CFunction:
        return getattr(self._dll, self.name(function))

    def name(self, function: str) -> str:
        return self._calls.name(function[len("fmi2") :])


def _state(slot: ctypes.c_void_p) -> RawState:
    assert slot.value
    return RawState.from_address(slot.value)


def _is_at(time: float, goal: float) -> bool:
    return time >= goal - 4 * sys.float_info.epsilon * abs(goal)


def _start(kind: str, text: str | None) -> _Element:
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
