"""`m4e-fmi run` where something fails: exit code, what is said, what is left on the disk.

Full and read-only disks: test_disks.py.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cli import main
from m4e_fmi.results.results_file import load


def pump(what: int) -> dict[str, Any]:
    """An FMU that does something at t = 0.5 s: see rogue.c."""
    return {"fmu": "rogue.fmu", "start": {"what": what, "when": 0.5}}


@dataclass(frozen=True)
class Failure:
    """A system that fails; `says` are patterns: what, where, when, what to do. `end` [s]."""

    components: Mapping[str, Mapping[str, Any]]
    says: tuple[str, ...]
    end: float
    connections: tuple[str, ...] = ()
    simulation: Mapping[str, Any] = field(default_factory=dict)


RING = ("a.y -> b.u", "b.y -> a.u")
INTEGRATORS = {
    name: {"fmu": "integrator_state.fmu", "start": {"gain": 1e12, "y": start}}
    for name, start in {"a": 1.0, "b": 0.0}.items()
}
STEP = r"t = 0\.[45] s"
SMALLER = "step_size"
FIRST = "      fix the problem stated by the FMU first; results"
FAILURES = {
    "nan": Failure({"pump": pump(9)}, (r"pump\.y", "is nan", r"t = 0\.5 s", SMALLER), 0.4),
    "infinite": Failure({"pump": pump(8)}, (r"pump\.y", "is inf", r"t = 0\.5 s", SMALLER), 0.4),
    "discard": Failure({"pump": pump(2)}, ("pump", "Discard", STEP, SMALLER), 0.4),
    "error": Failure({"pump": pump(3)}, ("pump", "Error", "the pump ran dry", STEP, FIRST), 0.4),
    "fatal": Failure({"pump": pump(4)}, ("pump", "Fatal", "the pump ran dry", STEP, FIRST), 0.4),
    "missed tolerance": Failure(
        INTEGRATORS,
        (
            r"[ab]\.[uy]",
            "stays above coupling_tolerance",
            r"t = \S+ s",
            "remove coupling_tolerance",
        ),
        0.0,
        RING,
        {"algorithm": "corrector", "coupling_tolerance": 1e-4},
    ),
    # over half a step a.y = 1 + (0 + b.y), b.y = 0 + (1 + a.y)
    "unsolved loop": Failure(
        {
            "a": {"fmu": "integrator_state.fmu", "start": {"gain": 40.0, "y": 1.0}},
            "b": {"fmu": "integrator_state.fmu", "start": {"gain": 40.0}},
        },
        (r"[ab]\.u", r"t = 0(\.1)? s", "step_size|gain|loop"),
        0.0,
        RING,
        {"algorithm": "implicit"},
    ),
}


@pytest.fixture
def project(
    c_fmu: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[Failure], None]:
    """Writes a failing system's file into the folder in which we are."""
    monkeypatch.chdir(tmp_path)

    def write(failure: Failure) -> None:
        components = {}
        for name, component in failure.components.items():
            stem = Path(component["fmu"]).stem.replace("_", "+")
            components[name] = {**component, "fmu": str(c_fmu(stem))}
        simulation = {"stop_time": 1.0, "step_size": 0.1, "algorithm": "jacobi"}
        content = {
            "name": "failing",
            "components": components,
            "connections": list(failure.connections),
            "simulation": {**simulation, **failure.simulation},
        }
        Path("system.yaml").write_text(json.dumps(content))

    return write


@pytest.mark.parametrize("failure", FAILURES.values(), ids=FAILURES)
def test_a_failing_run(
    failure: Failure, project: Callable[[Failure], None], capsys: pytest.CaptureFixture[str]
) -> None:
    project(failure)
    assert main(["run", "system.yaml", "--output-file", "r.nc"]) == 1
    error = capsys.readouterr().err
    for pattern in failure.says:
        assert re.search(pattern, error), (pattern, error)
    results = load("r.nc")
    assert f"results until t = {results.time[-1]:.9g} s are in r.nc" in error
    # adaptive steps end at a millionth of the step
    assert results.time[-1] == pytest.approx(failure.end, abs=1e-6)
    assert results.attributes["ended"].startswith("failed: ")
    series = [one for group in results.components.values() for one in group.values()]
    assert all(np.isfinite(one.values).all() for one in series)


