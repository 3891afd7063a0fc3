"""Reals of an FMI 3.0 FMU that are read or set together, as the runtime's component_3.h does.

FMI 3.0 moves Float64 apart from Float32, and discrete ones are set in event mode: there is a part
for each.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from ctypes import c_int32, c_uint64, c_void_p
from typing import ClassVar

import numpy as np

from m4e_fmi.fmu.importer.calls.component_3 import RawComponent
from m4e_fmi.fmu.importer.calls.functions import WARNING, Status
from m4e_fmi.fmu.importer.calls.parts import Caller, Layout, Part, RawPart
from m4e_fmi.fmu.importer.reading import Variable


class _RawPart3(RawPart):
    """`m4e_part_3`."""

    _fields_: ClassVar = [("single", c_int32), ("partial", c_int32), ("discrete", c_int32)]


class _RawAccess(ctypes.Structure):
    """`m4e_access_3`."""

    _fields_ = [("component", c_void_p), ("parts", c_void_p), ("count", c_uint64)]


class RealAccess:
    """The parts of some Reals; `get` and `set` move values (n_variables,) in the order given.

    `in_event_mode` sets a part there.
    """

    def __init__(
        self, variables: Sequence[Variable], caller: Caller, component: RawComponent
    ) -> None:
        self._component = component
        kinds: dict[tuple[str, bool], list[int]] = {}
        for k, v in enumerate(variables):
            kinds.setdefault((v.fmi_type, v.variability == "continuous"), []).append(k)
        self._parts = tuple(
            Part([variables[k] for k in members], members, caller) for members in kinds.values()
        )
        self._raw_parts = (_RawPart3 * len(self._parts))(*map(_raw, self._parts))
        self._raw = _RawAccess(
            component=ctypes.addressof(component),
            parts=ctypes.addressof(self._raw_parts),
            count=len(self._parts),
        )

    @property
    def address(self) -> int:
        """That of the C structure."""
        return ctypes.addressof(self._raw)

    def get(self, values: np.ndarray) -> Status:
        """Read all into `values` (n_variables,), in the variables' units."""
        worst = 0
        for part in self._parts:
            status = part.get()
            if status > WARNING:
                return status
            worst = max(worst, status)
            values[part.members] = part.buffer[part.places]
        return worst

    def set(self, values: np.ndarray, in_event_mode: Callable[[Part], Status]) -> Status:
        """Set all from `values` (n_variables,), in the variables' units."""
        worst = 0
        for part in self._parts:
            status = self._set(part, values, in_event_mode)
            if status > WARNING:
                return status
            worst = max(worst, status)
        return worst

    def _set(
        self, part: Part, values: np.ndarray, in_event_mode: Callable[[Part], Status]
    ) -> Status:
        c = self._component
        ended = c.ended < math.inf  # in event mode, for good
        quietly = ended or not (part.discrete and c.has_events and c.stepping)
        if part.partial or not quietly:
            status = part.get()
            if status > WARNING:
                return status
        before = part.buffer[part.places]
        part.buffer[part.places] = values[part.members]
        if quietly:
            return part.set()
        return in_event_mode(part) if (before != part.buffer[part.places]).any() else 0


def _raw(part: Part) -> _RawPart3:
    return _RawPart3(
        **part.raw_fields,
        single=part.layout is Layout.F32,
        partial=part.partial,
        discrete=part.discrete,
    )
