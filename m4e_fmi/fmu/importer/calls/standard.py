"""What a version of FMI has to do for `Instance`."""

from __future__ import annotations

import ctypes
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol

import numpy as np

from m4e_fmi.fmu.importer.calls.texts import Texts
from m4e_fmi.fmu.importer.calls.typed import Access, Caller, Layout, Taken
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.importer.reading import Description, Variable

WARNING, DISCARD, ERROR, FATAL = 1, 2, 3, 4
EARLY, RESTLESS = 16, 17
"""Further answers to a step, of the runtime's component_3.h: an event within it, the simulation was
to end before it, events without end."""

NEAR = 1.5e-9
"""Seconds; communication points are whole nanoseconds."""

Status = int
Call = Callable[[], Status]
Value = float | int | bool | str
Failed = Callable[[Status, str], NoReturn]
"""Called with the status that is more than a warning, and FMI 2.0's name of the function."""


@dataclass(frozen=True)
class RawCall:
    """A C function with FMI 2.0's arguments: its address, that of its component, references."""

    function: int
    component: int
    references: np.ndarray


class Events(Protocol):
    """What an instance has told of events; times in seconds, infinite if there is none."""

    next_event: float
    """When it has announced an event."""
    ended: float
    """When it asked for the end of the simulation."""
    goes_on: int
    """Whether it steps on after an event within a step."""
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

    Functions are named as in FMI 2.0. `component` is what the FMU calls the instance; None if there
    is none, or none that may be called any more. `events` is what it has told of events. What is
    not implemented is never called: the FMU's description says that it cannot.
    """

    def __init__(self, functions: Any, description: Description, failed: Failed) -> None:
        self._functions = copy(functions)
        self._dll = functions.dll
        self._description = description
        self._failed = failed
        self.component: int | None = None
        self.events: Events = NoEvents()

    @abstractmethod
    def instantiate(self, name: str, messages: Messages) -> None:
        """Make the instance; any exception, or no component, says that it cannot be made."""

    @abstractmethod
    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        """Tell the experiment: times [s], relative tolerance (None: the FMU's own)."""

    @abstractmethod
    def enter_initialization(self) -> None: ...

    @abstractmethod
    def exit_initialization(self) -> None: ...

    @abstractmethod
    def terminate(self) -> Status: ...

    @abstractmethod
    def free(self) -> None: ...

    @abstractmethod
    def set_values(self, values: Mapping[str, Value]) -> None:
        """Set variables of any type by name."""

    @abstractmethod
    def text(self, variable: Variable) -> str:
        """The value of a String, empty if it cannot be had."""

    @abstractmethod
    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that reads Reals into `view` (float64, contiguous)."""

    @abstractmethod
    def setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that sets Reals from `view`."""

    def typed(
        self,
        names: Sequence[str],
        texts: Texts,
        *,
        taken: Sequence[Taken] = (),
        changed: np.ndarray | None = None,
    ) -> Access:
        """Access to variables that are not Real, or take the values of such."""
        return Access(self.variables(names), self._caller(), texts, taken=taken, changed=changed)

    @abstractmethod
    def _caller(self) -> Caller: ...

    @abstractmethod
    def layout(self, variable: Variable) -> tuple[str, Layout]:
        """The type in the name of a variable's functions, and how its values lie in memory."""

    @abstractmethod
    def stepper(self) -> Callable[[float, float, int], Status]:
        """The call ``(t, h, 1) -> status`` that steps from t to t + h [s], never to be undone."""

    @abstractmethod
    def raw(self, function: str, names: Sequence[str] = ()) -> RawCall:
        """The C function that does what `function` of FMI 2.0 does, for the variables `names`."""

    def derivative_setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that sets the first and the second derivative of one input after the other."""
        raise NotImplementedError

    def slot(self) -> ctypes.c_void_p:
        """A new place for a state of the FMU, to stay where it is."""
        return ctypes.c_void_p()

    def saver(self, slot: ctypes.c_void_p) -> Call:
        """A call that keeps the FMU's state in a slot, instead of the one that is there."""
        raise NotImplementedError

    def restorer(self, slot: ctypes.c_void_p) -> Call:
        """A call that brings the FMU back to the state in a slot, which stays there."""
        raise NotImplementedError

    def free_state(self, slot: ctypes.c_void_p) -> None:
        """Free the state in a slot, if there is one."""
        raise NotImplementedError

    def directional_derivative(self, output: Variable, known: Variable) -> float:
        """∂output/∂known at the present instant."""
        raise NotImplementedError

    def wants_end(self) -> bool:
        """True if the FMU discarded the last step because it asks for the end of the simulation."""
        return False

    @abstractmethod
    def reached(self) -> float | None:
        """Time [s] up to which the step could be made that has just been discarded."""

    def must(self, function: str, *arguments: Any) -> None:
        """Call a function on the instance; what is more than a warning has `failed`."""
        status = self.function(function)(self.component, *arguments)
        if status > WARNING:
            self._failed(status, function)

    @abstractmethod
    def function(self, function: str) -> Any:
        """The function of the library that FMI 2.0 calls `function`."""

    @abstractmethod
    def name(self, function: str) -> str:
        """What this version of FMI calls a function of FMI 2.0."""

    def address(self, function: str) -> int:
        address = ctypes.cast(self.function(function), ctypes.c_void_p).value
        assert address
        return address

    def variables(self, names: Sequence[str]) -> list[Variable]:
        return [self._description.variables[name] for name in names]


def check_view(view: np.ndarray, *shape: int) -> None:
    """Whether C code may have the address of `view`."""
    assert view.dtype == np.float64
    assert view.flags.c_contiguous
    assert view.shape == shape
