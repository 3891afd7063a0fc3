"""FMI 3.0: arrays as their elements, event mode in co-simulation where the FMU has it.

Events within a step end it early: the whole system's, or, where that cannot be, the FMU goes on
after its event. The runtime's fmus.h makes steps, and moves values: Float64 apart from Float32, and
discrete ones in event mode.
"""

from __future__ import annotations

import ctypes
import math
import os
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import c_bool, c_double, c_uint64, c_void_p
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import fmi3
from fmpy.fmi1 import FMICallException

from m4e_fmi.fmu.importer.calls.access import Access, runtime_function
from m4e_fmi.fmu.importer.calls.standard import (
    RESTLESS,
    RawCall,
    SerializedState,
    Standard,
    Value,
)
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import Messages, Status
from m4e_fmi.fmu.importer.reading import STRUCTURAL, Variable

MOST_EVENTS = 1000
EVENT_FIELDS = ("next_event", "reached", "ended", "interruptions")
"""Fields that a saved state has of its component."""
_METHODS = {"Enumeration": "Int64"}
_LAYOUTS = {
    **{f"Int{bits}": f"I{bits}" for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": f"U{bits}" for bits in (8, 16, 32, 64)},
    "Float32": "F32",
    "Float64": "F64",
    "Boolean": "U8",
    "Enumeration": "I64",
    "String": "TEXT",
}
_RAW = {
    "fmi2GetReal": "m4e_get_3",
    "fmi2SetReal": "m4e_set_3",
    "fmi2DoStep": "m4e_do_step_3",
    "fmi2GetFMUstate": "m4e_save_3",
    "fmi2SetFMUstate": "m4e_restore_3",
}
_RENAMED = {
    "GetReal": "GetFloat64",
    "SetReal": "SetFloat64",
    "GetDerivatives": "GetContinuousStateDerivatives",
    "GetRealOutputDerivatives": "GetOutputDerivatives",
    "GetFMUstate": "GetFMUState",
    "SetFMUstate": "SetFMUState",
    "FreeFMUstate": "FreeFMUState",
    "SerializedFMUstateSize": "SerializedFMUStateSize",
    "SerializeFMUstate": "SerializeFMUState",
    "DeSerializeFMUstate": "DeserializeFMUState",
}
_POINTERS = {
    "do_step": "fmi2DoStep",
    "enter_event_mode": "fmi2EnterEventMode",
    "update_discrete_states": "fmi2UpdateDiscreteStates",
    "enter_step_mode": "fmi2EnterStepMode",
    "get_state": "fmi2GetFMUstate",
    "set_state": "fmi2SetFMUstate",
}
"""Field of a component → function."""

_Element = Value | bytes | None


class _RawState(ctypes.Structure):
    """`m4e_state_3`."""

    _fields_ = [
        ("state", c_void_p),
        ("next_event", c_double),
        ("reached", c_double),
        ("ended", c_double),
        ("interruptions", c_uint64),
    ]


class Fmi3(Standard):
    """One instance of FMI 3.0."""

    VERSION = 3
    BYTE = ctypes.c_uint8
    SIZED = True

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        sizes: dict[int, int] = {}
        for variable in self._variables.values():
            reference, index = locate(variable.value_reference)
            sizes[reference] = max(sizes.get(reference, 0), index + 1)
        self.sizes = self.sizes or sizes
        self._experiment: tuple[float, float | None, float | None] = (0.0, None, None)
        self._accesses: dict[tuple[str, ...], Access] = {}
        self._states: list[_RawState] = []

    def instantiate(
        self,
        name: str,
        messages: Messages,
        *,
        token: str | None = None,
        exchange: bool = False,
        events: bool = False,
    ) -> None:
        guid: str = self._fmpy.guid if token is None else token
        resources = f"{Path(self._fmpy.unzipDirectory, 'resources')}{os.sep}".encode()
        first = (name.encode("utf-8"), guid.encode("utf-8"), resources, False, True)
        log = self._log = fmi3.fmi3LogMessageCallback(messages.add_3)  # kept as long as this is
        if exchange:
            made = self._dll.fmi3InstantiateModelExchange(*first, None, log)
        else:
            make = partial(self._dll.fmi3InstantiateCoSimulation, *first)
            update = fmi3.fmi3IntermediateUpdateCallback()
            rest = ((ctypes.c_uint * 0)(), 0, None, log, update)
            made = make(events, events, *rest)
            if events and not made:  # there are FMUs that declare event mode and refuse it
                events = False
                made = make(events, events, *rest)
        if not made:
            raise RuntimeError("fmi3InstantiateCoSimulation gave no instance")
        self._fmpy.component = self.component = self.events.instance = made
        self.events.has_events = events
        for field, function in {} if exchange else _POINTERS.items():
            setattr(self.events, field, self.address(function))

    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> None:
        self._experiment = start, stop, tolerance
        self.events.reached = start

    def enter_initialization(self) -> None:
        start, stop, tolerance = self._experiment
        self.do(
            "EnterInitializationMode",
            tolerance is not None,
            tolerance or 0.0,
            start,
            stop is not None,
            stop or 0.0,
            note=f"start={start:g}, stop={stop}",
        )

    def exit_initialization(self) -> None:
        super().exit_initialization()
        if self.events.has_events:
            self._settle()
        self.events.stepping = True

    def free(self) -> None:
        super().free()
        self.events.instance = None

    # ---- values ----

    def set_values(self, values: Mapping[str, Value]) -> None:
        sizes = [name for name in values if self._variables[name].causality == STRUCTURAL]
        if sizes:
            self.do("EnterConfigurationMode")
            self._set_all({name: values[name] for name in sizes})
            self.do("ExitConfigurationMode")
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
        c = self.events
        events = c.has_events and c.stepping and c.ended == math.inf
        if events:
            self.do("EnterEventMode")
        yield
        if events:
            self._settle()

    def _set_array(self, reference: int, elements: Mapping[int, Value]) -> None:
        """Set elements of an array by index; the others get what they have, or their start."""
        members = {
            index: variable
            for variable in self._variables.values()
            for owner, index in [locate(variable.value_reference)]
            if owner == reference
        }
        kind = members[0].fmi_type
        method, count = _METHODS.get(kind, kind), self.sizes[reference]
        given: list[_Element] = [None] * count
        if len(elements) < count and self.events.stepping:
            given = list(self._call(f"get{method}", [reference], nValues=count))
        elif len(elements) < count:
            given = [_start(kind, members[k].start) for k in range(count)]
        for index, value in elements.items():
            given[index] = bytes.fromhex(str(value)) if kind == "Binary" else value
        self._call(f"set{method}", [reference], given)

    def _call(self, method: str, *arguments: object, **more: object) -> Any:
        """Call one of FMPy's methods; statuses above Warning go to `failed`."""
        try:
            return getattr(self._fmpy, method)(*arguments, **more)
        except FMICallException as error:
            self._failed(error.status, error.function)

    def layout(self, variable: Variable) -> tuple[str, str]:
        kind = variable.fmi_type
        return _METHODS.get(kind, kind), _LAYOUTS[kind]

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        place = ctypes.addressof(self.events)
        if names:
            if tuple(names) not in self._accesses:
                self._accesses[tuple(names)] = self.typed(names, self._texts)
            place = self._accesses[tuple(names)].address
        return RawCall(runtime_function(_RAW[function]), place, np.zeros(0, dtype=np.uint32))

    # ---- steps and events ----

    def step_beginner(self) -> int:
        self.events.begin_step = super().step_beginner()
        return runtime_function("m4e_begin_step_3")

    def do_step(self, time: float, size: float) -> Status:
        places = ctypes.byref(c_bool()), ctypes.byref(c_bool()), ctypes.byref(c_bool())
        last, note = ctypes.byref(c_double()), f"t={time:.9g}, h={size:.9g}"
        return self.call("DoStep", time, size, 0, *places, last, note=note)

    def _settle(self) -> None:
        """Event iteration, in event mode, and back to step mode."""
        c = self.events
        c.handled += 1
        for _ in range(MOST_EVENTS):
            status, again, end, following = self._update_discrete_states()
            self.check(status, "fmi2UpdateDiscreteStates")
            if end:
                c.ended = c.reached
                return
            c.next_event = following
            if not again:
                self.do("EnterStepMode")
                return
        self.check(RESTLESS, "fmi2UpdateDiscreteStates")

    def _update_discrete_states(self) -> tuple[Status, bool, bool, float]:
        """Status, true if another is needed, if it asks for the end, and the next event's time."""
        flags, following = [c_bool() for _ in range(5)], c_double()
        places = (ctypes.byref(place) for place in (*flags, following))
        status = self.call("UpdateDiscreteStates", *places)
        again, end, _, _, known = (bool(flag) for flag in flags)
        return status, again, end, following.value if known else math.inf

    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        return self._update_discrete_states()[:2]

    def reached(self) -> float | None:
        return self.events.reached if math.isfinite(self.events.reached) else None

    # ---- states ----

    def slot(self) -> ctypes.c_void_p:
        state = _RawState()
        self._states.append(state)
        return c_void_p(ctypes.addressof(state))

    def handle(self, slot: ctypes.c_void_p) -> ctypes.c_void_p:
        return c_void_p(_state(slot).state)

    def serialized(self, slot: ctypes.c_void_p) -> SerializedState:
        events = tuple(float(getattr(_state(slot), name)) for name in EVENT_FIELDS)
        return SerializedState(self.state_bytes(self.handle(slot)), events)

    def deserialize(self, slot: ctypes.c_void_p, state: SerializedState) -> None:
        kept = _state(slot)
        *times, count = state.events
        for name, value in zip(EVENT_FIELDS, (*times, int(count)), strict=True):
            setattr(kept, name, value)
        kept.state = self.state_of(state.data).value

    def name(self, function: str) -> str:
        bare = function[len("fmi2") :]
        return f"fmi3{_RENAMED.get(bare, bare)}"


def _state(slot: ctypes.c_void_p) -> _RawState:
    assert slot.value
    return _RawState.from_address(slot.value)


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
