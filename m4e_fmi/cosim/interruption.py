"""How steps are made: signals wait for the end of one, and NumPy does not warn meanwhile."""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import numpy as np

from m4e_fmi.signals import ENDING, Terminated, handled, terminate

TICK = 0.1
"""Seconds of wall time after which many steps at once are interrupted, at the end of one."""
GRACE = 10.0
"""Seconds that a step may still take after a signal that asks for the end; then the process ends
without it. Ctrl-C waits."""


def quiet() -> np.errstate:
    """An overflow is found, and told with its place, where values are read from the FMUs."""
    return np.errstate(over="ignore", invalid="ignore")


@contextmanager
def same_folder() -> Iterator[None]:
    """Around calls of FMUs: the process is in the folder afterwards in which it was before."""
    try:
        folder = os.getcwd()  # noqa: PTH109  Path.cwd asks for nothing else, and costs more
    except OSError:  # it was removed
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            os.chdir(folder)  # an FMU may have changed it


@contextmanager
def stepping(halt: Callable[[], None] | None = None) -> Iterator[Callable[[], None]]:
    """Around steps: gives what is to be called between them.

    It raises KeyboardInterrupt, or Terminated, after a signal that asks for it; an exception raised
    inside an FMU written in Python would be fatal to it. A second signal interrupts at once, as
    usual. `halt` is called every `TICK`, in another thread.
    """
    with same_folder(), quiet(), _noting() as noted, _ticking(halt):

        def check() -> None:
            if noted:
                raise KeyboardInterrupt if noted[0] == signal.SIGINT else Terminated(noted[0])

        yield check
        check()


@contextmanager
def _noting() -> Iterator[list[int]]:
    """A list to which signals come that are to wait."""
    noted: list[int] = []
    known = (signal.SIG_DFL, terminate)
    waiting = [signal.SIGINT, *(s for s in ENDING if signal.getsignal(s) in known)]
    usual = {number: signal.getsignal(number) for number in waiting}

    def note(number: int, _: object) -> None:
        noted.append(number)
        signal.signal(number, usual[signal.Signals(number)])

    with handled(waiting, note):
        yield noted


@contextmanager
def _ticking(halt: Callable[[], None] | None) -> Iterator[None]:
    """A thread beside steps that are made many at once."""
    if halt is None:
        yield
        return
    done, ours = socket.socketpair()
    with done, ours:
        ours.setblocking(False)
        taken = threading.current_thread() is threading.main_thread() and _wake(ours.fileno())
        thread = threading.Thread(target=_tick, args=(done, halt), daemon=True)
        thread.start()
        try:
            yield
        finally:
            if taken:
                signal.set_wakeup_fd(-1)
            ours.shutdown(socket.SHUT_WR)
            thread.join()


def _wake(descriptor: int) -> bool:
    """Have the numbers of signals written there, even during a call of an FMU.

    False if somebody else, as an event loop, has them.
    """
    before = signal.set_wakeup_fd(descriptor, warn_on_full_buffer=False)
    if before != -1:
        signal.set_wakeup_fd(before)
    return before == -1


def _tick(done: socket.socket, halt: Callable[[], None]) -> None:
    """Halt steps now and then; end the process if one goes on after a signal of `ENDING`."""
    last, ending = np.inf, 0
    while clock.monotonic() < last:
        ready, _, _ = select.select([done], [], [], TICK)
        numbers = done.recv(64) if ready else b""
        if ready and not numbers:
            return
        halt()
        if not ending and (asked := set(numbers) & set(ENDING)):
            ending, last = asked.pop(), clock.monotonic() + GRACE
    name = signal.Signals(ending).name
    sys.stderr.write(f"ended by {name}: a step of an FMU did not end within {GRACE:g} s\n")
    os._exit(128 + ending)
