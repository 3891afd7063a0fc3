"""Variables of an FMU that are not Real, read and set together; what takes their values.

Each value lies in a cell, an int64: see the runtime's typed.h, whose structures are here. `Access`
does in Python what m4e_get_typed and m4e_set_typed do in C.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_int, c_int32, c_int64, c_size_t, c_uint64, c_void_p
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.fmu.importer.calls.texts import Texts
from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.runtime.library import library

if TYPE_CHECKING:
    from m4e_fmi.fmu.importer.calls.access3 import RawComponent

WARNING = 1
DOES_NOT_FIT = -2
LOWEST, HIGHEST = -(2**63), 2**63 - 1
_TRANSFER = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p)
_SIZED_TRANSFER = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_size_t)

Status = int


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
        return self.value[0]

    @property
    def dtype(self) -> np.dtype:
        return np.dtype(self.value[1])


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


class _RawPart(ctypes.Structure):
    """`m4e_typed_part`."""

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


def function(name: str) -> int:
    """The address of a function of typed.h."""
    found = library()
    assert found is not None
    place = ctypes.cast(getattr(found, name), c_void_p).value
    assert place
    return place


def value_in(cell: int, variable: Variable, texts: Texts) -> int | bool | str:
    """The value in a cell that was read from a variable."""
    if variable.type == "String":
        return texts[cell]
    if variable.type == "Boolean":
        return bool(cell)
    return cell % 2**64 if variable.fmi_type == "UInt64" else cell


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
    instance: int
    sizes: Mapping[int, int]
    ready: Callable[[], Status]
    component: RawComponent | None = None
    enter: Callable[[], Status] = lambda: 0
    settle: Callable[[], Status] = lambda: 0


class _Part:
    """Variables of one type: ``buffer[places[i]]`` is the value of the wanted ``members[i]``."""

    def __init__(
        self, variables: Sequence[Variable], members: Sequence[int], caller: Caller
    ) -> None:
        name, self.layout = caller.functions(variables[0])
        self.get_name, self.set_name = (f"{caller.prefix}{what}{name}" for what in ("Get", "Set"))
        located = [locate(v.value_reference) for v in variables]
        arrays = list(dict.fromkeys(reference for reference, _ in located))
        ends = np.cumsum([0, *(caller.sizes.get(a, 1) for a in arrays)])
        starts = dict(zip(arrays, ends.tolist(), strict=False))
        self.references = np.array(arrays, dtype=np.uint32)
        self.places = np.array([starts[a] + k for a, k in located], dtype=np.uint32)
        self.members = np.array(members, dtype=np.uint32)
        self.buffer = np.zeros(int(ends[-1]), dtype=self.layout.dtype)
        self.partial = len(set(located)) < len(self.buffer)
        self.discrete = variables[0].variability != "continuous"
        self.truth = variables[0].type == "Boolean"
        self._sized = caller.component is not None
        self._caller = caller

    def get(self) -> Status:
        return self._move(self.get_name)

    def set(self) -> Status:
        return self._move(self.set_name)

    def _move(self, name: str) -> Status:
        c = self._caller
        instance = c.component.instance if c.component is not None else c.instance
        arguments = (self.references.ctypes.data, len(self.references), self.buffer.ctypes.data)
        if self._sized:
            return _SIZED_TRANSFER(c.address(name))(instance, *arguments, len(self.buffer))
        return _TRANSFER(c.address(name))(instance, *arguments)

    def cells(self, texts: Texts) -> np.ndarray:
        found = self.buffer[self.places]
        if self.layout is Layout.TEXT:
            read = (ctypes.string_at(p) if p else b"" for p in found.tolist())
            return np.array([texts.place(text) for text in read], dtype=np.int64)
        return (found != 0 if self.truth else found).astype(np.int64)

    def put(self, cells: np.ndarray, taken: Sequence[Taken], texts: Texts) -> bool:
        """Put these cells into the buffer; whether they are others than before."""
        before = self._comparable()
        for place, cell, t in zip(self.places, cells.tolist(), taken, strict=True):
            if self.layout in (Layout.F32, Layout.F64):
                whole = cell % 2**64 if t.large else cell
                self.buffer[place] = t.factor * float(whole) + t.offset
            elif self.layout is Layout.TEXT:
                self.buffer[place] = texts.pointer(cell)
            else:
                self.buffer[place] = np.int64(cell).astype(self.buffer.dtype)
        return before != self._comparable()

    def _comparable(self) -> list:
        found = self.buffer[self.places].tolist()
        if self.layout is Layout.TEXT:
            return [ctypes.string_at(p) if p else b"" for p in found]
        return found

    @property
    def raw(self) -> _RawPart:
        address = self._caller.address
        return _RawPart(
            get=address(self.get_name),
            set=address(self.set_name),
            references=self.references.ctypes.data,
            places=self.places.ctypes.data,
            members=self.members.ctypes.data,
            buffer=self.buffer.ctypes.data,
            reference_count=len(self.references),
            value_count=len(self.buffer),
            count=len(self.places),
            layout=self.layout.number,
            sized=self._sized,
            partial=self.partial,
            discrete=self.discrete,
            truth=self.truth,
        )


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
        self.taken, self.texts = tuple(taken), texts
        self._caller, self._changed = caller, changed
        kinds: dict[tuple[bool, str], list[int]] = {}
        for k, v in enumerate(variables):
            kinds.setdefault((v.variability != "continuous", v.fmi_type), []).append(k)
        self._parts = tuple(
            _Part([variables[k] for k in members], members, caller)
            for _, members in sorted(kinds.items())  # those set in event mode are the last
        )
        self._raw_parts = (_RawPart * len(self._parts))(*(part.raw for part in self._parts))
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
        """Read all into `cells` (int64)."""
        worst = self._caller.ready()
        if worst > WARNING:
            return worst
        for n, part in enumerate(self._parts):
            self._raw.failed = n
            status = part.get()
            if status > WARNING:
                return status
            worst = max(worst, status)
            found = part.cells(self.texts)
            if self._changed is not None and (found != cells[part.members]).any():
                self._changed[0] = 0.0
            cells[part.members] = found
        return worst

    def set(self, cells: np.ndarray) -> Status:
        """Set all from `cells` (int64); DOES_NOT_FIT if one is none of a variable's type."""
        worst, entered, c = 0, False, self._caller.component
        events = c is not None and c.has_events and c.stepping and c.ended == np.inf
        for n, part in enumerate(self._parts):
            self._raw.failed = n
            look = bool(events and part.discrete)
            status = part.get() if part.partial or look else 0
            if status > WARNING:
                return status
            members = part.members.tolist()
            taken = [self.taken[m] for m in members]
            given = cells[[t.source for t in taken]]
            if part.layout is not Layout.TEXT:
                for m, cell, t in zip(members, given.tolist(), taken, strict=True):
                    if not t.low <= cell <= t.high:
                        self._raw.failed = m
                        return DOES_NOT_FIT
            changed = part.put(given, taken, self.texts)
            if look and not changed:
                continue
            if look and not entered:
                status = self._caller.enter()
                if status > WARNING:
                    return status
                entered = True
            status = part.set()
            if status > WARNING:
                return status
            worst = max(worst, status)
        return max(worst, self._caller.settle()) if entered else worst
