"""FMUs in processes of their own: started, watched, ended, and how one crashed, hung or exited.

A `Worker` is such a process of the master's; its `ending` is worded here for the error of a run.
`Host` has the limits. The functions by which they are called are the runtime's:
m4e_remote_fmi2DoStep, in remote.h, stands for fmi2DoStep of an FMU.
"""

from __future__ import annotations

import atexit
import ctypes
import functools
import json
import mmap
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from ctypes import c_char_p, c_int, c_int32, c_size_t, c_uint32, c_void_p
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import IO

from m4e_fmi.fmu.importer.worker import keeper as keeper_program
from m4e_fmi.runtime.library import library, library_path

CALL = 600.0
"""Seconds that a call of an FMU may take."""
END = 30.0
"""Seconds that terminating or freeing an FMU may take."""
LOST, LATE = 18, 19
"""Answers of calls beside the statuses of FMI: the worker is gone; values that have been set before
come to the FMU only now, and it refuses them."""
TICK = 0.05
"""Seconds between two looks at the calls of all workers."""
STILL = 60.0
"""Seconds of a call after which the user is told that it goes on."""
LAST = 5.0
"""Seconds that a worker may take to end once its FMU is freed."""
KILLED = 2.0
"""Seconds that a worker may take to end once it is killed."""
KEPT = 2000
"""Characters that are kept of what a worker has printed."""
PASSED = (
    *("PATH", "HOME", "USER", "TMPDIR", "TEMP", "TMP", "SYSTEMROOT", "LD_LIBRARY_PATH"),
    *("DYLD_LIBRARY_PATH", "VIRTUAL_ENV", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"),
)
"""Variables of the environment that workers get."""
ENDS = ("Terminate", "FreeInstance", "FreeSlaveInstance", "unloading")
"""How the names of calls begin, without prefix, that have the limit for the end."""


@dataclass(frozen=True)
class Host:
    """Limits of a worker, and what it knows of the user's environment.

    `call` is the time [s] that instantiating, initialising, a step and all other calls may take
    each, `end` that for terminating and freeing; `memory` the address space [bytes], None for no
    limit; `keep` are the names of further variables of the environment that the FMU gets.
    """

    call: float = CALL
    end: float = END
    memory: int | None = None
    keep: tuple[str, ...] = ()


class Channel(ctypes.Structure):
    """The fields that `m4e_channel` of remote.h begins with."""

    _fields_ = [
        ("lost", c_int32),
        ("calls", c_uint32),
        ("busy", c_int32),
        ("present", c_uint32),
        ("late_function", c_uint32),
        ("late_status", c_int32),
    ]
    calls: int
    busy: int
    present: int
    late_function: int
    late_status: int


@functools.cache
def remote_library() -> ctypes.CDLL:
    """The runtime, loaded for its functions of remote.h."""
    library()  # or the reason why there is none
    found = ctypes.CDLL(str(library_path()))
    for name, result, *arguments in (
        ("new", c_void_p, c_void_p),
        ("free", None, c_void_p),
        ("use", None, c_void_p),
        ("await", c_int, c_void_p),
        ("flush", c_int, c_void_p),
        ("end", c_int, c_void_p),
        ("give_up", None, c_void_p),
        ("text", c_char_p, c_void_p),
        ("names", c_char_p),
        ("size", c_size_t),
    ):
        function = getattr(found, f"m4e_remote_{name}")
        function.restype, function.argtypes = result, arguments
    return found


@functools.cache
def function_names() -> tuple[str, ...]:
    """Names of the functions of FMI that can be called in workers, by their numbers."""
    return tuple(remote_library().m4e_remote_names().decode("ascii").split())


class Worker:
    """An FMU's library in a process of its own; `leave` it, then `wait` for its end.

    `address` is the client's side of its channel, which is the FMU's component there. `folder` is
    the process's working folder, to which its shared memory is written, and `name` the FMU's in
    messages. `request` is what else the keeper's `_serve` needs, `runtime` the library with the
    functions. Functions in a worker answer LOST
    from when it is gone; `ending` then says how, and is empty otherwise. `notice` is called, in
    another thread, with a line on a call that takes long.
    OSError if the process cannot be started.
    """

    def __init__(self, name: str, host: Host, folder: Path, **request: object) -> None:
        runtime = remote_library()
        self.name, self.host, self.ending, self._refusal = name, host, "", ""
        self.notice: Callable[[str], None] = lambda _: None
        self.runtime = runtime
        self._said, self._began, self._seen, self._told = "", time.monotonic(), 0, False
        self._gone, self._leaving, self._process = threading.Event(), False, 0
        size = int(runtime.m4e_remote_size())
        memory = folder / "shared_memory"
        memory.write_bytes(bytes(size))  # a sparse file would crash on a full disk
        with memory.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), size)
        self._channel = Channel.from_buffer(self._memory)
        self._channel.busy, self._channel.present = 1, len(function_names())
        self.address: int = runtime.m4e_remote_new(ctypes.addressof(self._channel))
        request |= {
            "runtime": str(library_path()),
            "memory": str(memory),
            "folder": str(folder),
            "limit": host.memory,
            "environment": {name: os.environ[name] for name in host.keep if name in os.environ},
            "path": sys.path,
        }
        _keeper().start(self, request)

    def loaded(self) -> str:
        """Wait until the library is loaded; why it is not, empty if it is.

        OSError if the process could not be started.
        """
        status = self.runtime.m4e_remote_await(self.address)
        if self._refusal:
            raise OSError(self._refusal)
        if self.ending:
            return self.ending
        return self.runtime.m4e_remote_text(self.address).decode("utf-8", "replace") * bool(status)

    def next_instance(self) -> None:
        """The next instance that this thread makes by the runtime's functions is in this worker."""
        self.runtime.m4e_remote_use(self.address)

    def leave(self) -> None:
        """Have the process end; nothing waits for that."""
        if not (self.ending or self._leaving):
            self._leaving = True
            if self.runtime.m4e_remote_end(self.address):
                self.kill()

    def wait(self) -> None:
        """Wait until the process is gone, and kill it if it stays; then nothing may call it."""
        if not self._gone.wait(LAST if self._leaving else 0.0):
            self.kill()
            self._gone.wait(KILLED)
        self.runtime.m4e_remote_free(self.address)

    def end(self, why: str) -> None:
        """Kill the process; `why` is its ending."""
        self._lose(why)
        self.kill()

    def kill(self) -> None:
        """Kill the process and its children, if it has been started."""
        if self._process and not self._gone.is_set():
            keeper_program.kill(self._process)

    def end_if_busy(self) -> None:
        """Kill the process if a call is going on."""
        if self._channel.busy:
            self.end("was ended on request")

    def _lose(self, why: str) -> None:
        self.ending = self.ending or why
        self.runtime.m4e_remote_give_up(ctypes.addressof(self._channel))

    @property
    def call(self) -> str:
        """Name of the last call."""
        return _call_name(self._channel.present)

    @property
    def late(self) -> tuple[int, str]:
        """Status and name of the function that has set values before, and failed, after LATE."""
        return self._channel.late_status, _call_name(self._channel.late_function)

    def flush(self) -> int:
        """Status of functions that set values, and have not been performed yet."""
        return self.runtime.m4e_remote_flush(self.address)

    @property
    def words(self) -> str:
        """The last line that the process has printed."""
        lines = [line.strip() for line in self._said.splitlines() if line.strip()]
        return lines[-1] if lines else ""

    def look(self, now: float) -> None:
        """Kill the process if its present call takes longer than it may; `now` is the time [s]."""
        channel = self._channel
        if not channel.busy or channel.calls != self._seen:
            self._began, self._seen, self._told = now, channel.calls, False
            return
        bare = self.call.lstrip("fmi23")
        limit = self.host.end if bare.startswith(ENDS) else self.host.call
        if now - self._began > limit:
            self.end(f"did not return within {limit:g} s")
        elif now - self._began > STILL and not self._told:
            self._told = True
            with suppress(Exception):
                self.notice(f"still in {self.call} of {self.name} after {STILL:g} s")

    def hear(self, text: str) -> None:
        """Pass on what the process has printed, to standard error."""
        self._said = (self._said + text)[-KEPT:]
        with suppress(OSError):
            os.write(2, text.encode("utf-8", "replace"))

    def has_started(self, process: int) -> None:
        """Note the number of the process."""
        self._process = process
        if self.ending:
            self.kill()

    def has_ended(self, why: str, refusal: str = "") -> None:
        """Note that there is no process any more, or that there can be none by a `refusal`."""
        self._refusal = refusal
        self._lose(why)
        self._gone.set()


