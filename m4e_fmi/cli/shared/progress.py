"""Progress of a command: a bar on terminals, events for programs."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from m4e_fmi.cli.shared.events import Progress, Runs
from m4e_fmi.cli.shared.log import LOG, tell_event
from m4e_fmi.cli.shared.log_handlers import ForPeople, ForPrograms

INTERVAL = 1.0
"""Seconds between events of progress."""


@contextmanager
def progress(stop_time: float, *, start: float = 0.0) -> Generator[Callable[[float], None]]:
    """A callable to be told the simulated time [s]: a bar on terminals, events for programs."""
    from m4e_fmi.report import progress_bar

    if _for_programs():
        with _progress_events(stop_time, start) as told:
            yield told
    elif _for_people():
        with progress_bar(stop_time, start=start) as told:
            yield told
    else:
        yield _unseen


@contextmanager
def runs_progress() -> Generator[Callable[[int, int], None] | None]:
    """A callable to be told the runs that are done and all: a bar, or events for programs."""
    from m4e_fmi.study.shown.progress import runs_bar

    if _for_programs():
        yield lambda done, total: tell_event(Runs(done, total))
    elif _for_people():
        with runs_bar() as told:
            yield told
    else:
        yield None


def _for_programs() -> bool:
    return any(isinstance(one, ForPrograms) for one in LOG.handlers)


def _for_people() -> bool:
    return any(isinstance(one, ForPeople) and one.level < logging.WARNING for one in LOG.handlers)


def _unseen(_: float) -> None:
    pass


@contextmanager
def _progress_events(stop_time: float, start: float) -> Generator[Callable[[float], None]]:
    """Events of progress: the first, one in each INTERVAL, the last."""
    began, last = time.perf_counter(), -INTERVAL
    waiting: float | None = None

    def emit(t: float) -> None:
        nonlocal last
        last = time.perf_counter() - began
        span = stop_time - start
        tell_event(Progress(t, (t - start) / span if span else 1.0, (t - start) / max(last, 1e-9)))

    def report(t: float) -> None:
        nonlocal waiting
        waiting = t
        if time.perf_counter() - began - last >= INTERVAL:
            emit(t)
            waiting = None

    yield report
    if waiting is not None:
        emit(waiting)
