"""FMI 2.0 for co-simulation."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from fmpy import fmi2

from m4e_fmi.fmu.importer.calls.classic import Classic
from m4e_fmi.fmu.importer.calls.functions import WARNING, Status, guarded
from m4e_fmi.fmu.importer.calls.functions_2 import Functions2
from m4e_fmi.fmu.importer.calls.parts import Layout
from m4e_fmi.fmu.importer.calls.standard import (
    Call,
    CFunction,
    Failed,
    FmpyInstance,
    Rollback,
    SerializedState,
)
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import Description, Variable

_TERMINATED = 3
"""Of fmi2StatusKind."""
_SAVE_OR_RESTORE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)


class Fmi2(Classic, Rollback):
    """One instance of FMI 2.0."""

    BOOLEAN = fmi2.fmi2Boolean
    TRUTH = Layout.I32

    def __init__(self, functions: FmpyInstance, description: Description, failed: Failed) -> None:
        super().__init__(functions, description, failed)
        self._calls = Functions2(self._dll, self.call)
        self._ended: dict[int, float] = {}

    def instantiate(self, name: str, messages: Messages) -> None:
        folder = Path(self._fmpy.unzipDirectory)
        self.component = self._calls.instantiate(name, self._fmpy.guid, folder, messages)
        if self.component is None:
            raise RuntimeError("fmi2Instantiate gave no component")

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        status = self._calls.setup(start=start, stop=stop, tolerance=tolerance)
        self.check(status, "fmi2SetupExperiment")

    def enter_initialization(self) -> None:
        self.check(self._calls.enter_initialization(), "fmi2EnterInitializationMode")

    def exit_initialization(self) -> None:
        self.check(self.call("ExitInitializationMode"), "fmi2ExitInitializationMode")

    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        return self._bound("fmi2GetReal", names, view)

    def wants_end(self) -> bool:
        value = ctypes.c_int()
        status = self.call("GetBooleanStatus", _TERMINATED, ctypes.byref(value))
        return status <= WARNING and bool(value.value)

    def slot(self) -> ctypes.c_void_p:
        return ctypes.c_void_p()

    def saver(self, slot: ctypes.c_void_p) -> Call:
        function = guarded(_SAVE_OR_RESTORE, self.address("fmi2GetFMUstate"))
        place = ctypes.addressof(slot)

        def save() -> Status:
            self._ended[place] = self.events.ended
            return function(self.component, place)

        return save

    def restorer(self, slot: ctypes.c_void_p) -> Call:
        function = guarded(_SAVE_OR_RESTORE, self.address("fmi2SetFMUstate"))
        place = ctypes.addressof(slot)

        def restore() -> Status:
            self.events.ended = self._ended.get(place, math.inf)
            return function(self.component, slot.value)

        return restore

    def free_state(self, slot: ctypes.c_void_p) -> None:
        if slot:
            self.call("FreeFMUstate", ctypes.byref(slot))

    def serialized(self, slot: ctypes.c_void_p) -> SerializedState:
        status, data = self._calls.state_bytes(slot)
        self.check(status, "fmi2SerializeFMUstate")
        return SerializedState(data, (self._ended.get(ctypes.addressof(slot), math.inf),))

    def deserialize(self, slot: ctypes.c_void_p, state: SerializedState) -> None:
        (self._ended[ctypes.addressof(slot)],) = state.events
        self.check(self._calls.state_from(state.data, slot), "fmi2DeSerializeFMUstate")

    def directional_derivative(self, output: Variable, known: Variable) -> float:
        unknowns, knowns = (self._calls.arrays([v.value_reference], {}) for v in (output, known))
        value = np.zeros(1)
        status = self._calls.directional_derivative(unknowns, knowns, np.ones(1), value)
        self.check(status, "fmi2GetDirectionalDerivative")
        return float(value[0])

    def function(self, function: str) -> CFunction:
        return getattr(self._dll, function)

    def name(self, function: str) -> str:
        return function
