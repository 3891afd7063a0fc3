"""Variables of an FMU that are not Real, or take values of such, read and set together.

Each value lies in a cell, an int64: see the runtime's typed.h, whose structures are here. `Access`
does in Python what m4e_get_typed and m4e_set_typed do in C.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_double, c_int32, c_int64, c_uint64, c_void_p
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from m4e_fmi.fmu.importer.calls.functions import WARNING, Status
from m4e_fmi.fmu.importer.calls.parts import Caller, Layout, Part, RawPart
from m4e_fmi.fmu.importer.calls.texts import Texts
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.runtime.library import library

DOES_NOT_FIT = -2
LOWEST, HIGHEST = -(2**63), 2**63 - 1


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


class _TypedPart:
    """Variables of one type, whose values are moved between the part's buffer and cells."""

    def __init__(
        self, variables: Sequence[Variable], members: Sequence[int], caller: Caller
    ) -> None:
        self.part = Part(variables, members, caller)
        self.members = self.part.members
        self.is_text = self.part.layout is Layout.TEXT
        self._is_real = self.part.layout in (Layout.F32, Layout.F64)
        self._truth = variables[0].type == "Boolean"
        self._sized = caller.component is not None

    def cells(self, texts: Texts) -> np.ndarray:
        """Cells (n_members,) of the values in the buffer."""
        found = self.part.buffer[self.part.places]
        if self.is_text:
            read = (ctypes.string_at(p) if p else b"" for p in found.tolist())
            return np.array([texts.place(text) for text in read], dtype=np.int64)
        return (found != 0 if self._truth else found).astype(np.int64)

    def put(self, cells: Sequence[int], taken: Sequence[Taken], texts: Texts) -> bool:
        """Put these cells into the buffer; True if they are others than before."""
        before, buffer = self._comparable(), self.part.buffer
        for place, cell, t in zip(self.part.places, cells, taken, strict=True):
            if self._is_real:
                whole = cell % 2**64 if t.large else cell
                buffer[place] = t.factor * float(whole) + t.offset
            elif self.is_text:
                buffer[place] = texts.pointer(cell)
            else:
                buffer[place] = np.int64(cell).astype(buffer.dtype)
        return before != self._comparable()

    def _comparable(self) -> list[object]:
        found = self.part.buffer[self.part.places].tolist()
        if self.is_text:
            return [ctypes.string_at(p) if p else b"" for p in found]
        return found

    @property
    def raw(self) -> _RawTypedPart:
        part = self.part
        return _RawTypedPart(
            **part.raw_fields,
            layout=part.layout.number,
            sized=self._sized,
            partial=part.partial,
            discrete=part.discrete,
            truth=self._truth,
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
            _TypedPart([variables[k] for k in members], members, caller)
            for _, members in sorted(kinds.items())  # those set in event mode are the last
        )
        self._raw_parts = (_RawTypedPart * len(self._parts))(*(part.raw for part in self._parts))
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
        part = self._parts[self.failed].part
        return part.set_name if self.taken else part.get_name

    def get(self, cells: np.ndarray) -> Status:
        """Read all into `cells` (n_cells,), int64, in the variables' units."""
        worst = self._caller.ready()
        if worst > WARNING:
            return worst
        for n, part in enumerate(self._parts):
            self._raw.failed = n
            status = part.part.get()
            if status > WARNING:
                return status
            worst = max(worst, status)
            found = part.cells(self.texts)
            if self._changed is not None and (found != cells[part.members]).any():
                self._changed[0] = 0.0
            cells[part.members] = found
        return worst

    def set(self, cells: np.ndarray) -> Status:
        """Set all from `cells` (n_cells,), int64, in the variables' units.

        DOES_NOT_FIT if the type of a variable cannot hold its value.
        """
        worst, entered, c = 0, False, self._caller.component
        events = c is not None and c.has_events and c.stepping and c.ended == np.inf
        for n, part in enumerate(self._parts):
            self._raw.failed = n
            look = bool(events and part.part.discrete)
            status = part.part.get() if part.part.partial or look else 0
            if status > WARNING:
                return status
            taken = [self.taken[m] for m in part.members.tolist()]
            given = cells[[t.source for t in taken]].tolist()
            if not self._all_fit(part, given):
                return DOES_NOT_FIT
            changed = part.put(given, taken, self.texts)
            if look and not changed:
                continue
            if look and not entered:
                status = self._caller.enter()
                if status > WARNING:
                    return status
                entered = True
            status = part.part.set()
            if status > WARNING:
                return status
            worst = max(worst, status)
        return max(worst, self._caller.settle()) if entered else worst

    def _all_fit(self, part: _TypedPart, given: Sequence[int]) -> bool:
        """True if cells are in the bounds of what takes them; `failed` is the first that is not."""
        for m, cell in zip(part.members.tolist(), given, strict=True):
            if not part.is_text and not self.taken[m].low <= cell <= self.taken[m].high:
                self._raw.failed = m
                return False
        return True
