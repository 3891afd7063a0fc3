"""Executors: no run is lost, and none is made twice, when one breaks."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

import pytest

from m4e_fmi.study.runs.record import Record
from m4e_fmi.study.systems import execution
from m4e_fmi.study.systems.task import Blob, Task

DONE = Record(values={"x": 1.0})


def task(key: str) -> Task:
    return Task(key, Blob("0"), {}, {}, 1.0, (), (), 0.0, certify=False)


class Breaking(Executor):
    """An executor that makes `count` calls, and is broken from the next one on."""

    def __init__(self, count: int) -> None:
        self.left = count

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ARG002
        if not self.left:
            raise BrokenProcessPool("a process died")
        self.left -= 1
        future: Future[Any] = Future()
        future.set_result(DONE)
        return future


@pytest.mark.parametrize("count", range(6))
def test_every_run_is_made_once_where_a_pool_breaks_between_two(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process may die after the last answer was read: the next call is refused then."""
    pools = iter([Breaking(count)])

    @contextmanager
    def processes(_: int) -> Generator[Executor]:
        yield next(pools, Breaking(100))

    monkeypatch.setattr(execution, "_processes", processes)
    tasks = [(k, task(str(k))) for k in range(5)]
    with execution.performing(1) as perform:
        found = [number for number, _ in perform(tasks)]
    assert sorted(found) == [0, 1, 2, 3, 4]


def test_windows_waits_for_no_more_processes_than_it_can(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[int]()

    @contextmanager
    def noted(jobs: int) -> Generator[None]:
        asked.append(jobs)
        yield

    monkeypatch.setattr(execution, "_processes", noted)
    for system in ("win32", "linux"):
        monkeypatch.setattr(execution.sys, "platform", system)
        with execution.performing(128):
            pass
    assert asked == [execution.MOST_ON_WINDOWS, 128]
