"""Checkpoints where runs end: by signals, by errors, at points within the estimate of the error."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.interrupted import differences
from support.small_systems import Fmus, oscillator, system

from m4e_fmi.cli import main
from m4e_fmi.cosim import Network, Simulation, run, start
from m4e_fmi.cosim.checkpoint.container import checkpoint_of
from m4e_fmi.errors import RunError
from m4e_fmi.signals import Terminated

SAVING = "+state+bytes"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_leaves_a_checkpoint_at_the_last_point(
    c_fmu: Fmus, tmp_path: Path, number: signal.Signals
) -> None:
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(3, 0.01), SAVING)
    saving = whole.changed(checkpoint_interval=1e3)
    run(whole, results=plain)

    def end(time: float, _: Network) -> None:
        if time >= 1.234:
            os.kill(os.getpid(), number)

    with pytest.raises((Terminated, KeyboardInterrupt)) as caught:
        run(saving, results=file, observers=[end])
    notes = caught.value.__notes__
    assert notes[-1] == "--resume (in Python resume=True) goes on at t = 1.24 s"
    told: list[str] = []
    run(saving, results=file, resume=True, tell=told.append)
    assert told == ["the run goes on at t = 1.24 s"]
    assert differences(plain, file) == []


def test_a_signal_in_a_repeated_window_leaves_one_before_it(c_fmu: Fmus, tmp_path: Path) -> None:
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(22, 0.01, "gauss_seidel"), SAVING)
    saving = whole.changed(checkpoint_interval=1e3)
    run(whole, results=plain)
    found: list[Network] = []

    def end(time: float, network: Network) -> None:
        pause = network.pause

        def ending() -> None:
            if not found:
                found.append(network)
                os.kill(os.getpid(), signal.SIGTERM)
            pause()

        if time == 20.48:  # after 2048 steps, which are repeated next
            network.pause = ending

    with pytest.raises(Terminated) as caught:
        run(saving, results=file, observers=[end])
    assert found
    assert caught.value.__notes__[-1].endswith("goes on at t = 20.48 s")
    run(saving, results=file, resume=True)
    assert differences(plain, file) == []


def test_an_error_names_the_last_checkpoint(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "results.nc"
    names = {"body": "mass+state+bytes", "pump": "rogue+state+bytes", "next": "stage+state+bytes"}
    start = {"pump": {"what": 4.0, "when": 1.5}}
    settings = Simulation(2, 0.1, "jacobi", checkpoint_interval=0.5)
    failing = system(c_fmu, names, "pump.y -> next.u", start=start, simulation=settings)
    with pytest.raises(RunError) as caught:
        run(failing, results=file)
    assert caught.value.remedy.endswith("; --resume (in Python resume=True) goes on at t = 1 s")
    assert checkpoint_of(file).is_file()
    with pytest.raises(RunError, match="the pump ran dry"):
        run(failing, results=file, resume=True)


def test_checkpoints_that_are_asked_for_and_not_taken_are_told(c_fmu: Fmus, tmp_path: Path) -> None:
    saving = oscillator(c_fmu, Simulation(1, 0.1, "jacobi", checkpoint_interval=0.5), SAVING)
    told: list[str] = []
    run(saving, warn=told.append)
    with start(saving, results=tmp_path / "r.nc", warn=told.append) as stepped:
        for _ in stepped:
            pass
    nothing = "warning: checkpoint_interval: no checkpoints are taken: "
    assert told == [
        nothing + "they lie beside results: give 'results'",
        nothing + "use 'run', or 'save' of this run in between",
    ]


SYSTEM = """\
name: oscillator
components:
  body: {{fmu: {body}, process: here, start: {{body.m.x: 1.0}}}}
  spring: {{fmu: {spring}, process: here}}
connections: [body.m <-> spring.end]
simulation: {{stop_time: 15, step_size: 0.01, algorithm: jacobi, checkpoint_interval: 0.1}}
"""


def test_a_command_that_is_killed_and_goes_on_has_the_same_file(
    c_fmu: Fmus, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Soon after it has written a checkpoint, at any moment."""
    body, spring = (c_fmu(f"{name}{SAVING}") for name in ("mass", "spring"))
    (tmp_path / "system.yaml").write_text(SYSTEM.format(body=body, spring=spring))
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"

    def arguments(results: Path, *more: str) -> list[str]:
        folder = str(tmp_path / "build")
        given = str(tmp_path / "system.yaml"), "--output-file", str(results)
        return ["run", *given, "--build-folder", folder, *more]

    assert main(arguments(plain)) == 0
    code = "import m4e_fmi.cli as c; raise SystemExit(c.main())"
    command = [sys.executable, "-c", code, *arguments(file)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        until = time.monotonic() + 60.0
        while not checkpoint_of(file).exists():
            assert process.poll() is None, process.stderr and process.stderr.read().decode()
            assert time.monotonic() < until
            time.sleep(0.003)
        process.kill()
    capsys.readouterr()
    assert main(arguments(file, "--resume")) == 0
    assert re.search(r"the run goes on at t = [\d.]+ s", "".join(capsys.readouterr()))
    assert differences(plain, file) == []
