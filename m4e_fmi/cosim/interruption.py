"""How steps are made: Ctrl-C waits for the end of one, and NumPy does not warn meanwhile."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np


def quiet() -> np.errstate:
    """An overflow is found, and told with its place, where values are read from the FMUs."""
    return np.errstate(over="ignore", invalid="ignore")


@contextmanager
def stepping() -> Iterator[Callable[[], bool]]:
    """Around steps: tells whether they are to be interrupted."""
    with _interruption() as interrupted, quiet():
        yield interrupted


@contextmanager
def _interruption() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed; a second time it interrupts at once, as usual.

    An exception raised inside an FMU written in Python would be fatal to it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = False
    usual = signal.getsignal(signal.SIGINT)

    def note(*_: object) -> None:
        nonlocal pressed
        pressed = True
        signal.signal(signal.SIGINT, usual)

    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, usual)
