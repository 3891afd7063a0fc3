"""Program beside a master: it starts workers, reports how they end, and clears up behind them.

It runs no code of any FMU itself. Requests to start a worker come as lines of JSON on the standard
input (what `_serve` needs). What happens goes to the standard output in the same way: the number of
a process that has ``started``, or why it was ``refused``, what a worker has ``said`` (on its
standard output or error), and how it ``ended``. When its input ends, as it does when the master is
gone, however that was, it kills all workers with their children and removes their folders. Signals
that ask for an end are for the master: a batch system sends them to all processes. Standard library
only, and run by its path: it starts in 40 ms. FMUs in the master's process are loaded by the same
`load_library`.
"""

from __future__ import annotations

import ctypes
import json
import mmap
import os
import selectors
import shutil
import signal
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

Request = dict[str, Any]
"""To start a worker: what `_serve` needs."""
CHUNK = 65536
MOST_DESCRIPTORS = 2**16
"""More than the keeper has."""
PATIENCE = 0.05
"""Seconds after which workers are looked at that keep their output open beyond their end."""


_DEATH_SIGNAL = 1
"""Of prctl: the signal that a process gets when its parent ends."""


@dataclass
class _Kept:
    """A worker: its number, its process, the end of the pipe where it speaks."""

    number: int
    process: int
    output: int


class Keeper:
    """The workers of one master."""

    def __init__(self) -> None:
        self._workers: dict[int, _Kept] = {}
        self._folders: set[str] = set()
        self._selector = selectors.DefaultSelector()
        self._rest = b""
        self._master, self._number, self._is_worker = os.getppid(), os.getpid(), False

    def run(self) -> None:
        """Serve the master until it is gone."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: None)  # not SIG_IGN, which programs of FMUs would have
            signal.siginterrupt(number, False)
        requests = sys.stdin.fileno()
        self._selector.register(requests, selectors.EVENT_READ)
        ended = _told_of_ends()
        self._selector.register(ended, selectors.EVENT_READ)
        try:
            while os.getppid() == self._master:  # others may hold the pipe open
                for key, _ in self._selector.select(PATIENCE if self._workers else 1.0):
                    if key.fd == ended:
                        os.read(ended, CHUNK)
                    elif key.fd != requests:
                        self._hear(key.data)
                    elif not self._obey(os.read(requests, CHUNK)):
                        return
                for worker in list(self._workers.values()):
                    self._look(worker)
        finally:
            if not self._is_worker:
                self._clear()

    def _obey(self, text: bytes) -> bool:
        """Carry out the requests; False when the master is gone."""
        *lines, self._rest = (self._rest + text).split(b"\n")
        for line in lines:
            request = json.loads(line)
            try:
                self._start(request["start"], request)
            except OSError as error:
                _tell(refused=request["start"], why=error.strerror)
        return bool(text)

    def _start(self, number: int, request: Request) -> None:
        self._folders.add(request["clear"])
        output, inner = os.pipe()
        try:
            process = os.fork()
        except OSError:
            os.close(output)
            os.close(inner)
            raise
        if not process:
            self._be_worker(inner, request)
        os.close(inner)
        worker = self._workers[number] = _Kept(number, process, output)
        self._selector.register(output, selectors.EVENT_READ, worker)
        _tell(started=number, process=process)

    def _be_worker(self, output: int, request: Request) -> NoReturn:
        """In the new process: nothing of the keeper's stays open but what FMUs may write to."""
        self._is_worker = True
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        set_apart()
        if os.getppid() != self._number:  # the keeper has ended before that
            os._exit(1)
        self._selector.close()
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.closerange(3, MOST_DESCRIPTORS)
        _serve(request)
        sys.exit(0)

    def _hear(self, worker: _Kept) -> bool:
        """Pass on what a worker has said; False if it says no more."""
        text = os.read(worker.output, CHUNK)
        if text:
            _tell(said=worker.number, text=text.decode("utf-8", "replace"))
        else:
            self._selector.unregister(worker.output)
        return bool(text)

    def _look(self, worker: _Kept) -> None:
        """Tell of a worker's end, if it has come."""
        status = _status(worker.process)
        if status is None:
            return
        os.set_blocking(worker.output, False)
        if worker.output in self._selector.get_map():
            with suppress(BlockingIOError):
                while self._hear(worker):
                    pass
        if worker.output in self._selector.get_map():
            self._selector.unregister(worker.output)
        os.close(worker.output)
        del self._workers[worker.number]
        _tell(ended=worker.number, code=os.waitstatus_to_exitcode(status))

    def _clear(self) -> None:
        for worker in self._workers.values():
            kill(worker.process)
        for worker in self._workers.values():
            os.waitpid(worker.process, 0)
        for folder in self._folders:
            shutil.rmtree(folder, ignore_errors=True)
            if os.getppid() != self._master:
                with suppress(OSError):  # others are in it: the next process removes them
                    (above := Path(folder).parent).rmdir()
                    Path(f"{above}.lock").unlink()


