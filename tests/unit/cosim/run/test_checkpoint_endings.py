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
from support.interrupted import differences, tell_every_step
from support.small_systems import Fmus, oscillator, system

from m4e_fmi.cli import main
from m4e_fmi.cosim import Simulation, run, start
from m4e_fmi.cosim.error.estimator import ErrorEstimator
from m4e_fmi.cosim.run.checkpoint import checkpoint_of
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.signals import Terminated

SAVING = "+state+bytes"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_leaves_a_checkpoint_at_the_last_point(
    c_fmu: Fmus, tmp_path: Path, number: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    tell_every_step(monkeypatch)
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(3, 0.01), SAVING)
    saving = whole.changed(checkpoint_interval=1e3)
    run(whole, results=plain)

    def end(time: float) -> None:
        if time >= 1.234:
            os.kill(os.getpid(), number)

    with pytest.raises((Terminated, KeyboardInterrupt)) as caught:
        run(saving, results=file, progress=end)
    notes = caught.value.__notes__
    assert notes[-1] == "--resume (in Python resume=True) goes on at t = 1.24 s"
    told: list[str] = []
    run(saving, results=file, resume=True, tell=told.append)
    assert told == ["the run goes on at t = 1.24 s"]
    assert differences(plain, file) == []


def test_a_signal_in_a_repeated_window_leaves_one_before_it(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(22, 0.01, "gauss_seidel"), SAVING)
    saving = whole.changed(checkpoint_interval=1e3)
    run(whole, results=plain)
    found: list[float] = []
    before = ErrorEstimator.before

    def ending(estimator: ErrorEstimator) -> None:
        network = estimator._network
        if network.time == 20.48:  # after 2048 steps, which are repeated next
            pause = network.pause

            def end() -> None:
                if not found:
                    found.append(network.time)
                    os.kill(os.getpid(), signal.SIGTERM)
                pause()

            network.pause = end
        before(estimator)

    monkeypatch.setattr(ErrorEstimator, "before", ending)
    with pytest.raises(Terminated) as caught:
        run(saving, results=file)
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
    run(saving, results=tmp_path / "r.nc", observers=[lambda _, __: None], warn=told.append)
    assert not checkpoint_of(tmp_path / "r.nc").exists()
    with start(saving, results=tmp_path / "r.nc", warn=told.append) as stepped:
        for _ in stepped:
            pass
    nothing = "warning: checkpoint_interval: no checkpoints are taken: "
    assert told == [
        nothing + "they lie beside results: give 'results'",
        nothing + "observers may read outputs that a checkpoint does not have",
        nothing + "use 'run', or 'save' of this run in between",
    ]


@pytest.mark.parametrize(("of", "options"), [("1:", ""), ("", "+state"), ("", "")])
def test_fmus_without_states_in_bytes_have_no_checkpoints(
    c_fmu: Fmus, tmp_path: Path, of: str, options: str
) -> None:
    """Which is said before the run, and a run is not resumed."""
    saving = oscillator(c_fmu, Simulation(1, 0.1, checkpoint_interval=0.5), options, of)
    file, told = tmp_path / "r.nc", list[str]()
    run(saving, results=file, warn=told.append)
    why = "body and spring cannot save states for another process (canSerializeFMUstate)"
    assert told[0] == f"warning: checkpoint_interval: no checkpoints are taken: {why}"
    with pytest.raises(InputError, match="no such file"):
        run(saving, results=file, resume=True)
    run(oscillator(c_fmu, saving.simulation, SAVING), results=file)
    with pytest.raises(InputError, match="the run cannot be resumed: body and spring cannot save"):
        run(saving, results=file, resume=True)


def test_a_run_with_observers_is_not_resumed(c_fmu: Fmus, tmp_path: Path) -> None:
    saving, file = oscillator(c_fmu, Simulation(1, 0.1, checkpoint_interval=0.5), SAVING), "r.nc"
    run(saving, results=tmp_path / file)
    with pytest.raises(InputError, match="the run cannot be resumed: observers may read"):
        run(saving, results=tmp_path / file, observers=[lambda _, __: None], resume=True)
    longer = run(saving.changed(stop_time=2.0), results=tmp_path / file, resume=True)
    assert len(longer.results().time) == 21


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
