"""Simulations that fail keep their rows up to there, by every method."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import m4e_fmi as m4e
from m4e_fmi.cli import main
from m4e_fmi.errors import RunError
from m4e_fmi.signals import Terminated
from m4e_fmi.simulate import SimulationError

FUSE = """\
name: fuse
bodies: {m: {mass: 1, inertia: 1}}
joints: {rail: {type: prismatic, child: m, direction: [1, 0]}}
loads: {push: {type: joint_effort, joint: rail, effort: sqrt(0.55 - t)}}
gravity: 0
"""
"""No force is defined after 0.55 s."""


@pytest.fixture
def fuse(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("fuse.model.yaml").write_text(FUSE, encoding="utf-8")
    return "fuse.model.yaml"


@pytest.mark.parametrize("method", ["dop853", "rk45", "rodas", "rk4"])
def test_rows_up_to_the_failure_are_kept(fuse: str, method: str) -> None:
    with pytest.raises(SimulationError, match="fuse") as caught:
        m4e.simulate(fuse, stop_time=2.0, output_interval=0.1, method=method)
    found = caught.value.simulation
    np.testing.assert_allclose(found.time, np.arange(6) * 0.1, atol=1e-12)
    speed = 2.0 / 3.0 * (0.55**1.5 - (0.55 - found.time) ** 1.5)
    # the tolerance is 1e-8 per step; the last step of rk4 is Simpson's rule with an error of
    # h^5/2880 times the fourth derivative, 3.4e4 at 0.5 s
    error = 2e-4 if method == "rk4" else 1e-6
    np.testing.assert_allclose(found["joint.rail.u"], speed, atol=error)


def test_the_error_goes_to_another_process(fuse: str) -> None:
    with pytest.raises(SimulationError) as caught:
        m4e.simulate(fuse, stop_time=2.0, output_interval=0.1)
    again = pickle.loads(pickle.dumps(caught.value))  # as pools of processes do
    assert isinstance(again, RunError)
    assert str(again) == str(caught.value)


def test_a_start_that_fails_has_no_rows(fuse: str) -> None:
    path = Path(fuse)
    path.write_text(FUSE.replace("0.55 - t", "-1 - t"), encoding="utf-8")
    with pytest.raises(RunError, match="fuse") as caught:
        m4e.simulate(fuse, stop_time=2.0)
    assert not isinstance(caught.value, SimulationError)


def test_the_command_writes_rows(fuse: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("build").mkdir()
    Path("build/fuse.png").write_bytes(b"of an earlier one")
    command = ["simulate", fuse, "--output-interval", "0.1"]
    assert main([*command, "--output-file", "build/fuse.csv"]) == 1
    told = capsys.readouterr()
    assert "results until t = 0.5 s are in build/fuse.csv (6 rows)" in told.err
    assert "at t = 0.55 s: the state joint.rail.u" in told.err
    assert main(["report", "build/fuse.nc"]) == 0
    page = Path("build/fuse.report.html").read_text("utf-8")
    assert "The run ended early: failed: fuse" in page
    kept = m4e.load("build/fuse.nc")
    assert len(kept.time) == 6
    assert kept.attributes["ended"].startswith("failed: fuse")
    assert not Path("build/fuse.png").exists()


@pytest.mark.parametrize("method", ["dop853"])
@pytest.mark.parametrize(
    ("signal", "code", "told"),
    [(KeyboardInterrupt(), 130, "interrupted"), (Terminated(15), 143, "ended by SIGTERM")],
)
def test_a_signal_leaves_rows(
    fuse: str,
    method: str,
    signal: BaseException,
    code: int,
    told: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    @contextmanager
    def progress(_: float) -> Generator[Callable[[float], None]]:
        def moving(t: float) -> None:
            if t > 0.25:
                raise signal

        yield moving

    monkeypatch.setattr("m4e_fmi.cli.simulate.progress", progress)
    command = ["simulate", fuse, "--output-interval", "0.1", "--stop-time", "0.5"]
    assert main([*command, "--output-file", "r.nc", "--method", method]) == code
    assert f"{told} results until t = 0.3 s are in r.nc (4 rows)" in capsys.readouterr().err
    kept = m4e.load("r.nc")
    np.testing.assert_allclose(kept.time, np.arange(4) * 0.1, atol=1e-12)
    assert kept.attributes["ended"] == told
