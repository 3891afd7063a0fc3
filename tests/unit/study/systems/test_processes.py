"""Processes of a study: no run is lost or made twice when one dies, and all end when asked to."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from m4e_fmi.signals import ending_cleanly
from m4e_fmi.study.record import Record
from m4e_fmi.study.systems import execution
from m4e_fmi.study.systems.task import Blob, Task

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")


class Breaking(Executor):
    """An executor that makes `count` calls, and is broken from the next one on."""

    def __init__(self, count: int) -> None:
        self.left = count

    # pyrefly: ignore[bad-override]
    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ARG002
        if not self.left:
            raise BrokenProcessPool("a process died")
        self.left -= 1
        future: Future[Any] = Future()
        future.set_result(Record(values={"x": 1.0}))
        return future


@pytest.mark.parametrize("count", range(6))
def test_every_run_is_made_once_where_a_pool_breaks_between_two(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process may die after the last answer was read: the next call is refused then."""
    pools, asked = iter([Breaking(count)]), list[int]()

    @contextmanager
    def processes(jobs: int) -> Generator[Executor]:
        asked.append(jobs)
        yield next(pools, Breaking(100))

    monkeypatch.setattr(execution, "_processes", processes)
    monkeypatch.setattr(execution.sys, "platform", "win32")  # it waits for a few processes only
    tasks = [
        (k, Task(str(k), Blob("0"), {}, {}, 1.0, (), (), 0.0, certify=False)) for k in range(5)
    ]
    with execution.performing(128) as perform:
        found = [number for number, _ in perform(tasks)]
    assert sorted(found) == [0, 1, 2, 3, 4]
    assert asked[0] == execution.MOST_ON_WINDOWS


def asked_to_end_in_a_run(marker: Path) -> None:
    """A run that SIGTERM ends, in a process of a study."""

    def run(*_: object) -> None:
        with ending_cleanly():
            signal.raise_signal(signal.SIGTERM)

    execution.perform = run  # pyrefly: ignore[bad-assignment]
    execution._perform(SimpleNamespace())  # pyrefly: ignore[bad-argument-type]
    marker.touch()


def deaf(marker: Path) -> None:
    """A run that does not hear SIGTERM, as one inside the code of an FMU."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    marker.touch()
    time.sleep(60.0)


@posix
def test_sigterm_is_no_result_of_a_run_and_interruption_reaches_the_parent_only(
    tmp_path: Path,
) -> None:
    """A process that lives on after SIGTERM would wait for locks of processes that are dead."""
    with execution._processes(1) as pool:
        for number in pool._processes:
            os.kill(number, signal.SIGINT)
        assert pool.submit(abs, -1).result(30.0) == 1
        assert pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result(30.0) == set()
        future = pool.submit(asked_to_end_in_a_run, tmp_path / "went_on")
        with pytest.raises(execution.BrokenExecutor):
            future.result(30.0)
    assert not (tmp_path / "went_on").exists()


@posix
def test_a_process_that_does_not_hear_is_killed(tmp_path: Path) -> None:
    marker = tmp_path / "runs"
    found: list[BaseProcess] = []

    def interrupted() -> None:
        with execution._processes(1) as pool:
            pool.submit(deaf, marker)
            while not marker.exists():
                time.sleep(0.02)
            found.extend(pool._processes.values())
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    (process,) = found

    def ask() -> None:  # its exit code may be told to another thread of the pool
        for _ in range(200):
            os.kill(process.pid or 0, 0)
            time.sleep(0.05)

    with pytest.raises(ProcessLookupError):
        ask()


def test_processes_do_not_run_the_script_that_begins_them(tmp_path: Path) -> None:
    """It has no ``if __name__ == "__main__"``: each process would begin others, and die."""
    script = tmp_path / "script.py"
    script.write_text(
        "import os, sys\n"
        "from m4e_fmi.study.systems import execution\n"
        "print('begun', flush=True)\n"
        "main = sys.modules['__main__']\n"
        "with execution._processes(1) as pool:\n"
        "    print(pool.submit(os.getenv, 'OMP_NUM_THREADS').result())\n"
        "print(sys.modules['__main__'] is main)\n",
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "begun\n1\nTrue\n", "")
