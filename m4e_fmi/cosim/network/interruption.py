"""How FMUs are called: signals wait for the end of a step, and end what comes before the first."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
import time as clock
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.worker import end_busy
from m4e_fmi.signals import ENDING, ending, handled, held, let_through, not_lost, terminate

TICK = 0.1
"""Seconds of wall time after which many steps at once are interrupted, at the end of one."""
GRACE = 10.0
"""Seconds that a call of an FMU may still take after a signal that asks for the end; then the
process ends without it. Ctrl-C waits."""
PATIENCE = 0.5
"""Seconds after a signal that asks for the end until workers are killed whose call goes on, and the
user is told of a call in this process; so much later than the second Ctrl-C, the process ends
without that (but not an interactive one)."""

_AGAIN = "; press Ctrl-C again to end at once"
_AGAIN_IN_SHELLS = "; interrupt again to end it if it is Python code, else restart the process"


def quiet() -> np.errstate:
    """An overflow is found, and told with its place, where values are read from the FMUs."""
    return np.errstate(over="ignore", invalid="ignore")


@contextmanager
def same_folder() -> Generator[None]:
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
def setting_up() -> Generator[None]:
    """Around calls of FMUs before the first step: signals act at once, or after a call."""
    asking = _ours()
    with held(), same_folder(), _ticking(asking), let_through(), not_lost():
        yield


@contextmanager
def closing_down() -> Generator[None]:
    """Around the end of FMUs: signals end workers whose call goes on."""
    with same_folder(), _ticking(_ours()):
        yield


def _ours() -> set[signal.Signals]:
    """Signals of `ENDING` that end the process: nobody else handles them, or ignores them."""
    return {s for s in ENDING if signal.getsignal(s) in (signal.SIG_DFL, terminate)}


@contextmanager
def stepping(
    halt: Callable[[], None] | None = None, where: Callable[[], str] = str
) -> Generator[Callable[[], None]]:
    """Context of steps; yields a function to call between them.

    It raises KeyboardInterrupt, or Terminated, after such a signal; an exception raised
    inside an FMU written in Python would be fatal to it. A second signal interrupts at once, as
    usual. `halt` is called every `TICK`, in another thread. If a call continues after a signal, a
    message to the user says so, with the place of the run, `where`.
    """
    asking = _ours()
    with (
        same_folder(),
        quiet(),
        not_lost(),
        _noting(asking) as noted,
        _ticking(asking, halt, where),
    ):

        def check() -> None:
            if noted:
                raise ending(noted[0])

        try:
            yield check
        except RunError as error:  # of a worker that was ended
            if noted:
                raise ending(noted[0]) from error
            raise
        check()


@contextmanager
def _noting(asking: set[signal.Signals]) -> Generator[list[int]]:
    """A list to which signals come that are to wait: Ctrl-C, and those `asking`."""
    noted: list[int] = []
    waiting = [signal.SIGINT, *asking]
    usual = {number: signal.getsignal(number) for number in waiting}

    def note(number: int, _: object) -> None:
        noted.append(number)
        signal.signal(number, usual[signal.Signals(number)])

    with handled(waiting, note):
        yield noted


@contextmanager
def _ticking(
    asking: set[signal.Signals],
    halt: Callable[[], None] | None = None,
    where: Callable[[], str] = str,
) -> Generator[None]:
    """A thread beside calls of FMUs: it calls `halt`, and hears of signals `asking` for the end."""
    if not (halt or asking):
        yield
        return
    done, ours = socket.socketpair()
    with done, ours:
        ours.setblocking(False)
        taken = threading.current_thread() is threading.main_thread() and _wake(ours.fileno())
        thread = threading.Thread(target=_tick, args=(done, asking, halt, where), daemon=True)
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


def _tick(
    done: socket.socket,
    asking: set[signal.Signals],
    halt: Callable[[], None] | None,
    where: Callable[[], str],
) -> None:
    """Halt steps now and then; after a signal, end workers, or the process, if a call goes on.

    The process ends after a signal `asking` for it, and after a second Ctrl-C; after the first, the
    user is told what the run waits for.
    """
    last, number, presses, tell, told = np.inf, 0, 0, np.inf, False
    done.settimeout(TICK)
    while clock.monotonic() < last:
        numbers = b""
        with suppress(TimeoutError):
            numbers = done.recv(64)
            if not numbers:
                return
        if halt:
            halt()
        soon = clock.monotonic() + PATIENCE
        if numbers and not told:
            tell = min(tell, soon)
        if signal.SIGINT in numbers:
            presses += numbers.count(signal.SIGINT)
            if presses > 1 and not _is_interactive():
                number, last = number or signal.SIGINT, min(last, soon)
        if clock.monotonic() > tell:
            tell, told = np.inf, True
            if not end_busy() and presses:
                again = _AGAIN_IN_SHELLS if _is_interactive() else _AGAIN
                _say(f"waiting for an FMU to end its step{where()}{again}")
        if number in (0, signal.SIGINT) and (asked := asking.intersection(numbers)):
            number, last = asked.pop(), min(last, clock.monotonic() + GRACE)
    name = signal.Signals(number).name
    if number == signal.SIGINT:
        _say(f"ended by {name}: a call of an FMU did not end{where()}")
    else:
        _say(f"ended by {name}: a call of an FMU did not end within {GRACE:g} s{where()}")
    os._exit(128 + number)


def _is_interactive() -> bool:
    """True in a shell or notebook, whose process has more to lose than this run."""
    return hasattr(sys, "ps1") or "ipykernel" in sys.modules


def _say(line: str) -> None:
    with suppress(OSError, ValueError, AttributeError):  # closed, or none at all
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()
