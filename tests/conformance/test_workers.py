"""FMUs in workers that do harm: what is said, what is left, and who is disturbed.

All kinds of faults in all calls: test_faulty_runs.py.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.c_fmus.build import trouble_file

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.worker import Host, keeper, process
from m4e_fmi.results.results_file import load

Fmus = Callable[[str], Path]
SHORT = Host(call=1.0, end=1.0)


@pytest.fixture
def armed(c_fmu: Fmus) -> Fmus:
    """FMUs that can be armed by `trouble_file`, and are not yet."""

    def found(name: str) -> Path:
        fmu = c_fmu(name)
        trouble_file(fmu).unlink(missing_ok=True)
        return fmu

    return found


def masses(mass: Path, spring: Path, algorithm: str = "jacobi", stop_time: float = 1.0) -> Prepared:
    """A mass on a spring, the mass in a worker with limits of a second."""
    system = System(
        "masses",
        (
            Component("body", FmuFile(mass), {"body.m.x": 1.0}),
            Component("wall", FmuFile(spring)),
        ),
        ("body.body.m <-> wall.end",),
        Simulation(stop_time, 0.01, algorithm),
    )
    prepared = prepare(system)
    assert prepared.hosts.keys() >= {"body"}
    return replace(prepared, hosts=dict.fromkeys(prepared.hosts, SHORT))


def children() -> list[str]:
    """Commands of all processes that workers and their keeper have left, but for the keeper."""
    found = subprocess.run(
        ["ps", "-eo", "ppid=,pid=,stat=,args="], capture_output=True, text=True, check=True
    ).stdout
    rows = [line.split(None, 3) for line in found.splitlines()]
    own = {pid for ppid, pid, *_ in rows if ppid == str(os.getpid())}
    return [
        " ".join(row) for row in rows if "keeper.py" in row[3] and row[1] not in own
        and (row[0] in own or row[0] == "1") and not row[2].startswith("Z")
    ]  # fmt: skip


def rows_of(path: Path) -> dict[str, np.ndarray]:
    return {name: series.values for name, series in load(path).series.items()}


def test_runs_undisturbed(armed: Fmus, c_fmu: Fmus, tmp_path: Path) -> None:
    prepared = masses(armed("mass+state+armed"), c_fmu("spring+state"))
    run(prepared, results=tmp_path / "apart.nc")
    run(replace(prepared, hosts={}), results=tmp_path / "here.nc")
    apart, here = rows_of(tmp_path / "apart.nc"), rows_of(tmp_path / "here.nc")
    assert apart.keys() == here.keys()
    assert all((apart[name] == here[name]).all() for name in here)
    assert children() == []


@pytest.mark.parametrize(
    ("trouble", "said"),
    [
        ("terminate segv", "SIGSEGV in fmi2Terminate"),
        ("free words", "SIGABRT in fmi2FreeInstance: out of oil"),
    ],
)
def test_harm_at_the_end_says_that_the_results_are_complete(
    armed: Fmus, c_fmu: Fmus, tmp_path: Path, trouble: str, said: str
) -> None:
    """And the last words of the process."""
    mass = armed("mass+state+armed")
    trouble_file(mass).write_text(f"{trouble} 0")
    with pytest.raises(RunError, match=re.escape(said)) as raised:
        run(masses(mass, c_fmu("spring+state")), results=tmp_path / "r.nc")
    assert f"the results are complete in {tmp_path / 'r.nc'} (101 rows)" in str(raised.value)
    assert len(load(tmp_path / "r.nc").time) == 101


ESTIMATING = (
    "body (mass_state_armed.fmu): can no longer be used: its process was ended by SIGKILL in "
    "fmi2DoStep; the run was at t = {} s, where its coupling error is estimated"
)


@pytest.mark.parametrize(("stop", "point"), [(1.0, 1.0), (22.0, 20.48)])
def test_harm_in_repeated_steps_names_the_point_of_the_run(
    armed: Fmus, c_fmu: Fmus, tmp_path: Path, stop: float, point: float
) -> None:
    """At the end the run is complete without its error; before, it cannot go on."""
    mass = armed("mass+state+armed")
    prepared = masses(mass, c_fmu("spring+state"), "gauss_seidel", stop_time=stop)

    def arm(time: float, _: object) -> None:
        if time == point:
            trouble_file(mass).write_text("step kill 0")

    if stop == point:
        outcome = run(prepared, results=tmp_path / "r.nc", observers=[arm])
        assert outcome.certificate == ESTIMATING.format("1")
        assert outcome.results().attributes["ended"] == "at the stop time"
    else:
        with pytest.raises(RunError) as caught:
            run(prepared, results=tmp_path / "r.nc", observers=[arm])
        assert caught.value.message == ESTIMATING.format("20.48")
        assert caught.value.remedy.startswith("an FMU seldom does that itself")
    assert load(tmp_path / "r.nc").time[-1] == point


def test_components_step_side_by_side(c_fmu: Fmus, armed: Fmus) -> None:
    """Each step of both takes 5 ms: together as long as one."""
    fmu, other = c_fmu("vandal"), armed("vandal+armed")
    start = {"what": 3, "when": 0.0, "pause": 0.005}
    components = (
        Component("a", FmuFile(fmu), start, process="own"),
        Component("b", FmuFile(other), start),
    )
    prepared = prepare(System("both", components, (), Simulation(1.0, 0.01, "jacobi")))
    assert prepared.hosts.keys() == {"a", "b"}

    def share() -> float:
        """Time together over that one after the other; other work on the machine may delay both."""
        apart, after = run(prepared), run(replace(prepared, hosts={}))
        assert after.wall_time > 1.0
        return apart.wall_time / after.wall_time

    assert any(share() < 0.85 for _ in range(5))


def test_a_killed_master_leaves_nothing(armed: Fmus, tmp_path: Path) -> None:
    mass, spring = armed("mass+state+armed"), armed("spring+state+armed")
    trouble_file(mass).write_text("step stop 0.5")
    (tmp_path / "system.yaml").write_text(
        f"""name: killed
