"""Variables of an FMU that are not Real, or take values of such, read and set together.

Each value lies in a cell, an int64: see the runtime's typed.h, whose structures are here. A text
is kept once, so that a number stands for it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_char_p, c_double, c_int, c_int32, c_int64, c_uint64, c_void_p
from dataclasses import dataclass
from typing import ClassVar
from weakref import finalize

import numpy as np

from m4e_fmi.fmu.importer.calls.parts import Caller, RawPart, batches, guarded, runtime_function
from m4e_fmi.fmu.importer.messages import WARNING, Status
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.runtime.library import library

DOES_NOT_FIT = -2
LOWEST, HIGHEST = -(2**63), 2**63 - 1
_MOVE = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p)


@dataclass(frozen=True)
class Taken:
    """Value for a variable: the cell `source`, a value of `origin`, which is from `low` to `high`.

    A Real takes `factor` times the value plus `offset`. A `large` cell is unsigned, of 64 bits.
    """

    source: int
    origin: str
    low: int = LOWEST
    high: int = HIGHEST
    factor: float = 1.0
    offset: float = 0.0
    large: bool = False


class _RawTypedPart(RawPart):
    """`m4e_typed_part`."""

    _fields_: ClassVar = [
        ("layout", c_int32),
        ("sized", c_int32),
        ("partial", c_int32),
        ("discrete", c_int32),
        ("truth", c_int32),
    ]


class _RawTaken(ctypes.Structure):
    """`m4e_taken`."""

    _fields_ = [
        ("low", c_int64),
        ("high", c_int64),
        ("factor", c_double),
        ("offset", c_double),
        ("source", ctypes.c_uint32),
        ("large", c_int32),
    ]


class _RawTyped(ctypes.Structure):
    """`m4e_typed`."""

    _fields_ = [
        ("instance", c_void_p),
        ("component", c_void_p),
        ("parts", c_void_p),
        ("part_count", c_uint64),
        ("texts", c_void_p),
        ("taken", c_void_p),
        ("changed", c_void_p),
        ("failed", c_uint64),
    ]


class RawCopied(ctypes.Structure):
    """`m4e_copied`."""

    _fields_ = [("source", c_void_p), ("places", c_void_p), ("count", c_uint64)]


class _RawTexts(ctypes.Structure):
    """`m4e_texts`."""

    _fields_ = [
        ("texts", c_void_p),
        ("slots", c_void_p),
        ("count", c_uint64),
        ("room", c_uint64),
        ("size", c_uint64),
    ]


class Texts:
    """Different texts (UTF-8), each at its place; the empty one at 0. They are kept as this is."""

    def __init__(self) -> None:
        self._raw = _RawTexts()
        found = library()
        if found is None:
            return  # nothing that has texts can be called without it
        self._library = found  # pyrefly: ignore[possibly-uninitialized-attribute]
        found.m4e_text_place.argtypes = ctypes.POINTER(_RawTexts), c_char_p
        found.m4e_text_place.restype = c_int64
        found.m4e_text_at.argtypes = ctypes.POINTER(_RawTexts), c_int64
        found.m4e_text_at.restype = c_char_p
        finalize(self, found.m4e_texts_free, ctypes.byref(self._raw))
        self.place(b"")

    @property
    def address(self) -> int:
        """That of the C structure."""
        return ctypes.addressof(self._raw)

    def place(self, text: bytes) -> int:
        """Where the text is; it is added if it is not there yet."""
        place = self._library.m4e_text_place(self._raw, text)
        if place < 0:
            raise MemoryError
        return place

    def content(self) -> tuple[bytes, ...]:
        """All texts, by their places."""
        return tuple(self._library.m4e_text_at(self._raw, place) for place in range(len(self)))

    def __len__(self) -> int:
        return int(self._raw.count)

    def __getitem__(self, place: int) -> str:
        return self._library.m4e_text_at(self._raw, place).decode("utf-8", errors="replace")


def value_in(cell: int, variable: Variable, texts: Texts) -> int | bool | str:
    """The value in a cell that was read from a variable."""
    if variable.type == "String":
        return texts[cell]
    if variable.type == "Boolean":
        return bool(cell)
    return cell % 2**64 if variable.fmi_type == "UInt64" else cell


class Access:
    """Some variables of one FMU: `get` brings their values into cells, `set` takes them from there.

    They are read into consecutive cells; what they take is told by `taken`. Where a cell changes in
    reading, `changed` (float64, one element) becomes 0.
    """

    def __init__(
        self,
        variables: Sequence[Variable],
        caller: Caller,
        texts: Texts,
        *,
        taken: Sequence[Taken] = (),
        changed: np.ndarray | None = None,
    ) -> None:
        self.names = tuple(v.name for v in variables)
        self.taken = tuple(taken)
        self._ready, self._holds = caller.ready, (texts, changed, caller)
        functions = ("m4e_get_typed", "m4e_set_typed")
        self._get, self._set = (guarded(_MOVE, runtime_function(name)) for name in functions)
        self._parts = batches(variables, caller)
        self._raw_parts = (_RawTypedPart * len(self._parts))(
            *(
                _RawTypedPart(
                    **part.raw_fields,
                    layout=part.layout.value[0],
                    sized=caller.component is not None,
                    partial=part.partial,
                    discrete=part.discrete,
                    truth=part.truth,
                )
                for part in self._parts
            )
        )
        self._raw_taken = (_RawTaken * len(self.taken))(
            *(_RawTaken(t.low, t.high, t.factor, t.offset, t.source, t.large) for t in self.taken)
        )
        component = caller.component
        self._raw = _RawTyped(
            instance=caller.instance,
            component=None if component is None else ctypes.addressof(component),
            parts=ctypes.addressof(self._raw_parts),
            part_count=len(self._parts),
            texts=texts.address,
            taken=ctypes.addressof(self._raw_taken),
            changed=None if changed is None else changed.ctypes.data,
        )

    @property
    def address(self) -> int:
        """That of the C structure."""
        return ctypes.addressof(self._raw)

    @property
    def failed(self) -> int:
        """The part that failed last; the variable whose value does not fit."""
        return int(self._raw.failed)

    @property
    def function(self) -> str:
        """The function that failed last."""
        part = self._parts[self.failed]
        return part.set_name if self.taken else part.get_name

    def get(self, cells: np.ndarray) -> Status:
        """Read all into `cells` (n_cells,), int64, in the variables' units."""
        status = self._ready()
        return status if status > WARNING else self._get(self.address, cells.ctypes.data)

    def set(self, cells: np.ndarray) -> Status:
        """Set all from `cells` (n_cells,), int64, in the variables' units.

        DOES_NOT_FIT if the type of a variable cannot hold its value.
        """
        return self._set(self.address, cells.ctypes.data)
