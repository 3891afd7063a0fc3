"""Interface of one instance of an FMU, whatever its version of FMI is; functions as in FMI 2.0."""

from __future__ import annotations

import ctypes
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol

import numpy as np

from m4e_fmi.fmu.importer.calls.functions import WARNING, Status, restored
from m4e_fmi.fmu.importer.calls.parts import Caller
from m4e_fmi.fmu.importer.calls.texts import Texts
from m4e_fmi.fmu.importer.calls.typed import Access, Taken
from m4e_fmi.fmu.importer.calls.typed import function as runtime_function
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import Description, Variable

EARLY, RESTLESS = 16, 17
"""Further answers to a step, of the runtime's component_3.h: an event within it, the simulation was
to end before it, events without end."""

NEAR = 1.5e-9
"""Seconds; communication points are whole nanoseconds."""

Call = Callable[[], Status]
Value = float | int | bool | str
FmpyInstance = Any
"""FMPy's object for an instance of any version, whose functions it makes as it loads them."""
CFunction = Callable[..., Any]
"""A function of a shared library."""
Failed = Callable[[Status, str], NoReturn]
"""Called with a status above Warning, and FMI 2.0's name of the function."""


@dataclass(frozen=True)
class RawCall:
    """A C function with FMI 2.0's arguments: its address, that of its component, references."""

    function: int
    component: int
    references: np.ndarray


class Events(Protocol):
    """Events of an instance; times in seconds, infinite if there is none."""

    next_event: float
    """Time of the event that it has announced."""
    ended: float
    """Time at which it asked for the end of the simulation."""
    goes_on: int
    """True if it steps on after an event within a step."""
    interruptions: int
    """Number of events within steps after which it went on."""
    handled: int
    """Number of times that it was in event mode."""


@dataclass
class NoEvents:
    """The `Events` of FMI 1.0 and 2.0."""

    next_event: float = math.inf
    ended: float = math.inf
    goes_on: int = True
    interruptions: int = 0
    handled: int = 0


class Standard(ABC):
    """One instance of the loaded FMU whose functions FMPy has as `functions`.

    `component` is what the FMU calls the instance; None if there is none, or none that may be
    called any more. `events` is what it has told of events. `failed` raises for statuses above
    Warning; calls that answer with a status leave that to their caller.
    """

    def __init__(self, functions: FmpyInstance, description: Description, failed: Failed) -> None:
        self._fmpy = copy(functions)
        self._dll: ctypes.CDLL = functions.dll
        self._description = description
        self._failed = failed
        self.component: int | None = None
        self.events: Events = NoEvents()

    # ---- the life of an instance ----

    @abstractmethod
    def instantiate(self, name: str, messages: Messages) -> None:
        """Make the instance; any exception says that it cannot be made."""

    @abstractmethod
    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        """Tell the experiment: times [s], relative tolerance (None: the FMU's own)."""

    @abstractmethod
    def enter_initialization(self) -> None:
        """Enter initialization mode."""

    @abstractmethod
    def exit_initialization(self) -> None:
        """Exit initialization mode, ready for the first step."""

    def terminate(self) -> Status:
        """Terminate the simulation."""
        return self.call("Terminate")

    def free(self) -> None:
        """Free the instance."""
        self.call("FreeInstance")
        self.component = None

    # ---- values ----

    @abstractmethod
    def set_values(self, values: Mapping[str, Value]) -> None:
        """Set variables of any type by name."""

    @abstractmethod
    def text(self, variable: Variable) -> str:
        """The value of a String, empty if it cannot be had."""

    @abstractmethod
    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that reads Reals into `view` (n_names,), float64, in the variables' units."""

    @abstractmethod
    def setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that sets Reals from `view` (n_names,), float64, in the variables' units."""

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
        assert self.component
        return Access(self.variables(names), self._caller(), texts, taken=taken, changed=changed)

    @abstractmethod
    def _caller(self) -> Caller: ...

    # ---- steps ----

    @abstractmethod
    def stepper(self) -> Callable[[float, float, int], Status]:
        """The call ``(t, h, 1) -> status`` that steps from t to t + h [s], never to be undone."""

    def step_beginner(self) -> int:
        """The C function that asks for a step of an FMU in a worker, with `stepper`'s arguments."""
        return runtime_function(f"m4e_remote_begin_{self._description.version[0]}")

    def wants_end(self) -> bool:
        """True if the FMU discarded the last step because it asks for the end of the simulation."""
        return False

    @abstractmethod
    def reached(self) -> float | None:
        """Time [s] up to which the step could be made that has just been discarded."""

    @abstractmethod
    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        """The C function that does what `function` of FMI 2.0 does, for the variables `names`."""

    # ---- functions of the library ----

    @abstractmethod
    def function(self, function: str) -> CFunction:
        """The function of the library that FMI 2.0 calls `function`."""

    @abstractmethod
    def name(self, function: str) -> str:
        """The name in this version of FMI of a function of FMI 2.0."""

    def call(self, function: str, *arguments: object, note: str = "") -> Status:
        """Status of a function of this instance, named as in FMI 2.0 without prefix."""
        del note  # for those who keep a journal
        return restored(self.function(f"fmi2{function}")(self.component, *arguments))

    def check(self, status: Status, function: str) -> None:
        """Raise if the status of `function`, named as in FMI 2.0, is above Warning."""
        if status > WARNING:
            self._failed(status, function)

    def address(self, function: str) -> int:
        """The address of a function, named as in FMI 2.0."""
        address = ctypes.cast(self.function(function), ctypes.c_void_p).value  # pyright: ignore[reportArgumentType]  a C function
        assert address
        return address

    def variables(self, names: Sequence[str]) -> list[Variable]:
        """The variables of these names."""
        return [self._description.variables[name] for name in names]


@dataclass(frozen=True)
class SerializedState:
    """A state of an FMU for another process: the FMU's bytes, and the events told by then.

    `events` are times [s], infinite where there is none, and a number of events: those that a saved
    state has in this process.
    """

    data: bytes
    events: tuple[float, ...]


class Rollback(ABC):
    """Saved states and directional derivatives, of FMI 2.0 and 3.0.

    They are there as far as the FMU's description declares them.
    """

    @abstractmethod
    def slot(self) -> ctypes.c_void_p:
        """A new place for a state of the FMU, to stay where it is."""

    @abstractmethod
    def saver(self, slot: ctypes.c_void_p) -> Call:
        """A call that keeps the FMU's state in a slot, instead of the one that is there."""

    @abstractmethod
    def restorer(self, slot: ctypes.c_void_p) -> Call:
        """A call that brings the FMU back to the state in a slot, which stays there."""

    @abstractmethod
    def free_state(self, slot: ctypes.c_void_p) -> None:
        """Free the state in a slot, if there is one."""

    @abstractmethod
    def serialized(self, slot: ctypes.c_void_p) -> SerializedState:
        """The state in a slot, for another process."""

    @abstractmethod
    def deserialize(self, slot: ctypes.c_void_p, state: SerializedState) -> None:
        """Put a state of another process into an empty slot."""

    @abstractmethod
    def directional_derivative(self, output: Variable, known: Variable) -> float:
        """∂output/∂known at the present instant."""


def check_view(view: np.ndarray, *shape: int) -> None:
    """Assert that C code may have the address of `view`: float64, contiguous, of this shape.

    `view` has the shape of `shape`, in the variables' units.
    """
    assert view.dtype == np.float64
    assert view.flags.c_contiguous
    assert view.shape == shape
