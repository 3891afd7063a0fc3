"""Runs disturbed at random: every row that is left equals the undisturbed run's, bit for bit."""

from __future__ import annotations

import contextlib
import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from support.disturbed import (
    FAST,
    check_left,
    check_rows,
    commanded,
    killed,
    running,
    until,
    write_system,
)

from m4e_fmi.cosim import load_system, run
from m4e_fmi.results.results_file import Results, load_results

Fmus = Callable[[str], Path]
SEED = int(os.environ.get("SEED", "20261122"))
OLD = b"results of an earlier run"


@pytest.fixture(scope="module")
def whole(c_fmu: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Results of the undisturbed run."""
    folder = tmp_path_factory.mktemp("whole")
    print("seed", SEED)
    return run(load_system(write_system(c_fmu, folder)), results=folder / "r.nc").results()


def generator(number: int) -> random.Random:
    return random.Random(f"{SEED} {number}")


@pytest.mark.parametrize("number", range(45))
def test_killed(number: int, c_fmu: Fmus, tmp_path: Path, whole: Results) -> None:
    """Fifteen each: inside a write of rows, at any time, while the file takes its final form."""
    chance = generator(number)
    plan: dict[str, float] = {"flush": chance.choice([0.0, 0.02, 0.1])}
    if number % 3 == 0:
        plan |= {"write": chance.randrange(12), "part": chance.random()}
    elif number % 3 == 1:
        plan |= {"after": chance.uniform(0.0, 1.5)}
    else:
        plan |= {"block": chance.randrange(5)}
    path = tmp_path / "r.nc"
    path.write_bytes(OLD)
    system = write_system(c_fmu, tmp_path)
    killed(system, path, plan)
    count = check_left(path, whole, OLD, least=len(whole.time) if "block" in plan else 0)
    print(plan, count, "rows")
    again = load_system(system).changed(stop_time=0.1, step_size=0.002)
    run(again, results=path)
    assert {p.name for p in tmp_path.glob(".*r.nc*")} == set()


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[None]:
    """A disk of `size` bytes; where none can be mounted, no file may be longer."""
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if os.geteuid() == 0 and subprocess.run(command, check=False).returncode == 0:
        try:
            yield
        finally:
            subprocess.run(["umount", "-l", str(folder)], check=True)
        return
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("number", range(10))
def test_full_disk(number: int, c_fmu: Fmus, tmp_path: Path, whole: Results) -> None:
    """The message tells how far the rows in the file go; what there is room for is complete."""
    chance = generator(number)
    row = 8 * (1 + len(whole.series))
    size = int(row * len(whole.time) * chance.uniform(0.1, 2.2))
    disk = tmp_path / "disk"
    disk.mkdir()
    system = write_system(c_fmu, tmp_path)
    with small_disk(disk, size):
        command = commanded(system, "disk/r.nc")
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        path = disk / "r.nc"
        count = 0
        if path.exists():
            found = load_results(path)
            check_rows(found, whole)
            count = len(found.time)
            until_ = f"results until t = {found.time[-1]:.9g} s are in disk/r.nc"
            if done.returncode:
                assert until_ in done.stderr
                assert found.attributes["ended"].startswith("failed: ")
        if not done.returncode:
            assert count == len(whole.time)
        else:
            assert "disk/r.nc: cannot be written" in done.stderr
            assert path.exists() or "results until" not in done.stderr
    print(size, "bytes:", count, "rows, exit code", done.returncode)


@pytest.mark.parametrize("number", range(10))
def test_second_run(number: int, c_fmu: Fmus, tmp_path: Path, whole: Results) -> None:
    """Others that want the same files end at once; the first comes to its end undisturbed."""
    chance = generator(number)
    names = [f"r.{chance.choice(['nc', 'csv'])}" for _ in range(3)]
    system = write_system(c_fmu, tmp_path)
    command = commanded(system, names[0])
    refused = 0
    with subprocess.Popen(command, cwd=tmp_path) as first:
        until(lambda: (tmp_path / ".r.nc.m4e-lock").exists())
        for name in names[1:]:
            time.sleep(chance.uniform(0.0, 0.3))
            second = subprocess.run(
                commanded(system, name, "--stop-time", "1"),
                cwd=tmp_path, capture_output=True, text=True, check=False,
            )  # fmt: skip
            if second.returncode:
                assert second.returncode == 1
                assert f"r.nc: another run writes it (process {first.pid} on" in second.stderr
                refused += 1
            else:  # it came after the first
                assert first.wait() == 0
        assert first.wait() == 0
    print(names, refused, "refused")
    if refused == len(names) - 1:
        found = load_results(tmp_path / "r.nc")
        check_rows(found, whole, least=len(whole.time))
        assert found.attributes["ended"] == "at the stop time"


@pytest.mark.parametrize("number", range(10))
def test_changed_folder(number: int, c_fmu: Fmus, tmp_path: Path, whole: Results) -> None:
    """An FMU goes to another folder at some time; once the folder that was left is removed."""
    chance = generator(number)
    name = chance.choice(["r.nc", "r.csv"])
    system = write_system(c_fmu, tmp_path, {"what": 1, "when": chance.uniform(0, FAST[0])})
    unpacked = tmp_path / "unpacked"
    unpacked.mkdir()
    environment = {**os.environ, "TMPDIR": str(unpacked)}
    done = subprocess.run(
        commanded(Path(system.name), name),
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    check_rows(load_results(tmp_path / "r.nc"), whole, least=len(whole.time))
    there = {p.name for p in tmp_path.iterdir()}
    assert there == {"system.yaml", "unpacked", "r.nc", "r.png", name}
    assert not list(unpacked.iterdir())


@contextlib.contextmanager
def heeded(number: signal.Signals) -> Iterator[None]:
    """Processes that begin meanwhile do not ignore a signal: under nohup they ignore SIGHUP."""
    before = signal.signal(number, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(number, before)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_signals(number: signal.Signals, c_fmu: Fmus, tmp_path: Path) -> None:
    """Thousands of steps at once are fast; then each takes 0.2 s, and a signal ends the run."""
    harm = {"what": 3, "when": 1000.0, "pause": 0.2}
    system = write_system(c_fmu, tmp_path, harm, times=(1e6, 0.01))
    with heeded(number), running(system, "r.nc") as process:
        until(lambda: load_results(tmp_path / "r.nc").time[-1] >= 1000.0)
        began = time.monotonic()
        process.send_signal(number)
        assert process.wait(30) == 128 + number
        assert time.monotonic() - began < 10.0
    ended = "interrupted" if number == signal.SIGINT else f"ended by {number.name}"
    assert load_results(tmp_path / "r.nc").attributes["ended"] == ended


def test_a_step_without_end_ends_with_the_process(c_fmu: Fmus, tmp_path: Path) -> None:
    """SIGTERM waits ten seconds for a step of an hour, and the rows stay."""
    harm = {"what": 3, "when": 1000.0, "pause": 3600.0}
    system = write_system(c_fmu, tmp_path, harm, times=(1e6, 0.01))
    with running(system, "r.nc") as process:
        time.sleep(2.0)
        began = time.monotonic()
        process.send_signal(signal.SIGTERM)
        _, error = process.communicate(timeout=60)
        assert 9.0 < time.monotonic() - began < 30.0
    assert process.returncode == 128 + signal.SIGTERM
    assert "ended by SIGTERM: a call of an FMU did not end within 10 s" in error
    results = load_results(tmp_path / "r.nc")
    assert len(results.time) > 1
    assert sys.float_info.max > abs(results["body.body.m.x"].values).max()
