"""One instance of an FMU, whatever its version of FMI is; functions have the names of FMI 2.0.

`call` answers with the status, `do` raises where that is more than a warning; validation has both
write a journal before the call. Value references are the keys of `elements`.
"""

from __future__ import annotations

import ctypes
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NoReturn

import numpy as np

from m4e_fmi.fmu.importer.calls.access import (
    Access,
    Arrays,
    RawComponent,
    Taken,
    Texts,
    TypedPart,
    Value,
    address_of,
    cell_of,
    guarded,
    restored,
    runtime_function,
    value_in,
)
from m4e_fmi.fmu.importer.messages import WARNING, Messages, Status
from m4e_fmi.fmu.importer.reading import Variable

EARLY, RESTLESS = 16, 17
"""Further answers to a step, of the runtime's fmus.h: an event within it, the simulation was
to end before it, events without end."""

NEAR = 1.5e-9
"""Seconds; communication points are whole nanoseconds."""

CFunction = Callable[..., Any]
"""A function of a shared library."""
Failed = Callable[[Status, str], NoReturn]
"""Called with a status above Warning, and FMI 2.0's name of the function."""

INT, POINTER, TEXT = ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p
NUMBER, COUNT = ctypes.c_double, ctypes.c_size_t
Signature = tuple[type | None, ...]
"""Type of a C function's result, and those of its arguments."""
_SAVE_OR_RESTORE = ctypes.CFUNCTYPE(INT, POINTER, POINTER)


@dataclass(frozen=True)
class Loaded:
    """An FMU's `library`, in which the names of FMI's functions begin with `prefix`.

    `guid` is the one in its description, `folder` where it is unpacked.
    """

    library: ctypes.CDLL
    prefix: str
    guid: str
    folder: Path


@dataclass(frozen=True)
class RawCall:
    """A C function with FMI 2.0's arguments: its address, that of its component, references."""

    function: int
    component: int
    references: np.ndarray


@dataclass(frozen=True)
class SerializedState:
    """A state of an FMU for another process: the FMU's bytes, and its record of events.

    `events` are times [s], infinite without an event, and a number of events: the same values
    that a saved state has in this process.
    """

    data: bytes
    events: tuple[float, ...]


