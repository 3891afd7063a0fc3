"""Variables of one type that are read and set by one call, elements of arrays among them.

FMI 3.0 moves whole arrays: a part's buffer holds all elements of all its arrays, and those that are
not wanted keep the values that they have. The runtime's typed.h and component_3.h do the work.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_int32, c_uint64, c_void_p
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import Status
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.runtime.library import library


def guarded(prototype: type, address: int) -> Callable[..., Status]:
    """The C function of an FMU at an address; each call ends in the default environment."""
    function = prototype(address)
    function.errcheck = lambda status, *_: restored(status)
    return function


def restored(status: Status) -> Status:
    """The status of a call of an FMU, with the default floating-point environment again.

    Python goes on in the same thread: with values at the start, and after the last call.
    """
    if found := library():
        found.m4e_restore_environment()
    return status


def runtime_function(name: str) -> int:
    """The address of a function of the C library; RunError where there is no such library."""
    found = library()
    if found is None:
        message = "FMUs of FMI 3.0, and values of other types than Real, need the C library"
        raise RunError(message, "`m4e-fmi doctor` tells why there is none")
    return address_of(getattr(found, name))


def address_of(function: Any) -> int:
    """The address of a C function."""
    address = ctypes.cast(function, c_void_p).value
    assert address
    return address


@dataclass(frozen=True)
class Arrays:
    """Whole arrays with wanted elements: ``values[places[i]]`` is element i of those wanted.

    `references` are the arrays' value references, `sizes` their numbers of elements.
    """

    references: tuple[int, ...]
    sizes: tuple[int, ...]
    places: tuple[int, ...]

    @classmethod
    def of(cls, keys: Sequence[int], sizes: Mapping[int, int]) -> Arrays:
        """The arrays of elements with these keys, each once; see `elements.locate`."""
        located = [locate(key) for key in keys]
        starts: dict[int, int] = {}
        count = 0
        for reference, _ in located:
            if reference not in starts:
                starts[reference] = count
                count += sizes.get(reference, 1)
        places = tuple(starts[reference] + index for reference, index in located)
        return cls(tuple(starts), tuple(sizes.get(r, 1) for r in starts), places)

    @property
    def count(self) -> int:
        """Number of elements of all arrays."""
        return sum(self.sizes)


class Layout(Enum):
    """How values lie in memory: the number in typed.h, and the type of NumPy."""

    I8 = 0, "i1"
    U8 = 1, "u1"
    I16 = 2, "i2"
    U16 = 3, "u2"
    I32 = 4, "i4"
    U32 = 5, "u4"
    I64 = 6, "i8"
    U64 = 7, "u8"
    F32 = 8, "f4"
    F64 = 9, "f8"
    TEXT = 10, np.uintp


class RawComponent(ctypes.Structure):
    """`m4e_component_3`: the record of an FMI 3.0 instance, and what any instance tells of events.

    Times are in seconds: `next_event` is announced, `reached` that of the last step, `ended` that
    of the end the FMU asked for; infinite if there is none. `goes_on` if it steps on after an event
    within a step; `interruptions` are such events, `handled` the times in event mode.
    """

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
        ("begin_step", c_void_p),
    ]
    instance: int | None
    has_events: int
    stepping: int
    goes_on: int
    next_event: float
    reached: float
    ended: float
    interruptions: int
    handled: int
    begin_step: int


@dataclass(frozen=True)
class Caller:
    """How an FMU is called for its variables.

    `functions` tells for a variable what stands behind Get in the name of its function, and how its
    values lie in memory; `address` finds a function; `sizes` are the numbers
    of elements of arrays by value reference. `ready` is called before values are read. `component`
    is the record of an instance of FMI 3.0.
    """

    functions: Callable[[Variable], tuple[str, Layout]]
    address: Callable[[str], int]
    instance: int | None
    sizes: Mapping[int, int]
    ready: Callable[[], Status]
    component: RawComponent | None = None


class RawPart(ctypes.Structure):
    """The fields that `m4e_part_3` and `m4e_typed_part` begin with."""

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
    ]


class Batch:
    """Variables of one type: ``buffer[places[i]]`` is the value of the wanted ``members[i]``."""

    def __init__(
        self, variables: Sequence[Variable], members: Sequence[int], caller: Caller
    ) -> None:
        name, self.layout = caller.functions(variables[0])
        self.get_name, self.set_name = (f"fmi2{verb}{name}" for verb in ("Get", "Set"))
        keys = [v.value_reference for v in variables]
        arrays = Arrays.of(keys, caller.sizes)
        self._references = np.array(arrays.references, dtype=np.uint32)
        self._places = np.array(arrays.places, dtype=np.uint32)
        self._members = np.array(members, dtype=np.uint32)
        self._buffer = np.zeros(arrays.count, dtype=self.layout.value[1])
        self.partial = len(set(keys)) < arrays.count
        self.discrete = variables[0].variability != "continuous"
        self.truth = variables[0].type == "Boolean"
        self.raw_fields = {
            "get": caller.address(self.get_name),
            "set": caller.address(self.set_name),
            "references": self._references.ctypes.data,
            "places": self._places.ctypes.data,
            "members": self._members.ctypes.data,
            "buffer": self._buffer.ctypes.data,
            "reference_count": len(self._references),
            "value_count": arrays.count,
            "count": len(self._places),
        }


def batches(variables: Sequence[Variable], caller: Caller) -> list[Batch]:
    """The parts of some variables: by type, and those last that are set in event mode."""
    kinds: dict[tuple[bool, str], list[int]] = {}
    for k, v in enumerate(variables):
        kinds.setdefault((v.variability != "continuous", v.fmi_type), []).append(k)
    return [
        Batch([variables[k] for k in members], members, caller)
        for _, members in sorted(kinds.items())
    ]