components:
  a: {{fmu: {mass}, start: {{body.m.x: 1}}}}
  b: {{fmu: {spring}}}
connections: [a.body.m <-> b.end]
simulation: {{stop_time: 1, step_size: 0.01}}
"""
    )
    folder = tmp_path / "temporary"
    folder.mkdir()
    command = [sys.executable, "-c", "from m4e_fmi.cli import main; main()", "run", "system.yaml"]
    environment = {**os.environ, "TMPDIR": str(folder)}
    master = subprocess.Popen(command, cwd=tmp_path, env=environment, start_new_session=True)
    deadline = time.monotonic() + 60.0
    while not (found := _stopped_below(master.pid)) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert found
    master.kill()
    master.wait()
    while any(Path(f"/proc/{process}").exists() for process in found) or list(folder.iterdir()):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def _keeper() -> int:
    """Number of the process that keeps the workers of this one."""
    keeper = process._keepers[os.getpid()]
    assert keeper.is_alive
    return keeper._process.pid


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_signals_to_all_processes_leave_the_end_to_the_master(
    armed: Fmus, c_fmu: Fmus, tmp_path: Path, number: signal.Signals
) -> None:
    """As batch systems and service managers send them: it may still write a checkpoint."""
    prepared = masses(armed("mass+state+armed"), c_fmu("spring+state"))
    run(prepared, results=tmp_path / "whole.nc")

    def send(time: float, _: object) -> None:
        if time == 0.5:
            (worker,) = process._keepers[os.getpid()].workers.values()
            for other in (_keeper(), worker._process):
                os.kill(other, number)

    run(prepared, results=tmp_path / "disturbed.nc", observers=[send])
    whole, disturbed = rows_of(tmp_path / "whole.nc"), rows_of(tmp_path / "disturbed.nc")
    assert all((disturbed[name] == whole[name]).all() for name in whole)


def test_a_worker_too_many_leaves_the_others(armed: Fmus, c_fmu: Fmus) -> None:
    resource = pytest.importorskip("resource")
    prepared = masses(armed("mass+state+armed"), c_fmu("spring+state"))
    run(prepared)
    keeper = _keeper()
    usual = resource.prlimit(keeper, resource.RLIMIT_NOFILE)
    few = len(list(Path(f"/proc/{keeper}/fd").iterdir()))
    resource.prlimit(keeper, resource.RLIMIT_NOFILE, (few, usual[1]))
    try:
        with pytest.raises(RunError, match="no process can be started for it: Too many open files"):
            run(prepared)
    finally:
        resource.prlimit(keeper, resource.RLIMIT_NOFILE, usual)
    run(prepared)
    assert _keeper() == keeper


@pytest.mark.skipif(sys.platform != "linux", reason="processes are in /proc")
def test_the_children_of_a_worker_are_ended_while_its_number_is_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A number that is free may soon be another group's."""
    kept, (output, inner) = keeper.Keeper(), os.pipe()
    worker = os.posix_spawn("/bin/true", ["true"], {})
    os.close(inner)
    kept._workers[0] = keeper._Kept(0, worker, output)
    found: list[bool] = []

    def note(process: int) -> None:
        found.append(Path(f"/proc/{process}").exists())

    monkeypatch.setattr(keeper, "kill_children", note)
    while kept._workers:
        kept._look(kept._workers[0])
    assert found == [True]


def test_an_fmu_that_writes_into_the_shared_memory_is_still_watched(
    armed: Fmus, c_fmu: Fmus
) -> None:
    mass = armed("mass+state+armed")
    prepared = masses(mass, c_fmu("spring+state"))
    trouble_file(mass).write_text("step sleep 0.5")

    def damage() -> None:
        for worker in process._keepers[os.getpid()].workers.values():
            worker._channel.present = 2**31

    timer = threading.Timer(0.7, damage)

    def begin(time: float, _: object) -> None:
        if time == 0.5:
            timer.start()

    with pytest.raises(RunError, match="did not return within 1 s"):
        run(prepared, observers=[begin])
    timer.join()


def test_the_limit_of_the_end_is_that_of_terminating_and_freeing_the_fmu(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Freeing a saved state is a call of the run."""
    ended: list[str] = []
    monkeypatch.setattr(process.Worker, "end", lambda worker, _: ended.append(worker.call))
    worker = object.__new__(process.Worker)
    worker.name, worker.host, worker._seen = "slow", Host(call=9.0, end=1.0), -1
    names = process.function_names()
    for number in range(len(names) + 2):
        worker._channel = process.Channel(busy=1, present=number, calls=number)
        worker.look(0.0)
        worker.look(2.0)
    kinds = ("TerminateSlave", "FreeSlaveInstance"), ("Terminate", "FreeInstance")
    versions = zip(("fmi", "fmi2", "fmi3"), (*kinds, kinds[1]), strict=True)
    last = {f"{prefix}{name}" for prefix, of_kind in versions for name in of_kind}
    assert set(ended) == last | {"unloading its library"}


def _stopped_below(master: int) -> list[str]:
    """Numbers of the keeper and the workers of a master in which a worker is stopped, if one is."""
    text = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,stat="], capture_output=True, text=True, check=True
    ).stdout
    rows = [line.split() for line in text.splitlines()]
    keepers = [pid for pid, parent, _ in rows if parent == str(master)]
    workers = [(pid, state) for pid, parent, state in rows if parent in keepers]
    return [*keepers, *(p for p, _ in workers)] if any("T" in s for _, s in workers) else []
