"""FMI 2.0 for co-simulation."""

from __future__ import annotations

import ctypes
import math
from typing import Any

from fmpy import fmi2

from m4e_fmi.fmu.importer.calls.classic import Classic
from m4e_fmi.fmu.importer.calls.standard import WARNING, Call, Status
from m4e_fmi.fmu.importer.calls.typed import Layout
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import Variable

_TERMINATED = 3
"""Of fmi2StatusKind."""
_SAVE_OR_RESTORE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)


class Fmi2(Classic):
    """See the module."""

    BOOLEAN = fmi2.fmi2Boolean
    TRUTH = Layout.I32

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._ended: dict[int, float] = {}

    def instantiate(self, name: str, messages: Messages) -> None:
        self._functions.instanceName = name
        self._functions.instantiate(callbacks=messages.callbacks, loggingOn=True)
        self.component = self._functions.component

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        defined = int(tolerance is not None), tolerance or 0.0
        self.must("fmi2SetupExperiment", *defined, start, fmi2.fmi2True, stop)

    def enter_initialization(self) -> None:
        self.must("fmi2EnterInitializationMode")

    def exit_initialization(self) -> None:
        self.must("fmi2ExitInitializationMode")

    def terminate(self) -> Status:
        return self._dll.fmi2Terminate(self.component)

    def free(self) -> None:
        self._functions.fmi2FreeInstance(self.component)
        self.component = None

    def wants_end(self) -> bool:
        value = ctypes.c_int()
        status = self._dll.fmi2GetBooleanStatus(self.component, _TERMINATED, ctypes.byref(value))
        return status <= WARNING and bool(value.value)

    def saver(self, slot: ctypes.c_void_p) -> Call:
        function = _SAVE_OR_RESTORE(self.address("fmi2GetFMUstate"))
        place = ctypes.addressof(slot)

        def save() -> Status:
            self._ended[place] = self.events.ended
            return function(self.component, place)

        return save

    def restorer(self, slot: ctypes.c_void_p) -> Call:
        function = _SAVE_OR_RESTORE(self.address("fmi2SetFMUstate"))
        place = ctypes.addressof(slot)

        def restore() -> Status:
            self.events.ended = self._ended.get(place, math.inf)
            return function(self.component, slot.value)

        return restore

    def free_state(self, slot: ctypes.c_void_p) -> None:
        if slot:
            self._dll.fmi2FreeFMUstate(self.component, ctypes.byref(slot))

    def directional_derivative(self, output: Variable, known: Variable) -> float:
        unknowns, knowns = (
            (ctypes.c_uint * 1)(variable.value_reference) for variable in (output, known)
        )
        seed, value = ctypes.c_double(1.0), ctypes.c_double()
        directions = ctypes.byref(seed), ctypes.byref(value)
        self.must("fmi2GetDirectionalDerivative", unknowns, 1, knowns, 1, *directions)
        return value.value

    def function(self, function: str) -> Any:
        return getattr(self._dll, function)

    def name(self, function: str) -> str:
        return function
