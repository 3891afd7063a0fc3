"""Reals of an FMI 3.0 FMU that are read or set together, elements of arrays among them.

FMI 3.0 moves whole arrays, and Float64 apart from Float32. So there is a part for each type, whose
buffer holds all elements of all its arrays; elements that are not among the wanted ones keep the
values that they have. The raw structures are what the C library needs for
the same: see the runtime's component_3.h.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_int, c_int32, c_size_t, c_uint64, c_void_p

import numpy as np

from m4e_fmi.fmu.importer.calls.standard import WARNING, Status
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.reading import Variable

TRANSFER = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_size_t)


class RawComponent(ctypes.Structure):
    """`m4e_component_3`; Python keeps its own record of the instance in it, too."""

    _fields_ = [
        ("instance", c_void_p),
        ("do_step", c_void_p),
        ("enter_event_mode", c_void_p),
        ("update_discrete_states", c_void_p),
        ("enter_step_mode", c_void_p),
        ("get_state", c_void_p),
        ("set_state", c_void_p),
        ("has_events", c_int32),
        ("stepping", c_int32),
        ("goes_on", c_int32),
        ("next_event", c_double),
        ("reached", c_double),
        ("ended", c_double),
        ("interruptions", c_uint64),
        ("handled", c_uint64),
    ]
    next_event: float
    ended: float
    goes_on: int
    interruptions: int
    handled: int


class RawState(ctypes.Structure):
    """`m4e_state_3`."""

    _fields_ = [
        ("state", c_void_p),
        ("next_event", c_double),
        ("reached", c_double),
        ("ended", c_double),
        ("interruptions", c_uint64),
    ]


EVENT_FIELDS = ("next_event", "reached", "ended", "interruptions")
"""What a state has of its component."""


class RawPart(ctypes.Structure):
    """`m4e_part_3`."""

    _fields_ = [
        ("get", c_void_p),
        ("set", c_void_p),
        ("references", c_void_p),
        ("places", c_void_p),
        ("members", c_void_p),
        ("buffer", c_void_p),
        ("reference_count", c_uint64),
        ("value_count", c_uint64),
        ("count", c_uint64),
        ("single", c_int32),
        ("partial", c_int32),
        ("discrete", c_int32),
    ]


class RawAccess(ctypes.Structure):
    """`m4e_access_3`."""

    _fields_ = [("component", c_void_p), ("parts", c_void_p), ("count", c_uint64)]


class Part:
    """Variables of one type: ``buffer[places[i]]`` is the value of the wanted ``members[i]``.

    `address` finds FMI 3.0's functions, `sizes` are the numbers of elements by value reference.
    """

    def __init__(
        self,
        variables: Sequence[Variable],
        members: Sequence[int],
        sizes: Mapping[int, int],
        address: Callable[[str], int],
    ) -> None:
        kind = variables[0].fmi_type
        located = [locate(v.value_reference) for v in variables]
        arrays = list(dict.fromkeys(reference for reference, _ in located))
        starts = dict(zip(arrays, np.cumsum([0, *(sizes[a] for a in arrays)]), strict=False))
        self.references = np.array(arrays, dtype=np.uint32)
        self.places = np.array([starts[a] + k for a, k in located], dtype=np.uint32)
        self.members = np.array(members, dtype=np.uint32)
        self.buffer = np.zeros(
            sum(sizes[a] for a in arrays), np.float32 if kind == "Float32" else np.float64
        )
        self.partial = len(set(located)) < len(self.buffer)
        self.discrete = variables[0].variability != "continuous"
        self._get_address, self._set_address = address(f"fmi3Get{kind}"), address(f"fmi3Set{kind}")
        self._arguments = (
            self.references.ctypes.data,
            len(self.references),
            self.buffer.ctypes.data,
            len(self.buffer),
        )
        self._get, self._set = TRANSFER(self._get_address), TRANSFER(self._set_address)

    def get(self, instance: int | None) -> Status:
        return self._get(instance, *self._arguments)

    def set(self, instance: int | None) -> Status:
        return self._set(instance, *self._arguments)

    @property
    def raw(self) -> RawPart:
        return RawPart(
            get=self._get_address,
            set=self._set_address,
            references=self.references.ctypes.data,
            places=self.places.ctypes.data,
            members=self.members.ctypes.data,
            buffer=self.buffer.ctypes.data,
            reference_count=len(self.references),
            value_count=len(self.buffer),
            count=len(self.places),
            single=self.buffer.dtype == np.float32,
            partial=self.partial,
            discrete=self.discrete,
        )


class Access:
    """The parts of some variables; `get` and `set` move `values`, which are in their order.

    `in_event_mode` sets a part there; where it is None, all is set as it is.
    """

    def __init__(
        self,
        variables: Sequence[Variable],
        sizes: Mapping[int, int],
        address: Callable[[str], int],
        component: RawComponent,
    ) -> None:
        self._component = component
        kinds: dict[tuple[str, bool], list[int]] = {}
        for k, v in enumerate(variables):
            kinds.setdefault((v.fmi_type, v.variability == "continuous"), []).append(k)
        self.parts = tuple(
            Part([variables[k] for k in members], members, sizes, address)
            for members in kinds.values()
        )
        self._raw_parts = (RawPart * len(self.parts))(*(part.raw for part in self.parts))
        self.raw = RawAccess(
            component=ctypes.addressof(component),
            parts=ctypes.addressof(self._raw_parts),
            count=len(self.parts),
        )

    def get(self, values: np.ndarray) -> Status:
        worst = 0
        for part in self.parts:
            status = part.get(self._component.instance)
            if status > WARNING:
                return status
            worst = max(worst, status)
            values[part.members] = part.buffer[part.places]
        return worst

    def set(self, values: np.ndarray, in_event_mode: Callable[[Part], Status]) -> Status:
        worst = 0
        for part in self.parts:
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
            status = part.get(c.instance)
            if status > WARNING:
                return status
        before = part.buffer[part.places]
        part.buffer[part.places] = values[part.members]
        if quietly:
            return part.set(c.instance)
        return in_event_mode(part) if (before != part.buffer[part.places]).any() else 0
