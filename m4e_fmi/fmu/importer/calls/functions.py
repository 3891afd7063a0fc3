"""C functions of FMI 2.0 and 3.0 with Python arguments: each answers with its status.

A subclass per version says everything that differs in arguments. `call` performs the calls: the
master raises where a status is an error, validation writes each call down and judges its status.
"""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.runtime.library import library

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
REALS = ctypes.POINTER(ctypes.c_double)

Status = int


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


class Invoke(Protocol):
    """Calls a function of one instance, by its name in FMI 2.0 without prefix."""

    def __call__(self, function: str, *arguments: object, note: str = "") -> Status:
        """Status of the call; `note` describes the arguments, for a journal."""
        ...


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


class Functions(ABC):
    """Functions of one instance; arrays of values are float64, contiguous, all elements."""

    PREFIX: ClassVar[str]
    BOOLEAN: ClassVar[type[ctypes.c_int | ctypes.c_bool]]
    BYTE: ClassVar[type[ctypes.c_char | ctypes.c_uint8]]
    """Of a serialised state."""

    def __init__(self, dll: ctypes.CDLL, call: Invoke) -> None:
        self._dll = dll
        self._call = call

    @abstractmethod
    def name(self, function: str) -> str:
        """Name of a function in the library, by that in FMI 2.0 without prefix."""

    @abstractmethod
    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> Status:
        """Tell times [s] and relative tolerance; None: none is told."""

    @abstractmethod
    def enter_initialization(self) -> Status:
        """Enter initialization mode, after `setup`."""

    @abstractmethod
    def do_step(self, time: float, size: float, final: int) -> Status:
        """Step from `time` by `size` [s]; `final` if nothing before it is ever restored."""

    @abstractmethod
    def last_successful_time(self) -> tuple[Status, float]:
        """Time [s] up to which the step could be made that has just been discarded."""

    @abstractmethod
    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        """One event iteration in event mode; True if another is needed."""

    @abstractmethod
    def arrays(self, keys: Sequence[int], sizes: Mapping[int, int]) -> Arrays:
        """The arrays that are moved for elements with these keys; sizes by value reference."""

    @abstractmethod
    def get_reals(self, arrays: Arrays, values: np.ndarray) -> Status:
        """Read all elements into `values` (n_elements,), in the variables' units."""

    @abstractmethod
    def set_reals(self, arrays: Arrays, values: np.ndarray, note: str = "") -> Status:
        """Set all elements from `values` (n_elements,), in the variables' units."""

    @abstractmethod
    def directional_derivative(
        self, unknowns: Arrays, knowns: Arrays, seed: np.ndarray, found: np.ndarray
    ) -> Status:
        """Write the change of the unknowns for a change of the knowns.

        `found` (n_unknowns,) and `seed` (n_knowns,) are in the variables' units.
        """

    @abstractmethod
    def output_derivatives(self, outputs: Arrays, order: int, found: np.ndarray) -> Status:
        """Time derivatives of an order of the outputs, into `found` (n_elements,), in SI."""

    def state_bytes(self, state: ctypes.c_void_p) -> tuple[Status, bytes]:
        """The FMU's bytes for a saved state, for another process; empty where that fails."""
        size = ctypes.c_size_t()
        status = self._call("SerializedFMUstateSize", state, ctypes.byref(size))
        if status > WARNING:
            return status, b""
        room = (self.BYTE * size.value)()
        note = f"{size.value} bytes"
        status = self._call("SerializeFMUstate", state, room, size.value, note=note)
        return status, bytes(room)

    def state_from(self, data: bytes, state: ctypes.c_void_p) -> Status:
        """Make a saved state at `state` from the FMU's bytes for it."""
        room = (self.BYTE * len(data)).from_buffer_copy(data)
        note = f"{len(data)} bytes"
        arguments = room, len(data), ctypes.byref(state)
        return self._call("DeSerializeFMUstate", *arguments, note=note)


def references_of(arrays: Arrays) -> ctypes.Array[ctypes.c_uint]:
    """The value references, as C functions take them."""
    return (ctypes.c_uint * len(arrays.references))(*arrays.references)


def pointer_to(values: np.ndarray) -> object:
    """A pointer to `values` (float64, contiguous), scalar or of any shape, in any units."""
    return values.ctypes.data_as(REALS)
