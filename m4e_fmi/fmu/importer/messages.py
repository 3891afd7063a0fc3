"""Messages that FMUs log through FMI's logger, sorted by instance.

FMPy's native proxy formats the messages (their arguments are variadic, which ctypes cannot take),
but knows one logger for the whole process. The one here finds the instance by its FMI component
environment, in FMI 1.0 and where an FMU has lost that by its name, and leaves messages of other
instances to FMPy. FMI 3.0's messages are whole texts, and go to the instance itself.
"""

from __future__ import annotations

import ctypes
import itertools
import weakref
from collections import deque
from collections.abc import Callable
from typing import Any

from fmpy import calloc, fmi1, fmi2, free
from fmpy.logging import addLoggerProxy

Status = int
OK, WARNING, DISCARD, ERROR, FATAL, PENDING, NO_STATUS = range(7)
"""Statuses of FMI; the last stands for a number that is no status of FMI."""
STATUS = {
    0: "OK",
    1: "Warning",
    2: "Discard",
    3: "Error",
    4: "Fatal",
    NO_STATUS: "no status of FMI",
}
KEPT = 100
"""Number of messages that are kept of an instance."""
LONGEST = 10_000
"""Characters that are kept of a message."""

Listener = Callable[[int, str], None]
"""Called with the status (more than OK) and the text of a message, while the FMU logs it."""


class Messages:
    """The last messages of one instance, called `name`, oldest first.

    A `listener` hears all that have another status than OK, but while they are `muted`. `callbacks`
    goes into fmi2Instantiate, `callbacks_1` into fmiInstantiateSlave, `add_3` into
    fmi3InstantiateCoSimulation.
    """

    def __init__(self, listener: Listener | None = None, name: str = "") -> None:
        self._listener = listener
        self.muted = False
        self._texts: deque[tuple[int, str]] = deque(maxlen=KEPT)
        environment = next(_NUMBERS)
        _ALL[environment] = self
        if name:
            _BY_NAME[name.encode("utf-8")] = self
        self.callbacks = fmi2.fmi2CallbackFunctions()
        self.callbacks.logger = _LOGGER
        self.callbacks.allocateMemory = _ALLOCATE
        self.callbacks.freeMemory = _FREE
        self.callbacks.componentEnvironment = environment
        addLoggerProxy(ctypes.byref(self.callbacks))

    def callbacks_1(self) -> fmi1.fmi1CallbackFunctions:
        """For an instance of FMI 1.0: the same functions, at the same places."""
        return fmi1.fmi1CallbackFunctions.from_buffer_copy(self.callbacks)

    def add(self, status: int, text: str) -> None:
        """Keep a message, and pass it to the listener."""
        text = text[:LONGEST]
        self._texts.append((status, text))
        if status and self._listener and not self.muted:
            self._listener(status, text)

    def add_3(
        self, _environment: object, status: int, _category: object, text: bytes | None
    ) -> None:
        """FMI 3.0's callback for messages."""
        self.add(status, _decoded(text))

    def take(self) -> tuple[tuple[int, str], ...]:
        """All that is kept, each with its status; nothing is kept then."""
        taken = tuple(self._texts)
        self._texts.clear()
        return taken

    @property
    def tell_why(self) -> bool:
        """True if a message of more than a warning is kept."""
        return any(status > WARNING for status, _ in self._texts)

    def last(self, count: int = 3) -> str:
        """The last few messages of trouble, or of anything if there was none."""
        trouble = [text for status, text in self._texts if status != 0]
        return "; ".join((trouble or [text for _, text in self._texts])[-count:])


_ALL: weakref.WeakValueDictionary[int, Messages] = weakref.WeakValueDictionary()
_BY_NAME: weakref.WeakValueDictionary[bytes, Messages] = weakref.WeakValueDictionary()
_NUMBERS = itertools.count(1)


def _log(environment: Any, name: Any, status: int, category: Any, message: Any) -> None:
    receiver = _ALL.get(environment or 0) or _BY_NAME.get(name or b"")
    if receiver is None:
        fmi2.printLogMessage(environment, name, status, category, message)
    else:
        receiver.add(status, _decoded(message))


def _decoded(text: bytes | None) -> str:
    return (text or b"").decode("utf-8", errors="replace").strip()


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_log)
_ALLOCATE = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
_FREE = fmi2.fmi2CallbackFreeMemoryTYPE(free)