MODEL = """\
name: mass
bodies: {m: {mass: 10, inertia: 1}}
joints: {rail: {type: prismatic, child: m, direction: [1, 0], initial: {q: 1}}}
loads: {push: {type: joint_effort, joint: rail, effort: "-10*joint.rail.q + 5*sqrt(0.42 - t)"}}
"""


@pytest.mark.parametrize("algorithm", ["gauss_seidel", "corrector"])
@pytest.mark.parametrize("native", ["--native", "--no-native"])
def test_an_fmu_of_ours_that_cannot_make_a_step_has_failed(
    native: str,
    algorithm: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """It does not ask for the end of the simulation, as PythonFMU's library has it."""
    monkeypatch.chdir(tmp_path)
    Path("mass.model.yaml").write_text(MODEL)
    Path("system.yaml").write_text(
        "name: failing\ncomponents: {mass: {model: mass.model.yaml}}\n"
        f"simulation: {{stop_time: 1, step_size: 0.1, algorithm: {algorithm}}}\n"
    )
    assert main(["run", "system.yaml", "--output-file", "r.nc", native]) == 1
    error = capsys.readouterr().err
    told = r"failed: mass \(mass.fmu\): the step from t = (\S+) s to .*: a state or its rate is not"
    found = re.search(told, error)
    assert found, error
    reached = 0.4 if algorithm == "gauss_seidel" else 0.42  # by shorter steps
    assert float(found[1]) == pytest.approx(reached, abs=1e-6)
    assert "results until t = 0.4 s are in r.nc" in error
    results = load("r.nc")
    assert results.time[-1] == pytest.approx(0.4)
    assert results.attributes["ended"].startswith("failed: mass")


@contextlib.contextmanager
def left(name: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Within it, the reader of a stream of `sys` has left."""
    reading, writing = os.pipe()
    os.close(reading)
    with monkeypatch.context() as patch, os.fdopen(writing, "w", buffering=1) as stream:
        patch.setattr(sys, name, stream)
        yield


@pytest.mark.parametrize("names", [("stderr",), ("stdout",), ("stdout", "stderr")])
def test_a_run_goes_on_when_nobody_reads_what_it_says(
    names: tuple[str, ...],
    project: Callable[[Failure], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A warning in each step, and a bar of progress after each."""
    monkeypatch.setattr("m4e_fmi.cosim.master.ticking.PROGRESS_INTERVAL", 0.0)
    monkeypatch.setattr("m4e_fmi.report.progress._INTERVAL", 0.0)
    project(Failure({"talker": {"fmu": "talker.fmu", "start": {"count": 30, "kinds": 30}}}, (), 1))
    with contextlib.ExitStack() as stack:
        for name in names:
            stack.enter_context(left(name, monkeypatch))
        assert main(["run", "system.yaml", "--output-file", "r.nc"]) == 0
    assert len(load("r.nc").time) == 11
    assert load("r.nc").attributes["ended"] == "at the stop time"
    assert Path("r.png").is_file()


RUN = """\
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # may be ignored in the background
from m4e_fmi.cli import main
sys.exit(main(["run", "system.yaml", "--output-file", "r.nc"]))
"""


def test_an_interrupted_run(project: Callable[[Failure], None]) -> None:
    project(Failure({"pump": pump(0)}, (), 0.0, simulation={"stop_time": 1e9, "step_size": 0.5}))
    command = [sys.executable, "-c", RUN]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        limit = time.monotonic() + 60
        while not Path("r.nc").exists():
            assert process.poll() is None
            assert time.monotonic() < limit
            time.sleep(0.05)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=60)
    assert process.returncode == 130
    results = load("r.nc")
    told = re.search(r"interrupted at t = ([\d.]+) s of 1e\+09 s; (.*)", error)
    assert told
    last = results.time[-1]
    assert 0.0 <= float(told[1]) - last < 25.0  # a row is written every 50 steps
    rows = f"({len(results.time):,} rows)"
    assert told[2] == f"results until t = {last:.9g} s are in r.nc {rows}"
    assert results.attributes["ended"] == "interrupted"
    np.testing.assert_array_equal(results["pump.y"].values, results.time)  # y = t
