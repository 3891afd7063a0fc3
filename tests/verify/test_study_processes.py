"""Processes of studies: killed, dying, and those of Dask, which share no folder."""

from __future__ import annotations

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from support.small_study import Here, written_study

from m4e_fmi.study import run_study
from m4e_fmi.study.record import Record
from m4e_fmi.study.run import STORE
from m4e_fmi.study.systems import execution

STUDY = """\
name: carts
system: system.yaml
start_up: 0.2
vary:
  pto.damping: [2, 6]
  cart.k: {from: 30, to: 50, step: 4}
wanted:
  power: {variable: pto.power, statistic: mean}
"""
SMALL = """\
name: carts
system: system.yaml
vary: {pto.damping: [2, 4, 6], cart.k: [30, 50]}
wanted: {force: {variable: pto.force, statistic: maximum}}
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_no_run_is_lost_or_made_twice_after_a_kill(tmp_path: Path) -> None:
    path = written_study(tmp_path, STUDY)
    command = [sys.executable, "-m", "m4e_fmi", "study", str(path), "--jobs", "1"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
        store = tmp_path / "build" / STORE
        until = time.monotonic() + 60.0
        while kept(store) < 2 and time.monotonic() < until and process.poll() is None:
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
    before = rows(store)
    assert 2 <= len(before) < 12
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert f"12 runs, {12 - len(before)} made, {len(before)} kept from before" in done.stdout
    after = rows(store)
    assert len(after) == 12
    assert before.items() <= after.items()


def kept(store: Path) -> int:
    try:
        return len(rows(store))
    except sqlite3.Error:
        return 0


def rows(store: Path) -> dict[str, float]:
    """Wall times of kept runs by key: of a run that is made again they would differ."""
    if not store.is_file():
        return {}
    with sqlite3.connect(store) as base:
        found = base.execute("SELECT key, head FROM runs").fetchall()
    return {key: json.loads(head)["wall_time"] for key, head in found}


def test_workers_of_dask_give_the_same_bits(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    path = written_study(tmp_path, SMALL)
    here = run_study(path, build_directory=tmp_path / "here", executor=Here())
    with (
        execution._one_thread(),
        distributed.LocalCluster(
            n_workers=3, threads_per_worker=1, dashboard_address=None, local_directory=tmp_path
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        away = run_study(
            path, build_directory=tmp_path / "away", executor=client.get_executor(), jobs=3
        )
    for name in ("force", "coupling_error"):
        np.testing.assert_array_equal(here.data[name], away.data[name])


@dataclass(frozen=True)
class Fatal:
    """A task that ends the process which makes it, if it is `deadly`."""

    deadly: bool


def perform(task: Fatal, _: Mapping[str, bytes] | None = None) -> Record:
    if task.deadly:
        os._exit(9)
    return Record(values={"pid": float(os.getpid())})


def test_a_process_that_dies_costs_its_own_run_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execution, "_perform", perform)
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=os.pathsep)
    tasks = [(k, Fatal(k == 2)) for k in range(6)]
    with execution.performing(1) as made_by:
        found = dict(made_by(tasks))  # pyrefly: ignore[bad-argument-type]
    assert sorted(found) == list(range(6))
    assert {k for k, record in found.items() if record.failure} == {2}
    assert found[2].failure == execution.DIED
