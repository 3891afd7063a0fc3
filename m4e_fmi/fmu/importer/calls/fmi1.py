"""FMI 1.0 for co-simulation, stand-alone.

There is no initialization mode: all that is known goes in first, then the FMU is initialised, and
only then gives values. Here that happens when the first of its values is wanted.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from fmpy import fmi1

from m4e_fmi.fmu.importer.calls.classic import Classic
from m4e_fmi.fmu.importer.calls.standard import WARNING, Call, Status
from m4e_fmi.fmu.importer.calls.typed import Layout
from m4e_fmi.fmu.importer.messages import Messages

_NAMES = {
    "fmi2FreeInstance": "fmiFreeSlaveInstance",
    "fmi2ExitInitializationMode": "fmiInitializeSlave",
    "fmi2Terminate": "fmiTerminateSlave",
}


class Fmi1(Classic):
    """See the module. No FMU of FMI 1.0 saves its state or has directional derivatives."""

    BOOLEAN = fmi1.fmi1Boolean
    TRUTH = Layout.I8

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._experiment = (0.0, fmi1.fmi1False, 0.0)
        self._initialised = False

    def instantiate(self, name: str, messages: Messages) -> None:
        self._functions.instanceName = name
        self._functions.instantiate(functions=messages.callbacks_1(), loggingOn=True)
        self.component = self._functions.component
        if not self.component:
            raise RuntimeError("fmiInstantiateSlave gave no component")

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        del tolerance  # FMI 1.0 hands over none
        self._experiment = (start, fmi1.fmi1True, stop)

    def enter_initialization(self) -> None:
        pass

    def exit_initialization(self) -> None:
        status = self._initialise()
        if status > WARNING:
            self._failed(status, "fmi2ExitInitializationMode")

    def _initialise(self) -> Status:
        if self._initialised:
            return 0
        self._initialised = True
        return self.function("fmi2ExitInitializationMode")(self.component, *self._experiment)

    def _ready(self) -> Status:
        return self._initialise()

    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        call = super().getter(names, view)

        def get() -> Status:
            status = self._initialise()
            return call() if status <= WARNING else status

        return get

    def terminate(self) -> Status:
        return self.function("fmi2Terminate")(self.component)

    def free(self) -> None:
        self.function("fmi2FreeInstance")(self.component)
        self.component = None

    def function(self, function: str) -> Any:
        name = f"{self._description.identifier}_{self.name(function)}"
        loaded = getattr(self._dll, name)
        # FMPy declares that some functions give a text where they give a status
        return ctypes.cast(loaded, ctypes.CFUNCTYPE(ctypes.c_int, *loaded.argtypes))

    def name(self, function: str) -> str:
        return _NAMES.get(function, function.replace("fmi2", "fmi"))
