"""Chunks of the runs of a program, and the threads that make them.

An ensemble keeps nothing before all its members are done, and nothing interrupts it. So chunks are
sized by the time that they take: a kill loses seconds of work, and all threads have some.
"""

from __future__ import annotations

import queue
import threading
import time as clock
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from m4e_fmi.runtime.declarations import LANES

MOST = 512
"""Runs in one chunk."""
LONG = 1.0
"""Seconds that a chunk should take at most."""
_LOOK = 0.2
"""Seconds after which a waiting thread looks for signals, where a lock keeps them out."""

COMPILING_PAYS = 1.0
"""Seconds of processor time that the interpreter would take for what is left of a group, from which
on its program is compiled: both give the same bits."""

Result = TypeVar("Result")


@dataclass
class Pace:
    """The `size` of chunks, in runs [1], for so many threads: small first, then by their time.

    `left` runs [1] are not made yet; the interpreter took `each` [s] for one of the first.
    """

    jobs: int
    left: int
    size: int = LANES
    each: float = 0.0
    compiled: bool = False

    def next(self, left: int) -> int:
        """Runs of the next chunk, of those that are `left`: each thread has two more, if it can."""
        share = -(-left // (2 * self.jobs * LANES)) * LANES
        return min(self.size, share, left)

    def took(self, count: int, seconds: float, used: float) -> None:
        """Learn from a chunk of `count` runs, of the time and of that `used` by the processor [s].

        The next ones are at most twice as large.
        """
        fitting = int(count * LONG / max(seconds, 1e-9)) // LANES * LANES
        self.size = max(LANES, min(MOST, 2 * count // LANES * LANES, fitting))
        self.left -= count
        self.each = self.each or used / count
        self.compiled = self.compiled or self.left * self.each > COMPILING_PAYS


def chunks(
    runs: np.ndarray, pace: Pace, make: Callable[[np.ndarray, bool], Result]
) -> Iterator[Callable[[], Result]]:
    """Calls that make parts of `runs` (n,) [1], each sized when it is asked for.

    `make` makes some, by a program that is compiled or not.
    """
    first = 0
    while first < len(runs):
        count = pace.next(len(runs) - first)
        part = runs[first : first + count]
        first += count

        def timed(part: np.ndarray = part) -> Result:
            began, used = clock.perf_counter(), clock.thread_time()
            made = make(part, pace.compiled)
            pace.took(len(part), clock.perf_counter() - began, clock.thread_time() - used)
            return made

        yield timed


def in_threads(calls: Iterable[Callable[[], Result]], jobs: int) -> Iterator[Result]:
    """Results of calls, most of which run in the C library, as they come, by so many threads.

    Where the iteration ends early, as by Ctrl-C, no further call begins, and those under way are
    left alone: no thread is waited for, and none keeps the process from its end.
    """
    waiting, lock, ended = iter(calls), threading.Lock(), threading.Event()
    made: queue.SimpleQueue[tuple[Result | None, BaseException | None]] = queue.SimpleQueue()

    def work() -> None:
        try:
            while not ended.is_set():
                with lock:
                    call = next(waiting, None)
                if call is None:
                    break
                made.put((call(), None))
        except BaseException as error:  # noqa: BLE001  it is raised where the results are taken
            made.put((None, error))
        else:
            made.put((None, None))

    threads = [threading.Thread(target=work, daemon=True) for _ in range(jobs)]
    for thread in threads:
        thread.start()
    try:
        while threads:
            try:
                result, error = made.get(timeout=_LOOK)
            except queue.Empty:
                continue
            if error is not None:
                raise error
            if result is None:
                threads.pop()
            else:
                yield result
    finally:
        ended.set()
