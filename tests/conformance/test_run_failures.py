"""`m4e-fmi run` where something fails: exit code, what is said, what is left on the disk.

Full and read-only disks: test_disks.py.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from support.interrupted import tell_every_step

from m4e_fmi.cli import main
from m4e_fmi.results.results_file import load

ROGUE = "pump: {fmu: FMU, start: {what: WHAT, when: 0.5}}"
"""An FMU that does something at t = 0.5 s: see rogue.c."""
RING = """
  a: {fmu: FMU, start: {gain: GAIN, y: 1}}
  b: {fmu: FMU, start: {gain: GAIN}}
connections: [a.y -> b.u, b.y -> a.u]"""


@pytest.fixture
def project(
    c_fmu: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., None]:
    """Writes a failing system's file into the folder in which we are."""
    monkeypatch.chdir(tmp_path)

    def write(fmu: str, components: str, settings: str = "", **values: object) -> None:
        text = components.replace("FMU", str(c_fmu(fmu)))
        for name, value in values.items():
            text = text.replace(name, str(value))
        times = settings or "stop_time: 1, step_size: 0.1, algorithm: jacobi"
        text = f"name: failing\ncomponents:\n  {text}\nsimulation: {{{times}}}\n"
        Path("system.yaml").write_text(text)

    return write


@pytest.mark.parametrize(
    ("algorithm", "gain", "told"),
    [
        ("corrector, coupling_tolerance: 1e-4", 1e12, "take algorithm: implicit"),
        # over half a step a.y = 1 + (0 + b.y), b.y = 0 + (1 + a.y)
        ("implicit", 40, "smaller tolerance"),
    ],
)
def test_a_failing_run(
    algorithm: str,
    gain: float,
    told: str,
    project: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A missed tolerance, a loop without a solution; failing FMUs: tests/corpus."""
    settings = f"stop_time: 1, step_size: 0.1, algorithm: {algorithm}"
    project("integrator+state", RING, settings, GAIN=gain)
    assert main(["run", "system.yaml", "--output-file", "r.nc"]) == 1
    error = capsys.readouterr().err
    assert told in error
    results = load("r.nc")
    assert f"results until t = {results.time[-1]:.9g} s are in r.nc" in error
    # adaptive steps end at a millionth of the step
    assert results.time[-1] == pytest.approx(0.0, abs=1e-6)
    assert results.attributes["ended"].startswith("failed: ")
    assert all(np.isfinite(one.values).all() for one in results.series.values())


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
    project: Callable[..., None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A warning in each step, and a bar of progress after each."""
    tell_every_step(monkeypatch)
    monkeypatch.setattr("m4e_fmi.report.progress._INTERVAL", 0.0)
    project("talker", "talker: {fmu: FMU, start: {count: 30, kinds: 30}}")
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


def test_an_interrupted_run(project: Callable[..., None]) -> None:
    project("rogue", ROGUE, "stop_time: 1e9, step_size: 0.5, output_interval: 25", WHAT=0)
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
