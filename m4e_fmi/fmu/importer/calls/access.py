"""Variables of one FMU that are read and set together, of any type, elements of arrays among them.

The runtime's fmus.h does the work; its structures are here. Each value lies in a cell of 64 bits:
a float64 where all variables are Reals that are moved as they are, else an int64. A text is kept
once, so that a number stands for it. FMI 3.0 moves whole arrays: the buffer of a part, which has
the variables of one type, holds all elements of all its arrays, and those that are not wanted keep
the values that they have.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_char_p, c_double, c_int, c_int32, c_int64, c_uint64, c_void_p
from dataclasses import dataclass
from typing import Any
from weakref import finalize

import numpy as np

from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import WARNING, Status
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.runtime.library import library

Value = float | int | bool | str
DOES_NOT_FIT = -2
LOWEST, HIGHEST = -(2**63), 2**63 - 1
_MOVE = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p)


def guarded(prototype: type, address: int) -> Callable[..., Status]:
    """The C function of an FMU at an address; each call ends in the default environment."""
    function = prototype(address)
    function.errcheck = lambda status, *_: restored(status)
    return function


def restored(status: Status) -> Status:
    """The status of a call of an FMU, with the default floating-point environment again.

    Python goes on in the same thread: with values at the start, and after the last call.
    """
    library().m4e_restore_environment()
    return status


def runtime_function(name: str) -> int:
    """The address of a function of the C library."""
    return address_of(getattr(library(), name))


def address_of(function: Any) -> int:
    """The address of a C function."""
    address = ctypes.cast(function, c_void_p).value
    assert address
    return address


# ---- variables as they lie in memory ----


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


LAYOUTS: dict[str, tuple[int, str | type]] = {
    "I8": (0, "i1"),
    "U8": (1, "u1"),
    "I16": (2, "i2"),
    "U16": (3, "u2"),
    "I32": (4, "i4"),
    "U32": (5, "u4"),
    "I64": (6, "i8"),
    "U64": (7, "u8"),
    "F32": (8, "f4"),
    "F64": (9, "f8"),
    "TEXT": (10, np.uintp),
}
"""How values lie in memory: name, number in fmus.h, and type of NumPy."""


class RawComponent(ctypes.Structure):
    """`m4e_component_3`: the record of an FMI 3.0 instance, and the events of any instance.

    Times are in seconds: `next_event` is announced, `reached` is that of the last step, `ended` is
    that of the end that the FMU asked for; infinite without one. `goes_on` if it steps on after an
    event within a step; `interruptions` counts such events, `handled` the times in event mode.
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


class _RawPart(ctypes.Structure):
    """`m4e_part`."""

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


class TypedPart:
    """Variables of one type: ``buffer[places[i]]`` is the value of the wanted ``members[i]``.

    `function` is the name by which `address` finds their functions, without Get and Set, `layout`
    that of their values. `sizes` are the numbers of elements of arrays by value reference; in FMI
    3.0 functions are `sized`.
    """

    def __init__(
        self,
        variables: Sequence[Variable],
        members: Sequence[int],
        *,
        function: str,
        layout: str,
        address: Callable[[str], int],
        sizes: Mapping[int, int],
        sized: bool,
    ) -> None:
        self.get_name, self.set_name = (f"fmi2{verb}{function}" for verb in ("Get", "Set"))
        keys = [v.value_reference for v in variables]
        arrays = Arrays.of(keys, sizes)
        numbers = [np.array(one, np.uint32) for one in (arrays.references, arrays.places, members)]
        number, kind = LAYOUTS[layout]
        buffer = np.zeros(arrays.count, dtype=kind)
        self._holds = numbers, buffer
        references, places, wanted = (one.ctypes.data for one in numbers)
        self.raw = _RawPart(
            get=address(self.get_name),
            set=address(self.set_name),
            references=references,
            places=places,
            members=wanted,
            buffer=buffer.ctypes.data,
            reference_count=len(arrays.references),
            value_count=arrays.count,
            count=len(arrays.places),
            layout=number,
            sized=sized,
            partial=len(set(keys)) < arrays.count,
            discrete=variables[0].variability != "continuous",
            truth=variables[0].type == "Boolean",
        )


# ---- cells ----


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


class _RawAccess(ctypes.Structure):
    """`m4e_access`."""

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
        self._library = found = library()
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


def cell_of(value: Value, variable: Variable, texts: Texts) -> int:
    """The cell from which a variable is set to a value."""
    if variable.type == "String":
        return texts.place(str(value).encode("utf-8"))
    if variable.type == "Real":
        return int(np.float64(value).view(np.int64))
    return (int(value) - LOWEST) % 2**64 + LOWEST


def value_in(cell: int, variable: Variable, texts: Texts) -> int | bool | str:
    """The value in a cell that was read from a variable that is not Real."""
    if variable.type == "String":
        return texts[cell]
    if variable.type == "Boolean":
        return bool(cell)
    return cell % 2**64 if variable.fmi_type == "UInt64" else cell


class Access:
    """Some variables of one FMU: `get` reads their values into cells, `set` sets them from cells.

    They are read into consecutive cells; `taken` defines the cells for setting them, without it
    Reals are set from consecutive cells of float64. If a cell changes in reading, `changed`
    (float64, one element) becomes 0. `component` is the record of an `instance` of FMI 3.0,
    `ready` is called before values are read.
    """

    def __init__(
        self,
        names: Sequence[str],
        parts: Sequence[TypedPart],
        texts: Texts,
        *,
        instance: int | None,
        component: RawComponent | None,
        ready: Callable[[], Status],
        taken: Sequence[Taken],
        changed: np.ndarray | None,
    ) -> None:
        self.names = tuple(names)
        self.taken = tuple(taken)
        self._ready, self._parts, self._holds = ready, parts, (texts, changed, component)
        functions = ("m4e_get_typed", "m4e_set_typed")
        self._get, self._set = (guarded(_MOVE, runtime_function(name)) for name in functions)
        self._raw_parts = (_RawPart * len(parts))(*(part.raw for part in parts))
        self._raw_taken = (_RawTaken * len(self.taken))(
            *(_RawTaken(t.low, t.high, t.factor, t.offset, t.source, t.large) for t in self.taken)
        )
        self._raw = _RawAccess(
            instance=instance,
            component=None if component is None else ctypes.addressof(component),
            parts=ctypes.addressof(self._raw_parts),
            part_count=len(parts),
            texts=texts.address,
            taken=ctypes.addressof(self._raw_taken) if self.taken else None,
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

    def function(self, *, sets: bool) -> str:
        """The function that failed last, in setting values if this `sets` them."""
        part = self._parts[self.failed]
        return part.set_name if sets else part.get_name

    def get(self, cells: np.ndarray) -> Status:
        """Read all into `cells` (n_cells,), int64, in the variables' units."""
        status = self._ready()
        return status if status > WARNING else self._get(self.address, cells.ctypes.data)

    def set(self, cells: np.ndarray) -> Status:
        """Set all from `cells` (n_cells,), int64, in the variables' units.

        DOES_NOT_FIT if the type of a variable cannot hold its value.
        """
        return self._set(self.address, cells.ctypes.data)
