"""Signals that ask a process to end: SIGTERM, SIGHUP, on Windows CTRL_BREAK.

Python would end at once, without removing temporary folders or telling results how they ended.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any, NoReturn

Handler = Callable[[int, FrameType | None], object]
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
def ending_cleanly() -> Generator[None]:
    """Signals of `ENDING` raise Terminated during the block, or at its end if that gets lost.

    Those that are ignored (nohup), or that somebody else handles, are left alone.
    """
    ours = [s for s in ENDING if signal.getsignal(s) is signal.SIG_DFL]
    try:
        with handled(ours, terminate):
            yield
        if _terminated:
            raise Terminated(_terminated[0])
    finally:
        if ours:
            _terminated.clear()


_terminated: list[int] = []
"""Signals that have raised Terminated, which is lost where Python removes an object."""


def terminate(number: int, _: object) -> NoReturn:
    """The handler that raises Terminated."""
    _terminated.append(number)
    raise Terminated(number)


def ending(number: int) -> BaseException:
    """The exception for a signal that asks for the end."""
    return KeyboardInterrupt() if number == signal.SIGINT else Terminated(number)


_raisers: list[object] = [signal.default_int_handler, terminate]
"""Handlers that raise."""


def _raising() -> list[signal.Signals]:
    """Signals that raise at present."""
    return [s for s in (signal.SIGINT, *ENDING) if signal.getsignal(s) in _raisers]


@dataclass
class _Held:
    """Signals that wait: what they do otherwise, and those that have come."""

    usual: dict[signal.Signals, Any]
    waiting: list[int] = field(default_factory=list)

    def wait(self, number: int, _: object) -> None:
        """The handler."""
        self.waiting.append(number)

    def act(self) -> None:
        """Do what the first of them does otherwise, if there is one."""
        if self.waiting:
            number = self.waiting.pop(0)
            self.usual[signal.Signals(number)](number, None)


_held: list[_Held] = []
"""Blocks of `held` in the main thread, the innermost last."""


@contextmanager
def held() -> Generator[None]:
    """Signals that would raise wait for the end of the block, or for one of `let_through` in it."""
    block = _Held({s: signal.getsignal(s) for s in _raising()})
    if not (block.usual and _is_main()):
        yield
        return
    try:
        with handled([*block.usual], block.wait):
            _held.append(block)
            try:
                yield
            finally:
                _held.pop()
    except (KeyboardInterrupt, Terminated):
        raise
    except BaseException:
        block.act()
        raise
    block.act()


@contextmanager
def let_through() -> Generator[None]:
    """Signals are not `held` during the block: they raise, and so does one that waits."""
    if not _held or not _is_main() or _raising():
        yield
        return
    block = _held[-1]
    try:
        for number, usual in block.usual.items():
            signal.signal(number, usual)
        block.act()
        yield
    finally:
        for number in block.usual:
            signal.signal(number, block.wait)


def _is_main() -> bool:
    return threading.current_thread() is threading.main_thread()


_calling: list[list[int]] = []
"""The signals that have raised within the outermost block of `not_lost`, if there is one."""


@contextmanager
def not_lost() -> Generator[None]:
    """Around calls of FMUs: signals that ask for the end raise, if not at once, after the block.

    What is raised inside an FMU written in Python goes no further than that, and is at most its
    failure; what is raised while it logs, or is freed, goes nowhere. Blocks may be nested.
    """
    if _calling or not _is_main():
        with _told_after(_calling[0] if _calling else []):
            yield
        return
    raised: list[int] = []

    def note(number: int, _: object) -> NoReturn:
        raised.append(number)
        raise ending(number)

    _calling.append(raised)
    try:
        with _told_after(raised), handled(_raising(), note):
            _raisers.append(note)
            yield
    finally:
        _calling.clear()
        del _raisers[2:]


def is_ending() -> bool:
    """True if a signal has raised within the present block of `not_lost`."""
    return any(_calling)


@contextmanager
def _told_after(raised: list[int]) -> Generator[None]:
    """If there is any in the end, the first is raised, unless one is on its way already."""
    try:
        yield
    except (KeyboardInterrupt, Terminated):
        raise
    except BaseException as error:
        if raised:
            raise ending(raised[0]) from error
        raise
    if raised:
        raise ending(raised[0])


@contextmanager
def handled(numbers: list[signal.Signals], handler: Handler) -> Generator[None]:
    """`handler` takes these signals during the block; outside the main thread there are none."""
    if not _is_main():
        yield
        return
    usual: dict[signal.Signals, Any] = {}
    try:
        for number in numbers:
            usual[number] = signal.signal(number, handler)
        yield
    finally:
        for number, before in usual.items():
            signal.signal(number, before)
