"""Signals that ask a process to end: SIGTERM, SIGHUP, on Windows CTRL_BREAK.

Python would end at once, without removing temporary folders or telling results how they ended.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

ENDING = tuple(
    signal.Signals(getattr(signal, name))
    for name in ("SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)
)


class Terminated(SystemExit):
    """A signal asked for the end; unless it is caught, the exit code is 128 plus its number."""

    def __init__(self, number: int) -> None:
        super().__init__(128 + number)
        self.signal = signal.Signals(number)

    def __str__(self) -> str:
        return f"ended by {self.signal.name}"


@contextmanager
def ending_cleanly() -> Iterator[None]:
    """Signals of `ENDING` raise Terminated during the block.

    Those that are ignored (nohup), or that somebody else handles, are left alone.
    """
    with handled([s for s in ENDING if signal.getsignal(s) is signal.SIG_DFL], terminate):
        yield


def terminate(number: int, _: object) -> NoReturn:
    """The handler that raises Terminated."""
    raise Terminated(number)


@contextmanager
def handled(numbers: list[signal.Signals], handler: Any) -> Iterator[None]:
    """`handler` takes these signals during the block; outside the main thread there are none."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, before in usual.items():
            signal.signal(number, before)