def _call_name(number: int) -> str:
    """Name of a call; an FMU that writes outside its memory may have altered its number."""
    names = (*function_names(), "loading its library", "unloading its library")
    return names[number] if number < len(names) else "a call"


def _ending(code: int) -> str:
    """How a process has ended, by its exit code (negative: a signal)."""
    with suppress(ValueError):
        return f"was ended by {signal.Signals(-code).name}"
    return f"ended with exit code {code}"


class _Keeper:
    """The keeper's process, its workers by number, and the threads that listen and watch."""

    def __init__(self) -> None:
        environment = {name: os.environ[name] for name in PASSED if name in os.environ}
        environment["LANG"] = "C.UTF-8"
        self._process = subprocess.Popen(
            [sys.executable, "-P", keeper_program.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,
        )
        assert self._process.stdin
        assert self._process.stdout
        self._requests: IO[bytes] = self._process.stdin
        self.workers: dict[int, Worker] = {}
        self._numbers, self._changing, self._some = count(), threading.Lock(), threading.Event()
        self.is_alive = True
        for target in (partial(self._listen, self._process.stdout), self._watch):
            threading.Thread(target=target, daemon=True).start()
        atexit.register(self.close)

    def start(self, worker: Worker, request: keeper_program.Request) -> None:
        """Start a worker's process."""
        with self._changing:
            number = next(self._numbers)
            self.workers[number] = worker
            line = json.dumps({"start": number, **request})
            self._requests.write(f"{line}\n".encode("ascii"))
            self._requests.flush()
        self._some.set()

    def close(self) -> None:
        """Have the keeper end, and wait for that."""
        with suppress(OSError):
            self._requests.close()
        try:
            self._process.wait(LAST)
        except subprocess.TimeoutExpired:
            self._process.kill()

    def _listen(self, answers: IO[bytes]) -> None:
        for line in answers:
            told = json.loads(line)
            if "started" in told:
                self.workers[told["started"]].has_started(told["process"])
            elif "said" in told:
                self.workers[told["said"]].hear(told["text"])
            elif "refused" in told:
                self.workers.pop(told["refused"]).has_ended("could not be started", told["why"])
            else:
                self.workers.pop(told["ended"]).has_ended(_ending(told["code"]))
        self.is_alive = False
        for worker in list(self.workers.values()):
            worker.kill()
            worker.has_ended("was ended with the process that keeps it")

    def _watch(self) -> None:
        while self._some.wait() and self.is_alive:
            self._some.clear()  # before the look at what there is: more may come meanwhile
            for worker in list(self.workers.values()):
                worker.look(time.monotonic())
                self._some.set()
            time.sleep(TICK)


_keepers: dict[int, _Keeper] = {}
"""By process: a forked one has none."""
_starting = threading.Lock()


def _keeper() -> _Keeper:
    """The keeper of this process."""
    with _starting:
        found = _keepers.get(os.getpid())
        if found is None or not found.is_alive:
            found = _keepers[os.getpid()] = _Keeper()
    return found


def end_busy() -> bool:
    """Kill all workers of this process in which a call is going on; True if there are any."""
    found = _keepers.get(os.getpid())
    workers = list(found.workers.values()) if found else []
    for worker in workers:
        worker.end_if_busy()
    return any(worker.ending for worker in workers)