class Standard(ABC):
    """One instance of the FMU that is `loaded`, with its `variables` by name.

    `component` is the FMU's handle of the instance; None without an instance, or if it may not be
    called any more. `events` is its record of events. `failed` raises for statuses above
    Warning; functions that return a status leave that to their caller. `sizes` are the numbers
    of elements of arrays by value reference, `last_call` is the last call as passed to `journal`.
    """

    VERSION: ClassVar[int]
    SIGNATURES: ClassVar[Mapping[str, Signature]]
    """Functions that the master calls: all FMUs for co-simulation have them."""
    BYTE: ClassVar[type[ctypes.c_char | ctypes.c_uint8]]
    """Of a serialised state."""
    SIZED: ClassVar[bool] = False
    """True if functions take the number of values beside that of references."""

    def __init__(
        self,
        loaded: Loaded,
        variables: Mapping[str, Variable],
        failed: Failed,
        *,
        sizes: Mapping[int, int] | None = None,
        journal: Callable[[str], None] | None = None,
    ) -> None:
        self._loaded = loaded
        self._variables = variables
        self._failed, self._journal = failed, journal
        self.sizes = sizes or {}
        self.component: int | None = None
        self.events = RawComponent(next_event=math.inf, ended=math.inf, goes_on=True)
        self.last_call = ""
        self._accesses: dict[tuple[str, ...], Access] = {}
        self._texts = Texts()

    # ---- the life of an instance ----

    @abstractmethod
    def instantiate(
        self,
        name: str,
        messages: Messages,
        *,
        exchange: bool = False,
        events: bool = False,
    ) -> None:
        """Make the instance, in model exchange if `exchange`; RuntimeError if the FMU makes none.

        With event mode in co-simulation if `events` (FMI 3.0), or without where the FMU refuses it.
        """

    @abstractmethod
    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> None:
        """Tell the experiment: times [s], relative tolerance (None: the FMU's own)."""

    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        self.do("EnterInitializationMode")

    def exit_initialization(self) -> None:
        """Exit initialization mode, ready for the first step."""
        self.do("ExitInitializationMode")

    def terminate(self) -> Status:
        """Terminate the simulation."""
        return self.call("Terminate")

    def free(self) -> None:
        """Free the instance."""
        self.call("FreeInstance")
        self.component = None

    # ---- values by name ----

    def set_values(self, values: Mapping[str, Value]) -> None:
        """Set variables of any type by name, one at least."""
        access, variables = self.access(values), self.variables(values)
        pairs = zip(values.values(), variables, strict=True)
        cells = [cell_of(value, variable, self._texts) for value, variable in pairs]
        status = access.set(np.array(cells, dtype=np.int64))
        self.check(status, access.function(sets=True))

    @abstractmethod
    def layout(self, variable: Variable) -> tuple[str, str]:
        """The end of its functions' names, as Real of fmi2GetReal, and how values lie in memory."""

    @abstractmethod
    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        """The C function that does what `function` of FMI 2.0 does, for the variables `names`."""

    def typed(
        self,
        names: Sequence[str],
        texts: Texts,
        *,
        taken: Sequence[Taken] = (),
        changed: np.ndarray | None = None,
    ) -> Access:
        """Access to variables that are not Real, or take the values of such.

        `changed` (1,) [1] becomes 0 where a value changes in reading.
        """
        variables, kinds = self.variables(names), dict[tuple[bool, str], list[int]]()
        for k, v in enumerate(variables):  # by type, and those last that are set in event mode
            kinds.setdefault((v.variability != "continuous", v.fmi_type), []).append(k)
        return Access(
            names,
            [
                self._part([variables[k] for k in kinds[kind]], kinds[kind])
                for kind in sorted(kinds)
            ],
            texts,
            instance=self.component,
            component=self.events if self.SIZED else None,
            ready=self.ready,
            taken=taken,
            changed=changed,
        )

    def access(self, names: Iterable[str]) -> Access:
        """Access to variables that are set or read on their own, made once."""
        key = tuple(names)
        if key not in self._accesses:
            self._accesses[key] = self.typed(key, self._texts)
        return self._accesses[key]

    def _part(self, variables: Sequence[Variable], members: Sequence[int]) -> TypedPart:
        function, layout = self.layout(variables[0])
        return TypedPart(
            variables,
            members,
            function=function,
            layout=layout,
            address=self.address,
            sizes=self.sizes,
            sized=self.SIZED,
        )

    def ready(self) -> Status:
        """Do what values need before they are read."""
        return 0

    def values(self, names: Sequence[str]) -> list[Value]:
        """The present values of variables; an item of an enumeration by number."""
        if not names:
            return []
        self.check(self.ready(), "fmi2ExitInitializationMode")
        access, cells = self.access(names), np.zeros(len(names), dtype=np.int64)
        self.check(access.get(cells), access.function(sets=False))
        reals = cells.view(np.float64)
        return [
            float(reals[k]) if v.type == "Real" else value_in(int(cells[k]), v, self._texts)
            for k, v in enumerate(self.variables(names))
        ]

    def text(self, variable: Variable) -> str:
        """The present value of a String, empty if it cannot be had."""
        reference, found = (ctypes.c_uint * 1)(variable.value_reference), (ctypes.c_char_p * 1)()
        status = self.call("GetString", reference, 1, found, *([1] if self.SIZED else []))
        text = found[0] if status <= WARNING else None
        return (text or b"").decode("utf-8", errors="replace").strip()

    # ---- Reals by value reference; statuses are answered ----

    def arrays(self, keys: Sequence[int]) -> Arrays:
        """The arrays that are moved for elements with these keys."""
        return Arrays.of(keys, self.sizes)

    def get_reals(self, arrays: Arrays, values: np.ndarray) -> Status:
        """Read all elements into `values` (n_elements,), in the variables' units."""
        note = f"{len(values)} values"
        return self.call("GetReal", *references_of(arrays), *self._values(values), note=note)

    def set_reals(self, arrays: Arrays, values: np.ndarray) -> Status:
        """Set all elements from `values` (n_elements,), in the variables' units."""
        return self.call("SetReal", *references_of(arrays), *self._values(values))

    def sensitivity(
        self, unknowns: Arrays, knowns: Arrays, seed: np.ndarray, found: np.ndarray
    ) -> Status:
        """Write the change of the unknowns for a change of the knowns.

        `found` (n_unknowns,) and `seed` (n_knowns,) are in the variables' units.
        """
        function = "GetDirectionalDerivative"
        variables = *references_of(unknowns), *references_of(knowns)
        values = *self._values(seed), *self._values(found)
        return self.call(function, *variables, *values, note=f"{len(found)} values")

    def _values(self, values: np.ndarray) -> tuple[object, ...]:
        return (pointer_to(values), len(values)) if self.SIZED else (pointer_to(values),)

    # ---- steps ----

    def step_beginner(self) -> int:
        """The C function that asks for a step of an FMU in a worker, ``(t, h, 1)`` [s]."""
        return runtime_function(f"m4e_remote_begin_{self.VERSION}")

    @abstractmethod
    def do_step(self, time: float, size: float) -> Status:
        """A plain step from `time` by `size` [s], which may be undone."""

    def wants_end(self) -> bool:
        """True if the FMU discarded the last step because it asks for the end of the simulation."""
        return False  # only FMI 2.0 says so by a status

    @abstractmethod
    def reached(self) -> float | None:
        """Time [s] up to which the step could be made that has just been discarded."""

    @abstractmethod
    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        """One event iteration in event mode; True if another is needed."""

    # ---- states and derivatives, as far as the FMU's description declares them ----

    @abstractmethod
    def slot(self) -> ctypes.c_void_p:
        """A new place for a state of the FMU, to stay where it is."""

    def save(self, slot: ctypes.c_void_p) -> Status:
        """Keep the FMU's state in a slot, instead of the one that is there."""
        return self._at_state("fmi2GetFMUstate", ctypes.addressof(slot))

    def restore(self, slot: ctypes.c_void_p) -> Status:
        """Bring the FMU back to the state in a slot, which stays there."""
        return self._at_state("fmi2SetFMUstate", slot.value)

    def _at_state(self, function: str, place: int | None) -> Status:
        raw = self.raw(function)
        return guarded(_SAVE_OR_RESTORE, raw.function)(raw.component, place)

    @abstractmethod
    def handle(self, slot: ctypes.c_void_p) -> ctypes.c_void_p:
        """The FMU's pointer of the state in a slot; null if the slot is empty."""

    def free_state(self, slot: ctypes.c_void_p) -> None:
        """Free the state in a slot, if there is one."""
        if handle := self.handle(slot):
            self.call("FreeFMUstate", ctypes.byref(handle))

    def state_size(self, handle: ctypes.c_void_p) -> int:
        """The number of bytes that the FMU needs for a state."""
        size = ctypes.c_size_t()
        self.do("SerializedFMUstateSize", handle, ctypes.byref(size))
        return size.value

    def state_bytes(self, handle: ctypes.c_void_p) -> bytes:
        """The FMU's bytes for a state, for another process."""
        size = self.state_size(handle)
        room = (self.BYTE * size)()
        self.do("SerializeFMUstate", handle, room, size, note=f"{size} bytes")
        return bytes(room)

    def state_of(self, data: bytes) -> ctypes.c_void_p:
        """A state in this process from the FMU's bytes for it."""
        handle, room = ctypes.c_void_p(), (self.BYTE * len(data)).from_buffer_copy(data)
        note = f"{len(data)} bytes"
        self.do("DeSerializeFMUstate", room, len(data), ctypes.byref(handle), note=note)
        return handle

    @abstractmethod
    def serialized(self, slot: ctypes.c_void_p) -> SerializedState:
        """The state in a slot, for another process."""

    @abstractmethod
    def deserialize(self, slot: ctypes.c_void_p, state: SerializedState) -> None:
        """Put a state of another process into an empty slot."""

    def directional_derivative(self, output: Variable, known: Variable) -> float:
        """∂output/∂known at the present instant."""
        z, v = (self.arrays([x.value_reference]) for x in (output, known))
        seed, found = np.zeros(v.count), np.zeros(z.count)
        seed[v.places[0]] = 1.0
        status = self.sensitivity(z, v, seed, found)
        self.check(status, "fmi2GetDirectionalDerivative")
        return float(found[z.places[0]])

    # ---- functions of the library ----

    def function(self, function: str) -> CFunction:
        """The function of the library that FMI 2.0 calls `function`."""
        name = self.name(function)
        found = getattr(self._loaded.library, f"{self._loaded.prefix}{name}")
        if found.argtypes is None and name in self.SIGNATURES:
            found.restype, *found.argtypes = self.SIGNATURES[name]
        return found

    @abstractmethod
    def name(self, function: str) -> str:
        """The name in this version of FMI of a function of FMI 2.0."""

    def call(self, function: str, *arguments: object, note: str = "") -> Status:
        """Status of a function of this instance, named as in FMI 2.0 without prefix.

        `note` describes the arguments, for the journal.
        """
        self.last_call = f"{self.name(f'fmi2{function}')}({note})"
        if self._journal:
            self._journal(self.last_call)
        return restored(self.function(f"fmi2{function}")(self.component, *arguments))

    def do(self, function: str, *arguments: object, note: str = "") -> None:
        """The same, but raise if the status is above Warning."""
        self.check(self.call(function, *arguments, note=note), f"fmi2{function}")

    def check(self, status: Status, function: str) -> None:
        """Raise if the status of `function`, named as in FMI 2.0, is not OK or Warning."""
        if not 0 <= status <= WARNING:
            self._failed(status, function)

    def address(self, function: str) -> int:
        """The address of a function, named as in FMI 2.0."""
        return address_of(self.function(function))

    def variables(self, names: Iterable[str]) -> list[Variable]:
        """The variables of these names."""
        return [self._variables[name] for name in names]


def references_of(arrays: Arrays) -> tuple[object, int]:
    """The value references as C functions take them, and how many there are."""
    count = len(arrays.references)
    return (ctypes.c_uint * count)(*arrays.references), count


def pointer_to(values: np.ndarray) -> object:
    """A pointer to `values` (n,), contiguous, in any units; they are kept as it is."""
    kind = ctypes.c_double if values.dtype == np.float64 else ctypes.c_uint
    return values.ctypes.data_as(ctypes.POINTER(kind))
