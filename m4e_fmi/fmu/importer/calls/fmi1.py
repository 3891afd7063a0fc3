"""FMI 1.0 for co-simulation, stand-alone.

There is no initialization mode: start values and inputs are set first, then the FMU is initialised,
and only then gives values. Here that happens when the first value is read.
"""

from __future__ import annotations

import ctypes

from fmpy import fmi1

from m4e_fmi.fmu.importer.calls.fmi2 import Fmi2
from m4e_fmi.fmu.importer.calls.parts import Layout
from m4e_fmi.fmu.importer.calls.standard import CFunction
from m4e_fmi.fmu.importer.messages import Messages, Status

_NAMES = {
    "fmi2FreeInstance": "fmiFreeSlaveInstance",
    "fmi2ExitInitializationMode": "fmiInitializeSlave",
    "fmi2Terminate": "fmiTerminateSlave",
}


class Fmi1(Fmi2):
    """One instance of FMI 1.0, which declares no saved states and no directional derivatives."""

    VERSION = 1
    BOOLEAN = fmi1.fmi1Boolean
    TRUTH = Layout.I8

    _experiment: tuple[float, int, float]
    _initialised = False

    def instantiate(
        self,
        name: str,
        messages: Messages,
        *,
        token: str | None = None,
        exchange: bool = False,
        events: bool = False,
    ) -> None:
        del token, exchange, events
        self._fmpy.instanceName = name
        self._fmpy.instantiate(functions=messages.callbacks_1(), loggingOn=True)
        self.component = self._fmpy.component
        if not self.component:
            raise RuntimeError("fmiInstantiateSlave gave no component")

    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> None:
        del tolerance  # FMI 1.0 hands over none
        self._experiment = start, int(stop is not None), stop or 0.0

    def enter_initialization(self) -> None:
        pass

    def exit_initialization(self) -> None:
        self.check(self.ready(), "fmi2ExitInitializationMode")

    def ready(self) -> Status:
        if self._initialised:
            return 0
        self._initialised = True
        return self.call("ExitInitializationMode", *self._experiment)

    def wants_end(self) -> bool:
        return False

    def function(self, function: str) -> CFunction:
        loaded = getattr(self._dll, f"{self._fmpy.modelIdentifier}_{self.name(function)}")
        # FMPy declares that some functions give a text where they give a status
        return ctypes.cast(loaded, ctypes.CFUNCTYPE(ctypes.c_int, *loaded.argtypes))

    def name(self, function: str) -> str:
        return _NAMES.get(function, function.replace("fmi2", "fmi"))
