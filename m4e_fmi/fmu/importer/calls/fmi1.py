"""FMI 1.0 for co-simulation, stand-alone.

There is no initialization mode: start values and inputs are set first, then the FMU is initialised,
and only then gives values. Here that happens when the first value is read.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from fmpy import fmi1

from m4e_fmi.fmu.importer.calls.classic import Classic
from m4e_fmi.fmu.importer.calls.functions import Status
from m4e_fmi.fmu.importer.calls.parts import Layout
from m4e_fmi.fmu.importer.calls.standard import Call, CFunction, Failed, FmpyInstance
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import Description

_NAMES = {
    "fmi2FreeInstance": "fmiFreeSlaveInstance",
    "fmi2ExitInitializationMode": "fmiInitializeSlave",
    "fmi2Terminate": "fmiTerminateSlave",
}


class Fmi1(Classic):
    """One instance of FMI 1.0, which knows no saved states and no directional derivatives."""

    BOOLEAN = fmi1.fmi1Boolean
    TRUTH = Layout.I8

    def __init__(self, functions: FmpyInstance, description: Description, failed: Failed) -> None:
        super().__init__(functions, description, failed)
        self._experiment = (0.0, fmi1.fmi1False, 0.0)
        self._initialised = False

    def instantiate(self, name: str, messages: Messages) -> None:
        self._fmpy.instanceName = name
        self._fmpy.instantiate(functions=messages.callbacks_1(), loggingOn=True)
        self.component = self._fmpy.component
        if not self.component:
            raise RuntimeError("fmiInstantiateSlave gave no component")

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        del tolerance  # FMI 1.0 hands over none
        self._experiment = (start, fmi1.fmi1True, stop)

    def enter_initialization(self) -> None:
        pass

    def exit_initialization(self) -> None:
        self.check(self._ready(), "fmi2ExitInitializationMode")

    def _ready(self) -> Status:
        if self._initialised:
            return 0
        self._initialised = True
        return self.call("ExitInitializationMode", *self._experiment)

    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        call = self._bound("fmi2GetReal", names, view)

        def get() -> Status:
            self.exit_initialization()
            return call()

        return get

    def function(self, function: str) -> CFunction:
        name = f"{self._description.identifier}_{self.name(function)}"
        loaded = getattr(self._dll, name)
        # FMPy declares that some functions give a text where they give a status
        return ctypes.cast(loaded, ctypes.CFUNCTYPE(ctypes.c_int, *loaded.argtypes))

    def name(self, function: str) -> str:
        return _NAMES.get(function, function.replace("fmi2", "fmi"))
