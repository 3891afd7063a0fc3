"""FMI 2.0, for co-simulation and model exchange, and FMI 1.0 for co-simulation, stand-alone."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from fmpy import fmi1, fmi2

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
    pointer_to,
)
from m4e_fmi.fmu.importer.messages import WARNING, Messages, Status
from m4e_fmi.fmu.importer.reading import Variable

_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3
"""Of fmi2StatusKind."""
_NAMES_1 = {
    "fmi2FreeInstance": "fmiFreeSlaveInstance",
    "fmi2ExitInitializationMode": "fmiInitializeSlave",
    "fmi2Terminate": "fmiTerminateSlave",
}
"""Those of FMI 1.0 that are called otherwise."""
FLAG_1 = ctypes.c_char
_PLAIN = INT, POINTER
_MOVE = INT, POINTER, POINTER, COUNT, POINTER
_TYPES = "Real", "Integer", "Boolean", "String"


def _for_both(prefix: str) -> dict[str, Signature]:
    """Functions that are the same in FMI 1.0 and 2.0."""
    return {
        **{f"{prefix}{verb}{kind}": _MOVE for verb in ("Get", "Set") for kind in _TYPES},
        f"{prefix}SetRealInputDerivatives": (INT, POINTER, POINTER, COUNT, POINTER, POINTER),
        f"{prefix}GetRealStatus": (INT, POINTER, INT, POINTER),
    }


class Fmi2(Standard):
    """One instance of FMI 2.0; `TRUTH` is how a Boolean lies in memory."""

    VERSION = 2
    SIGNATURES: ClassVar[Mapping[str, Signature]] = {
        **_for_both("fmi2"),
        "fmi2Instantiate": (POINTER, TEXT, INT, TEXT, TEXT, POINTER, INT, INT),
        "fmi2FreeInstance": (None, POINTER),
        "fmi2SetupExperiment": (INT, POINTER, INT, NUMBER, NUMBER, INT, NUMBER),
        "fmi2EnterInitializationMode": _PLAIN,
        "fmi2ExitInitializationMode": _PLAIN,
        "fmi2Terminate": _PLAIN,
        "fmi2DoStep": (INT, POINTER, NUMBER, NUMBER, INT),
        "fmi2GetBooleanStatus": (INT, POINTER, INT, POINTER),
        "fmi2GetFMUstate": (INT, POINTER, POINTER),
        "fmi2SetFMUstate": (INT, POINTER, POINTER),
        "fmi2FreeFMUstate": (INT, POINTER, POINTER),
        "fmi2SerializedFMUstateSize": (INT, POINTER, POINTER, POINTER),
        "fmi2SerializeFMUstate": (INT, POINTER, POINTER, POINTER, COUNT),
        "fmi2DeSerializeFMUstate": (INT, POINTER, POINTER, COUNT, POINTER),
        "fmi2GetDirectionalDerivative": (
            *(INT, POINTER, POINTER, COUNT, POINTER, COUNT, POINTER, POINTER),
        ),
    }
    BYTE = ctypes.c_char
    TRUTH: ClassVar[str] = "I32"

    _ended: dict[int, float]
    """Of each slot, when the FMU had asked for the end by then."""

    def instantiate(
        self,
        name: str,
        messages: Messages,
        *,
        exchange: bool = False,
        events: bool = False,
    ) -> None:
        del events  # FMI 2.0 has event mode in model exchange only, and always there
        self._ended = {}
        self.component = self.function("fmi2Instantiate")(
            name.encode("utf-8"),
            fmi2.fmi2ModelExchange if exchange else fmi2.fmi2CoSimulation,
            self._loaded.guid.encode("utf-8"),
            (self._loaded.folder / "resources").as_uri().encode("utf-8"),
            ctypes.byref(messages.callbacks),
            fmi2.fmi2False,
            fmi2.fmi2True,
        )
        if self.component is None:
            raise RuntimeError("fmi2Instantiate gave no component")

    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> None:
        self.do(
            "SetupExperiment",
            int(tolerance is not None),
            tolerance or 0.0,
            start,
            int(stop is not None),
            stop or 0.0,
            note=f"start={start:g}, stop={stop}",
        )

    # ---- values ----

    def layout(self, variable: Variable) -> tuple[str, str]:
        return {
            "Real": ("Real", "F64"),
            "Integer": ("Integer", "I32"),
            "Enumeration": ("Integer", "I32"),
            "Boolean": ("Boolean", self.TRUTH),
            "String": ("String", "TEXT"),
        }[variable.type]

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        assert self.component
        references = [v.value_reference for v in self.variables(names)]
        references = np.array(references, dtype=np.uint32)
        return RawCall(self.address(function), self.component, references)

    def set_input_derivatives(
        self, references: Sequence[int], order: int, rates: np.ndarray
    ) -> Status:
        """Set time derivatives of an `order` of inputs.

        They are `rates` (n_inputs,), in the inputs' units per s or s².
        """
        count = len(references)
        orders = (ctypes.c_int * count)(*[order] * count)
        arguments = (ctypes.c_uint * count)(*references), count, orders, pointer_to(rates)
        return self.call("SetRealInputDerivatives", *arguments)

    # ---- steps ----

    def do_step(self, time: float, size: float) -> Status:
        return self.call("DoStep", time, size, 0, note=f"t={time:.9g}, h={size:.9g}")

    def wants_end(self) -> bool:
        value = ctypes.c_int()
        status = self.call("GetBooleanStatus", _TERMINATED, ctypes.byref(value))
        return status <= WARNING and bool(value.value)

    def reached(self) -> float | None:
        value = ctypes.c_double()
        status = self.call("GetRealStatus", _LAST_SUCCESSFUL_TIME, ctypes.byref(value))
        return value.value if status <= WARNING and math.isfinite(value.value) else None

    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        info = fmi2.fmi2EventInfo()
        status = self.call("NewDiscreteStates", ctypes.byref(info))
        return status, bool(info.newDiscreteStatesNeeded)

    # ---- states ----

    def slot(self) -> ctypes.c_void_p:
        return ctypes.c_void_p()

    def handle(self, slot: ctypes.c_void_p) -> ctypes.c_void_p:
        return slot

    def save(self, slot: ctypes.c_void_p) -> Status:
        self._ended[ctypes.addressof(slot)] = self.events.ended
        return super().save(slot)

    def restore(self, slot: ctypes.c_void_p) -> Status:
        self.events.ended = self._ended.get(ctypes.addressof(slot), math.inf)
        return super().restore(slot)

    def serialized(self, slot: ctypes.c_void_p) -> SerializedState:
        ended = self._ended.get(ctypes.addressof(slot), math.inf)
        return SerializedState(self.state_bytes(slot), (ended,))

    def deserialize(self, slot: ctypes.c_void_p, state: SerializedState) -> None:
        (self._ended[ctypes.addressof(slot)],) = state.events
        slot.value = self.state_of(state.data).value

    def name(self, function: str) -> str:
        return function


class Fmi1(Fmi2):
    """One instance of FMI 1.0, which declares no saved states and no directional derivatives.

    There is no initialization mode: start values and inputs are set first, then the FMU is
    initialised, and only then gives values. Here that happens when the first value is read.
    """

    VERSION = 1
    SIGNATURES: ClassVar[Mapping[str, Signature]] = {
        **_for_both("fmi"),
        "fmiInstantiateSlave": (
            *(POINTER, TEXT, TEXT, TEXT, TEXT, NUMBER, FLAG_1, FLAG_1),
            *(fmi1.fmi1CallbackFunctions, FLAG_1),
        ),
        "fmiFreeSlaveInstance": (None, POINTER),
        "fmiInitializeSlave": (INT, POINTER, NUMBER, FLAG_1, NUMBER),
        "fmiTerminateSlave": _PLAIN,
        "fmiDoStep": (INT, POINTER, NUMBER, NUMBER, FLAG_1),
    }
    TRUTH = "I8"

    _experiment: tuple[float, int, float]
    _initialised = False

    def instantiate(
        self,
        name: str,
        messages: Messages,
        *,
        exchange: bool = False,
        events: bool = False,
    ) -> None:
        del exchange, events
        self.component = self.function("fmi2InstantiateSlave")(
            name.encode("utf-8"),
            self._loaded.guid.encode("utf-8"),
            self._loaded.folder.as_uri().encode("utf-8"),
            b"application/x-fmu-sharedlibrary",
            *(0.0, 0, 0),  # no time-out, invisible, not interactive
            messages.callbacks_1(),
            1,
        )
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

    def name(self, function: str) -> str:
        return _NAMES_1.get(function, function.replace("fmi2", "fmi"))
