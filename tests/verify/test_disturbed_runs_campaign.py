"""Runs disturbed at random: every row that is left equals the undisturbed run's, bit for bit."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.disturbed import (
    FAST,
    check_left,
    check_rows,
    commanded,
    killed,
    running,
    write_system,
)
from support.small_systems import Fmus

from m4e_fmi.cosim import load_system, run
from m4e_fmi.results.results_file import Results, load

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


@pytest.mark.parametrize("number", range(10))
def test_changed_folder(number: int, c_fmu: Fmus, tmp_path: Path, whole: Results) -> None:
    """An FMU goes to another folder at some time; once the folder that was left is removed."""
    chance = generator(number)
    name = chance.choice(["r.nc", "r.csv", "r.parquet"])
    system = write_system(c_fmu, tmp_path, {"what": 1, "when": chance.uniform(0, FAST[0])})
    unpacked = tmp_path / "unpacked"
    unpacked.mkdir()
    environment = {**os.environ, "TMPDIR": str(unpacked)}
    done = subprocess.run(
        commanded(Path(system.name), name),
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    check_rows(load(tmp_path / "r.nc"), whole, least=len(whole.time))
    there = {p.name for p in tmp_path.iterdir()}
    assert there == {"system.yaml", "unpacked", "r.nc", "r.png", name}
    assert not list(unpacked.iterdir())


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
    results = load(tmp_path / "r.nc")
    assert len(results.time) > 1
    assert sys.float_info.max > abs(results["body.body.m.x"].values).max()
