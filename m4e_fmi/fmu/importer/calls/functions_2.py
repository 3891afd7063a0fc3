"""C functions of FMI 2.0, for co-simulation and model exchange."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from fmpy import fmi2

from m4e_fmi.fmu.importer.calls.functions import (
    Arrays,
    Functions,
    Invoke,
    Status,
    pointer_to,
    references_of,
)
from m4e_fmi.fmu.importer.messages import Messages

_LAST_SUCCESSFUL_TIME = 2
"""Of fmi2StatusKind."""


class Functions2(Functions):
    """Functions of one instance of FMI 2.0."""

    PREFIX = "fmi2"
    BOOLEAN = fmi2.fmi2Boolean
    BYTE = ctypes.c_char

    def name(self, function: str) -> str:
        return self.PREFIX + function

    def instantiate(
        self, name: str, token: str, folder: Path, messages: Messages, *, exchange: bool = False
    ) -> int | None:
        """The component of a new instance of the FMU unpacked in `folder`; None if refused."""
        return self._dll.fmi2Instantiate(
            name.encode("utf-8"),
            fmi2.fmi2ModelExchange if exchange else fmi2.fmi2CoSimulation,
            token.encode("utf-8"),
            (folder / "resources").as_uri().encode("utf-8"),
            ctypes.byref(messages.callbacks),
            fmi2.fmi2False,
            fmi2.fmi2True,
        )

    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> Status:
        return self._call(
            "SetupExperiment",
            int(tolerance is not None),
            tolerance or 0.0,
            start,
            int(stop is not None),
            stop or 0.0,
            note=f"start={start:g}, stop={stop}",
        )

    def enter_initialization(self) -> Status:
        return self._call("EnterInitializationMode")

    def do_step(self, time: float, size: float, final: int) -> Status:
        return self._call("DoStep", time, size, final, note=f"t={time:.9g}, h={size:.9g}")

    def last_successful_time(self) -> tuple[Status, float]:
        return last_successful_time(self._call, math.nan)

    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        info = fmi2.fmi2EventInfo()
        status = self._call("NewDiscreteStates", ctypes.byref(info))
        return status, bool(info.newDiscreteStatesNeeded)

    def arrays(self, keys: Sequence[int], sizes: Mapping[int, int]) -> Arrays:
        del sizes  # scalars only, aliases among them
        return Arrays(tuple(keys), (1,) * len(keys), tuple(range(len(keys))))

    def get_reals(self, arrays: Arrays, values: np.ndarray) -> Status:
        count = len(arrays.references)
        note = f"{count} values"
        return self._call("GetReal", references_of(arrays), count, pointer_to(values), note=note)

    def set_reals(self, arrays: Arrays, values: np.ndarray, note: str = "") -> Status:
        count = len(arrays.references)
        return self._call("SetReal", references_of(arrays), count, pointer_to(values), note=note)

    def directional_derivative(
        self, unknowns: Arrays, knowns: Arrays, seed: np.ndarray, found: np.ndarray
    ) -> Status:
        return self._call(
            "GetDirectionalDerivative",
            references_of(unknowns),
            len(unknowns.references),
            references_of(knowns),
            len(knowns.references),
            pointer_to(seed),
            pointer_to(found),
            note=f"{len(found)} values",
        )

    def output_derivatives(self, outputs: Arrays, order: int, found: np.ndarray) -> Status:
        count = len(outputs.references)
        orders = (ctypes.c_int * count)(*[order] * count)
        arguments = (references_of(outputs), count, orders, pointer_to(found))
        return self._call("GetRealOutputDerivatives", *arguments, note=f"{count} values")

    def set_input_derivatives(self, inputs: Arrays, rates: np.ndarray) -> Status:
        """Set first time derivatives of inputs, `rates` (n_inputs,), in their units per second."""
        count = len(inputs.references)
        orders = (ctypes.c_int * count)(*[1] * count)
        arguments = (references_of(inputs), count, orders, pointer_to(rates))
        return self._call("SetRealInputDerivatives", *arguments)


def last_successful_time(call: Invoke, unwritten: float) -> tuple[Status, float]:
    """Time [s] that fmi2GetRealStatus tells; `unwritten` where it does not."""
    value = ctypes.c_double(unwritten)
    return call("GetRealStatus", _LAST_SUCCESSFUL_TIME, ctypes.byref(value)), value.value