def _told_of_ends() -> int:
    """The end of a pipe that can be read when a worker has ended."""
    ended, inner = os.pipe()
    os.set_blocking(ended, False)
    os.set_blocking(inner, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(inner, warn_on_full_buffer=False)
    return ended


def set_apart() -> None:
    """Put this process into a group of its own, which `kill` ends; it ends with its parent."""
    if hasattr(os, "setsid"):
        os.setsid()
    end_with_parent()


def end_with_parent() -> None:
    """Let this process end when its parent does, however that ends; Linux only."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGKILL)


def kill(process: int) -> None:
    """End a process that was `set_apart`, with its children."""
    kill_children(process)
    with suppress(OSError):
        os.kill(process, getattr(signal, "SIGKILL", signal.SIGTERM))


def kill_children(process: int) -> None:
    """End all processes in the group of a process that was `set_apart`, on systems with groups."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process, signal.SIGKILL)


def _status(process: int) -> int | None:
    """The status of a process that has ended, whose group is ended with it; None before."""
    if hasattr(os, "waitid"):  # macOS has it from Python 3.13 on
        if not os.waitid(os.P_PID, process, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            return None
        kill_children(process)  # while its number cannot be another's
        return os.waitpid(process, 0)[1]
    ended, status = os.waitpid(process, os.WNOHANG)
    if not ended:
        return None
    kill_children(process)
    return status


def _tell(**what: object) -> None:
    line = json.dumps(what).encode("ascii") + b"\n"
    with suppress(BrokenPipeError):
        while line:
            line = line[os.write(1, line) :]


# ---- in a worker ----


def _serve(request: Request) -> None:
    """Load the FMU's library and perform calls on it until the master has no more."""
    runtime = ctypes.CDLL(request["runtime"])
    with open(request["memory"], "r+b") as file:  # noqa: PTH123  before pathlib is needed
        memory = mmap.mmap(file.fileno(), 0)
    channel = ctypes.byref((ctypes.c_char * len(memory)).from_buffer(memory))
    try:
        _settle(request)
        library = load_library(request["library"], request["needed"])
    except Exception as error:  # noqa: BLE001  the master raises it
        runtime.m4e_remote_refuse(channel, str(error).encode())
        return
    os.chdir(request["folder"])
    functions = [getattr(library, name, None) for name in request["functions"]]
    addresses = [f and ctypes.cast(f, ctypes.c_void_p).value for f in functions]
    runtime.m4e_remote_serve(channel, (ctypes.c_void_p * len(addresses))(*addresses))


def _settle(request: Request) -> None:
    """Environment, search path and limits."""
    os.environ.update(request["environment"])
    sys.path[:] = request["path"]
    if request["limit"] is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (request["limit"], request["limit"]))


def load_library(path: str, needed: Iterable[str]) -> ctypes.CDLL:
    """The FMU's library at `path`, with its folder as the working folder from then on.

    OSError if it cannot be loaded, AttributeError if it lacks one of the functions `needed`.
    """
    if not Path(path).is_file():
        raise FileNotFoundError(f"Cannot find shared library {path}.")
    os.chdir(Path(path).parent)  # where some find the libraries that they need
    try:
        library = ctypes.CDLL(path)
    except OSError as error:
        raise OSError(f"Failed to load shared library {path}. {error}") from error
    for name in needed:
        getattr(library, name)
    return library


if __name__ == "__main__":
    Keeper().run()
