"""FMI 3.0: arrays as their elements, event mode in co-simulation where the FMU has it.

Events within a step end it early: the whole system's, or, where that cannot be, the FMU goes on
after its event. The runtime's fmus.h makes steps, and moves values: Float64 apart from Float32, and
discrete ones in event mode.
"""

from __future__ import annotations

import ctypes
import math
import os
from collections.abc import Mapping, Sequence
from ctypes import c_bool, c_double, c_uint64, c_void_p
from functools import partial
from typing import Any, ClassVar

import numpy as np
from fmpy import fmi3

from m4e_fmi.fmu.importer.calls.access import Value, guarded, runtime_function
from m4e_fmi.fmu.importer.calls.standard import (
    COUNT,
    INT,
    NUMBER,
    POINTER,
    TEXT,
    RawCall,
    SerializedState,
    Signature,
    Standard,
)
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import Messages, Status
from m4e_fmi.fmu.importer.reading import STRUCTURAL, Variable

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
_PLAIN = INT, POINTER
_MOVE = INT, POINTER, POINTER, COUNT, POINTER, COUNT
_TYPES = (*(kind for kind in _LAYOUTS if kind not in _METHODS),)


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
    SIGNATURES: ClassVar[Mapping[str, Signature]] = {
        **{f"fmi3{verb}{kind}": _MOVE for verb in ("Get", "Set") for kind in _TYPES},
        "fmi3InstantiateCoSimulation": (
            *(POINTER, TEXT, TEXT, TEXT, c_bool, c_bool, c_bool, c_bool),
            *(POINTER, COUNT, POINTER, POINTER, POINTER),
        ),
        "fmi3FreeInstance": (None, POINTER),
        "fmi3EnterInitializationMode": (INT, POINTER, c_bool, NUMBER, NUMBER, c_bool, NUMBER),
        "fmi3ExitInitializationMode": _PLAIN,
        "fmi3EnterConfigurationMode": _PLAIN,
        "fmi3ExitConfigurationMode": _PLAIN,
        "fmi3EnterEventMode": _PLAIN,
        "fmi3EnterStepMode": _PLAIN,
        "fmi3Terminate": _PLAIN,
        "fmi3DoStep": (INT, POINTER, NUMBER, NUMBER, c_bool, POINTER, POINTER, POINTER, POINTER),
        "fmi3UpdateDiscreteStates": (INT, *[POINTER] * 7),
        "fmi3GetFMUState": (INT, POINTER, POINTER),
        "fmi3SetFMUState": (INT, POINTER, POINTER),
        "fmi3FreeFMUState": (INT, POINTER, POINTER),
        "fmi3SerializedFMUStateSize": (INT, POINTER, POINTER, POINTER),
        "fmi3SerializeFMUState": (INT, POINTER, POINTER, POINTER, COUNT),
        "fmi3DeserializeFMUState": (INT, POINTER, POINTER, COUNT, POINTER),
        "fmi3GetDirectionalDerivative": (
            *(INT, POINTER, POINTER, COUNT, POINTER, COUNT, POINTER, COUNT, POINTER, COUNT),
        ),
    }
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
        self._is_new = True
        self._states: list[_RawState] = []

    def instantiate(
        self,
        name: str,
        messages: Messages,
        *,
        exchange: bool = False,
        events: bool = False,
    ) -> None:
        resources = f"{self._loaded.folder / 'resources'}{os.sep}".encode()
        first = (name.encode("utf-8"), self._loaded.guid.encode("utf-8"), resources, False, True)
        log = self._log = fmi3.fmi3LogMessageCallback(messages.add_3)  # kept as long as this is
        if exchange:
            made = self.function("fmi2InstantiateModelExchange")(*first, None, log)
        else:
            make = partial(self.function("fmi2InstantiateCoSimulation"), *first)
            update = fmi3.fmi3IntermediateUpdateCallback()
            rest = ((ctypes.c_uint * 0)(), 0, None, log, update)
            made = make(events, events, *rest)
            if events and not made:  # there are FMUs that declare event mode and refuse it
                events = False
                made = make(events, events, *rest)
        if not made:
            raise RuntimeError("fmi3InstantiateCoSimulation gave no instance")
        self.component = self.events.instance = made
        self.events.has_events = events
        for field, function in {} if exchange else _POINTERS.items():
            setattr(self.events, field, self.address(function))

    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> None:
        self._experiment = start, stop, tolerance
        self.events.reached = start

    def enter_initialization(self) -> None:
        self._is_new = False
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
        of = self._variables
        sizes = {name: value for name, value in values.items() if of[name].causality == STRUCTURAL}
        if sizes:
            self.do("EnterConfigurationMode")
            super().set_values(sizes)
            self.do("ExitConfigurationMode")
        if self._is_new:
            values = self._starts_beside(values) | dict(values)
        if others := {n: v for n, v in values.items() if n not in sizes}:
            super().set_values(others)

    def _starts_beside(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """Start values of the other elements of arrays with some among `values`."""
        given = {variable.value_reference for variable in self.variables(list(values))}
        arrays = {locate(key)[0] for key in given}
        return {
            name: _start(variable)
            for name, variable in self._variables.items()
            if (key := variable.value_reference) not in given and locate(key)[0] in arrays
        }

    def layout(self, variable: Variable) -> tuple[str, str]:
        kind = variable.fmi_type
        return _METHODS.get(kind, kind), _LAYOUTS[kind]

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        place = self.access(names).address if names else ctypes.addressof(self.events)
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
        settle = guarded(ctypes.CFUNCTYPE(INT, POINTER), runtime_function("m4e_settle_3"))
        self.check(settle(ctypes.addressof(self.events)), "fmi2UpdateDiscreteStates")

    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        flags, following = [c_bool() for _ in range(5)], c_double()
        places = (ctypes.byref(place) for place in (*flags, following))
        return self.call("UpdateDiscreteStates", *places), bool(flags[0])

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


def _start(variable: Variable) -> Value:
    """The start value of an element of an array."""
    text = variable.start or ""
    if variable.type == "String":
        return text
    if variable.type == "Boolean":
        return text in ("true", "1")
    return float(text or 0.0) if variable.type == "Real" else int(text or 0)
