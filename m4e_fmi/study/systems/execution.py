"""Performing tasks by executors: the processes of this machine, or any other ones.

A worker that dies takes no other run with it: those that
were under way are made again, one at a time.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Collection, Generator, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from types import ModuleType

from m4e_fmi.signals import Terminated
from m4e_fmi.study.record import Record
from m4e_fmi.study.systems.task import Task, perform

AHEAD = 2
"""Tasks under way for each worker: one that it makes, and one that waits for it."""
ONE_THREAD = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)
"""Variables of the environment that give numerical libraries one thread."""
PATIENCE = 1.0
"""Seconds that a process has to end when it is asked to."""
MOST_ON_WINDOWS = 61
"""Processes of a pool that Windows can wait for."""
DIED = "its process died, as of a fault in the code of an FMU, or for lack of memory"

_beginning = threading.Lock()
"""Held while a process begins with an environment and a main module of its own."""
Done = tuple[int, Record]
Perform = Callable[[Iterable[tuple[int, Task]]], Iterator[Done]]


@contextmanager
def performing(jobs: int, executor: Executor | None = None) -> Generator[Perform]:
    """A function that performs tasks, by `jobs` processes or by an `executor`.

    It gives number and record of each task, as they come. Processes begin at once, so that they are
    ready when the first task is. Where the context or the iteration ends early, as by a signal,
    they end at once.
    """
    if executor is not None:
        yield lambda tasks: _by(executor, tasks, jobs, lost=None)
        return
    if sys.platform == "win32":
        jobs = min(jobs, MOST_ON_WINDOWS)
    with _processes(jobs) as pool:
        yield partial(_performed, jobs, pool)


def _performed(
    jobs: int, first: ProcessPoolExecutor, tasks: Iterable[tuple[int, Task]]
) -> Iterator[Done]:
    """By the `first` processes; by others when one of them has died."""
    waiting = iter(tasks)
    lost: list[tuple[int, Task]] = []
    yield from _by(first, waiting, jobs, lost=lost)
    first.shutdown(wait=False)  # its processes end while the result is written
    while lost:
        for one in lost:
            yield from _alone(one)
        lost = []
        with _processes(jobs) as pool:
            yield from _by(pool, waiting, jobs, lost=lost)


def _alone(one: tuple[int, Task]) -> Iterator[Done]:
    """The record of a task that is made by a process of its own."""
    lost: list[tuple[int, Task]] = []
    with _processes(1) as pool:
        yield from _by(pool, [one], 1, lost=lost)
    for number, _ in lost:
        yield number, Record(failure=DIED)


def _by(
    executor: Executor,
    tasks: Iterable[tuple[int, Task]],
    jobs: int,
    *,
    lost: list[tuple[int, Task]] | None,
) -> Iterator[Done]:
    """Records by one executor; tasks that it breaks over go to `lost`, else its error is raised."""
    make = perform if lost is None else _perform
    under_way: dict[Future[Record], tuple[int, Task]] = {}
    waiting = iter(tasks)
    taken: tuple[int, Task] | None = None  # neither under way nor done
    try:
        while True:
            while len(under_way) < AHEAD * jobs and (taken := next(waiting, None)) is not None:
                under_way[executor.submit(make, taken[1])] = taken
            taken = None
            if not under_way:
                return
            done, _ = wait(under_way, return_when=FIRST_COMPLETED)
            for future in done:
                taken = number, _ = under_way.pop(future)
                found = future.result()
                taken = None
                yield number, found
    except BrokenExecutor:
        if lost is None:
            raise
        lost += [*([taken] if taken else []), *under_way.values()]
    finally:
        for future in under_way:
            future.cancel()


class _Process(SpawnProcess):
    """A new process with one thread for numerical libraries, that does not run the user's script.

    What it makes is in modules; a script that begins a study would begin another in each process.
    """

    def start(self) -> None:
        """Begin the process."""
        with _beginning, _one_thread(), _no_script(), _interrupts_held():
            super().start()


class _Context(SpawnContext):
    Process = _Process


@contextmanager
def _processes(jobs: int) -> Generator[ProcessPoolExecutor]:
    """New processes of this machine."""
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, mp_context=_Context(), initializer=_worker)
    begun: list[Future[int]] = []
    try:
        with suppress(BrokenExecutor):  # told by the first task
            begun.extend(pool.submit(os.getpid) for _ in range(jobs))  # each begins a process
        yield pool
    except BaseException:
        _end(pool, before)
        raise
    if all(one.done() for one in begun):
        pool.shutdown()
    else:  # none is ready yet: there was nothing to make
        _end(pool, before)


def _end(pool: ProcessPoolExecutor, before: Collection[BaseProcess]) -> None:
    """End the processes of a pool at once; those that were there `before` it live on."""
    pool.shutdown(wait=False, cancel_futures=True)
    for process in set(multiprocessing.active_children()) - {*before}:
        process.terminate()
    for process in set(multiprocessing.active_children()) - {*before}:
        process.join(PATIENCE)
        process.kill()


@contextmanager
def _one_thread() -> Generator[None]:
    """Processes that begin meanwhile have numerical libraries with one thread."""
    kept = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in kept.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


@contextmanager
def _no_script() -> Generator[None]:
    """Processes that begin meanwhile do not import the main module, which they find by its name."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextmanager
def _interrupts_held() -> Generator[None]:
    """Ctrl-C comes at the end; processes that begin meanwhile have it held until `_worker`.

    Without, it would end them with a traceback while they import what they need.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _worker() -> None:
    """Prepare a process: Ctrl-C is for its parent, with which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _perform(task: Task) -> Record:
    """Make a run in a process that SIGTERM ends, whatever it does.

    Its pool would take the exception for a result, and wait for a lock that dead processes hold.
    """
    try:
        return perform(task)
    except Terminated as error:
        os._exit(128 + error.signal)


def _end_with(parent: BaseProcess) -> None:
    with suppress(OSError):
        parent.join()
    os._exit(1)


def cores() -> int:
    """Number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1
