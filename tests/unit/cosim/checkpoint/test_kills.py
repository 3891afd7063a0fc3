"""Runs of the command line that are killed, and go on."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.interrupted import differences
from support.small_systems import Fmus

from m4e_fmi.cli import main
from m4e_fmi.cosim.checkpoint.container import checkpoint_of

SYSTEM = """\
name: oscillator
components:
  body: {{fmu: {body}, process: here, start: {{body.m.x: 1.0}}}}
  spring: {{fmu: {spring}, process: here}}
connections: [body.m <-> spring.end]
simulation: {{stop_time: 15, step_size: 0.01, algorithm: jacobi, checkpoint_interval: 0.1}}
"""


@pytest.fixture
def system(c_fmu: Fmus, tmp_path: Path) -> Path:
    path = tmp_path / "system.yaml"
    body, spring = (c_fmu(f"{name}+state+bytes") for name in ("mass", "spring"))
    path.write_text(SYSTEM.format(body=body, spring=spring))
    return path


def command(system: Path, results: Path, *more: str) -> list[str]:
    folder = str(system.parent / "build")
    options = ["run", str(system), "--output-file", str(results), "--build-folder", folder, *more]
    return [sys.executable, "-c", "import m4e_fmi.cli as c; raise SystemExit(c.main())", *options]


def killed(arguments: list[str], checkpoint: Path) -> None:
    """Kill the command soon after it has written a checkpoint, at any moment."""
    before = checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
    with subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as run:
        until = time.monotonic() + 60.0
        while not checkpoint.exists() or checkpoint.stat().st_mtime_ns == before:
            assert run.poll() is None, run.stderr and run.stderr.read().decode()
            assert time.monotonic() < until
            time.sleep(0.003)
        run.kill()


def test_a_run_that_is_killed_and_goes_on_has_the_same_file(
    system: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    assert main(command(system, plain)[3:]) == 0
    killed(command(system, file), checkpoint_of(file))
    capsys.readouterr()
    assert main(command(system, file, "--resume")[3:]) == 0
    assert re.search(r"the run goes on at t = [\d.]+ s", "".join(capsys.readouterr()))
    assert differences(plain, file) == []
