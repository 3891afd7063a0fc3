"""Functions that FMI 1.0 and 2.0 have in common: the same C arguments, by other names."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import ClassVar

import numpy as np

from m4e_fmi.fmu.importer.calls.functions import WARNING, Status, guarded
from m4e_fmi.fmu.importer.calls.functions_2 import last_successful_time
from m4e_fmi.fmu.importer.calls.parts import Caller, Layout
from m4e_fmi.fmu.importer.calls.standard import (
    Call,
    Failed,
    FmpyInstance,
    RawCall,
    Standard,
    Value,
    check_view,
)
from m4e_fmi.fmu.importer.reading import Description, Variable

_GET_OR_SET = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p
)
_DO_STEP = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int
)
_SET_DERIVATIVES = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_void_p,
    ctypes.c_void_p,
    ctypes.c_size_t,
    ctypes.c_void_p,
    ctypes.c_void_p,
)


class Classic(Standard):
    """Scalars, moved by addresses that are prepared once.

    `BOOLEAN` is the C type of a Boolean, `TRUTH` how it lies in memory.
    """

    BOOLEAN: ClassVar[type[ctypes.c_int | ctypes.c_char]]
    TRUTH: ClassVar[Layout]

    def __init__(self, functions: FmpyInstance, description: Description, failed: Failed) -> None:
        super().__init__(functions, description, failed)
        self._kept: list[np.ndarray] = []

    def set_values(self, values: Mapping[str, Value]) -> None:
        kinds = {
            "Real": ("SetReal", ctypes.c_double),
            "Integer": ("SetInteger", ctypes.c_int),
            "Enumeration": ("SetInteger", ctypes.c_int),
            "Boolean": ("SetBoolean", self.BOOLEAN),
            "String": ("SetString", ctypes.c_char_p),
        }
        for variable, value in zip(self.variables(list(values)), values.values(), strict=True):
            function, kind = kinds[variable.type]
            data = (kind * 1)(value.encode("utf-8") if isinstance(value, str) else value)
            reference = (ctypes.c_uint * 1)(variable.value_reference)
            self.check(self.call(function, reference, 1, data), f"fmi2{function}")

    def text(self, variable: Variable) -> str:
        reference, value = (ctypes.c_uint * 1)(variable.value_reference), (ctypes.c_char_p * 1)()
        status = self.call("GetString", reference, 1, value)
        text = value[0]
        return text.decode("utf-8", errors="replace").strip() if status <= WARNING and text else ""

    def setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        return self._bound("fmi2SetReal", names, view)

    def _bound(self, function: str, names: Sequence[str], view: np.ndarray) -> Call:
        check_view(view, len(names))
        references = self._references(names)
        self._kept += [references, view]
        call = guarded(_GET_OR_SET, self.address(function))
        return partial(call, self.component, references.ctypes.data, len(names), view.ctypes.data)

    def _caller(self) -> Caller:
        return Caller("fmi2", self._layout, self.address, self.component, {}, self._ready)

    def _ready(self) -> Status:
        """Do what values need before they are read."""
        return 0

    def _layout(self, variable: Variable) -> tuple[str, Layout]:
        return {
            "Real": ("Real", Layout.F64),
            "Integer": ("Integer", Layout.I32),
            "Enumeration": ("Integer", Layout.I32),
            "Boolean": ("Boolean", self.TRUTH),
            "String": ("String", Layout.TEXT),
        }[variable.type]

    def _references(self, names: Sequence[str]) -> np.ndarray:
        return np.array([v.value_reference for v in self.variables(names)], dtype=np.uint32)

    def stepper(self) -> Callable[[float, float, int], Status]:
        return partial(guarded(_DO_STEP, self.address("fmi2DoStep")), self.component)

    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        assert self.component
        return RawCall(self.address(function), self.component, self._references(names))

    def derivative_setter(self, name: str, order: int, view: np.ndarray) -> Call:
        """A call that sets the time derivative of an `order` of an input.

        `view` (1,) holds it, in the input's unit per s or s².
        """
        check_view(view, 1)
        references, orders = self._references([name]), np.array([order], dtype=np.int32)
        self._kept += [references, orders, view]
        function = guarded(_SET_DERIVATIVES, self.address("fmi2SetRealInputDerivatives"))
        addresses = (references.ctypes.data, len(references), orders.ctypes.data)
        return partial(function, self.component, *addresses, view.ctypes.data)

    def reached(self) -> float | None:
        status, time = last_successful_time(self.call, 0.0)
        return time if status <= WARNING and math.isfinite(time) else None
