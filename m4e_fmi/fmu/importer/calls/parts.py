"""Variables of one type that are read and set by one call, elements of arrays among them.

FMI 3.0 moves whole arrays: a part's buffer holds all elements of all its arrays, and those that are
not wanted keep the values that they have.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_int, c_size_t, c_uint64, c_void_p
from dataclasses import dataclass
from enum import Enum

import numpy as np

from m4e_fmi.fmu.importer.calls.component_3 import RawComponent
from m4e_fmi.fmu.importer.calls.functions import Arrays, Status, guarded
from m4e_fmi.fmu.importer.reading import Variable

_TRANSFER = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p)
_SIZED_TRANSFER = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_size_t)


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

    @property
    def number(self) -> int:
        """The number in typed.h."""
        return self.value[0]

    @property
    def dtype(self) -> np.dtype:
        """The type of a NumPy array of such values."""
        return np.dtype(self.value[1])


@dataclass(frozen=True)
class Caller:
    """How an FMU is called for its variables.

    `functions` tells for a variable what stands behind fmi2Get or fmi3Get in the name of its
    function, and how its values lie in memory; `address` finds a function; `sizes` are the numbers
    of elements of arrays by value reference. `ready` is called before values are read. Of FMI 3.0,
    `component` is the record of the instance, `enter` and `settle` begin and end event mode.
    """

    prefix: str
    functions: Callable[[Variable], tuple[str, Layout]]
    address: Callable[[str], int]
    instance: int | None
    sizes: Mapping[int, int]
    ready: Callable[[], Status]
    component: RawComponent | None = None
    enter: Callable[[], Status] = lambda: 0
    settle: Callable[[], Status] = lambda: 0


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


class Part:
    """Variables of one type: ``buffer[places[i]]`` is the value of the wanted ``members[i]``."""

    def __init__(
        self, variables: Sequence[Variable], members: Sequence[int], caller: Caller
    ) -> None:
        name, self.layout = caller.functions(variables[0])
        self.get_name, self.set_name = (f"{caller.prefix}{verb}{name}" for verb in ("Get", "Set"))
        keys = [v.value_reference for v in variables]
        arrays = Arrays.of(keys, caller.sizes)
        self.references = np.array(arrays.references, dtype=np.uint32)
        self.places = np.array(arrays.places, dtype=np.uint32)
        self.members = np.array(members, dtype=np.uint32)
        self.buffer = np.zeros(arrays.count, dtype=self.layout.dtype)
        self.partial = len(set(keys)) < len(self.buffer)
        self.discrete = variables[0].variability != "continuous"
        self._caller = caller
        self._addresses = caller.address(self.get_name), caller.address(self.set_name)
        self._arguments = [self.references.ctypes.data, len(self.references)]
        self._arguments.append(self.buffer.ctypes.data)
        kind = _TRANSFER
        if caller.component is not None:
            kind = _SIZED_TRANSFER
            self._arguments.append(len(self.buffer))
        self._get, self._set = (guarded(kind, address) for address in self._addresses)

    def get(self) -> Status:
        """Read all arrays into the buffer."""
        return self._get(self._instance, *self._arguments)

    def set(self) -> Status:
        """Set all arrays from the buffer."""
        return self._set(self._instance, *self._arguments)

    @property
    def _instance(self) -> int | None:
        component = self._caller.component
        return self._caller.instance if component is None else component.instance

    @property
    def raw_fields(self) -> dict[str, int]:
        """Values of the fields of `RawPart`."""
        return {
            "get": self._addresses[0],
            "set": self._addresses[1],
            "references": self.references.ctypes.data,
            "places": self.places.ctypes.data,
            "members": self.members.ctypes.data,
            "buffer": self.buffer.ctypes.data,
            "reference_count": len(self.references),
            "value_count": len(self.buffer),
            "count": len(self.places),
        }
