"""Processes of a study end when they are asked to, whatever they do."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.context import SpawnProcess
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import SimpleNamespace

import pytest

from m4e_fmi.signals import ending_cleanly
from m4e_fmi.study.systems import execution

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM")


def asked_to_end_in_a_run(marker: Path) -> None:
    """A run that SIGTERM ends, in a process of a study."""

    def run(*_: object) -> None:
        with ending_cleanly():
            signal.raise_signal(signal.SIGTERM)

    execution.perform = run  # pyright: ignore[reportAttributeAccessIssue]
    execution._perform(SimpleNamespace())  # pyright: ignore[reportArgumentType]
    marker.touch()


def deaf(marker: Path) -> None:
    """A run that does not hear SIGTERM, as one inside the code of an FMU."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    marker.touch()
    time.sleep(60.0)


def slow() -> None:
    """What a process does before it takes runs."""
    time.sleep(20.0)


def test_nobody_waits_for_processes_that_had_nothing_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As where all runs are kept: they may take seconds until they are ready."""
    monkeypatch.setattr(execution, "_worker", slow)
    begun = time.monotonic()
    with execution.performing(1) as perform:
        assert list(perform([])) == []
    assert time.monotonic() - begun < 15.0


def test_sigterm_is_no_result_of_a_run(tmp_path: Path) -> None:
    """A process that lives on would wait for locks of processes that are dead."""
    with execution._processes(1) as pool:
        future = pool.submit(asked_to_end_in_a_run, tmp_path / "went_on")
        with pytest.raises(execution.BrokenExecutor):
            future.result(30.0)
    assert not (tmp_path / "went_on").exists()


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
    end = time.monotonic() + 10.0
    while is_there(process.pid) and time.monotonic() < end:
        time.sleep(0.05)
    assert not is_there(process.pid)


def test_processes_do_not_run_the_script_that_begins_them(tmp_path: Path) -> None:
    """It has no ``if __name__ == "__main__"``: each process would begin others, and die."""
    script = tmp_path / "script.py"
    script.write_text(
        "import os\n"
        "from m4e_fmi.study.systems import execution\n"
        "print('begun', flush=True)\n"
        "with execution._processes(1) as pool:\n"
        "    print(pool.submit(os.getenv, 'OMP_NUM_THREADS').result())\n",
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "begun\n1\n", "")


def test_the_script_is_in_its_place_after_threads_have_begun_processes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two studies in threads of one process: the one would put back what the other has set."""
    script, threads = sys.modules["__main__"], os.environ.get("OMP_NUM_THREADS")

    def start(_: object) -> None:
        time.sleep(0.02)

    monkeypatch.setattr(SpawnProcess, "start", start)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: execution._Process().start(), range(8)))
    assert sys.modules["__main__"] is script
    assert os.environ.get("OMP_NUM_THREADS") == threads


def is_there(process: int | None) -> bool:
    """True of a process that runs. Its exit code may be told to another thread of the pool."""
    assert process is not None
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_interruption_does_not_reach_a_process_that_begins() -> None:
    """It would end with a traceback; its parent tells of the interruption, and ends it."""
    with execution._processes(1) as pool:
        for number in pool._processes:
            os.kill(number, signal.SIGINT)
        assert pool.submit(abs, -1).result(30.0) == 1
        assert pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result(30.0) == set()
