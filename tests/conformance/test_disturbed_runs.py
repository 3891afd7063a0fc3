"""Runs that are killed, that meet another run, or whose FMUs crash or go elsewhere: what is left.

Longer and random versions are in tests/verify/test_disturbed_runs.py.
"""

from __future__ import annotations

import csv
import signal
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.disturbed import (
    FAST,
    check_left,
    commanded,
    killed,
    running,
    until,
    write_system,
)

from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system, run
from m4e_fmi.errors import RunError
from m4e_fmi.results.results_file import Results, load

Fmus = Callable[[str], Path]
SLOW = 1e6, 0.01
"""Stop time and step [s] of a run that does not come to its end."""


@pytest.fixture(scope="module")
def whole(c_fmu: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Results of the undisturbed run."""
    folder = tmp_path_factory.mktemp("whole")
    return run(load_system(write_system(c_fmu, folder)), results=folder / "r.nc").results()


@pytest.mark.parametrize(
    ("plan", "least"),
    [
        ({"write": 0, "part": 0.5}, 0),  # old results stay until there are others
        ({"write": 5, "part": 0.7}, 2),
        ({"block": 1}, FAST[0] / FAST[1]),
    ],
)
def test_a_run_that_is_killed_inside_a_write(
    plan: dict[str, float], least: int, c_fmu: Fmus, tmp_path: Path, whole: Results
) -> None:
    path, old = tmp_path / "r.nc", b"results of an earlier run"
    path.write_bytes(old)
    killed(write_system(c_fmu, tmp_path), path, {"flush": 0.02, **plan})
    assert bool(check_left(path, whole, old, least=least)) == bool(least)


def test_a_second_run_of_the_same_file(
    c_fmu: Fmus, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second is refused, whatever it would write there; the first goes on, to SIGTERM."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "unpacked"))
    (tmp_path / "unpacked").mkdir()
    system = write_system(c_fmu, tmp_path, times=SLOW)
    model = Path(__file__).parents[2] / "examples/double_pendulum/double_pendulum.model.yaml"
    with running(system, "r.csv") as first:
        for name in ("r.nc", "r.csv"):
            assert main(["run", "system.yaml", "--output-file", name]) == 1
            error = capsys.readouterr().err
            assert f"r.nc: another run writes it (process {first.pid} on " in error
            assert error.count("\n") == 2
        assert main(["simulate", str(model), "--output-file", "r.nc"]) == 1
        assert "r.nc: another run writes it" in capsys.readouterr().err
        rows = len(load("r.nc").time)
        until(lambda: len(load("r.nc").time) > rows)
        first.send_signal(signal.SIGTERM)
        _, error = first.communicate(timeout=60)
    assert first.returncode == 128 + signal.SIGTERM
    assert "ended by SIGTERM" in error
    results = load("r.nc")
    assert results.attributes["ended"] == "ended by SIGTERM"
    assert len(results.time) > rows
    with Path("r.csv").open(newline="") as file:
        times = [float(row[0]) for row in list(csv.reader(file))[1:]]
    assert times == results.time.tolist()
    assert not list(Path("unpacked").glob("*/*"))
    assert not list(tmp_path.glob(".*"))


def test_a_crash_loses_the_rows_of_a_second(c_fmu: Fmus, tmp_path: Path) -> None:
    """Steps, made thousands at once, take 5 ms from the 10,000th on; the 10,400th crashes."""
    slow, crash = {"what": 3, "when": 100.0, "pause": 0.005}, {"what": 2, "when": 104.0}
    system = write_system(c_fmu, tmp_path, slow, crash, times=(1e3, 0.01))
    command = commanded(system, "r.nc")
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == -signal.SIGSEGV
    results = load(tmp_path / "r.nc")
    np.testing.assert_allclose(results["vandal0.y"].values, results.time, rtol=1e-12)
    # a second, what steps at once take, and a busy machine
    assert len(results.time) > 10_400 - 1.5 / 0.005


def test_an_fmu_that_changes_the_folder(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "unpacked"))
    (tmp_path / "unpacked").mkdir()
    write_system(c_fmu, tmp_path, {"what": 1, "when": 0.5}, times=(1.0, 0.1))
    (tmp_path / "sub").mkdir()
    assert main(["run", "system.yaml", "--output-file", "sub/r.csv"]) == 0
    assert Path.cwd() == tmp_path
    assert {path.name for path in Path("sub").iterdir()} == {"r.nc", "r.csv", "r.png"}
    assert len(load("sub/r.nc").time) == 11
    assert not list(Path("unpacked").glob("*/*"))


def test_a_run_without_a_step_leaves_the_results_that_are_there(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    system = write_system(c_fmu, tmp_path, times=(1.0, 0.1))
    first = run(load_system(system), results=tmp_path / "r.csv").results()
    text = (tmp_path / "r.csv").read_text()
    broken = load_system(system).changed(start={"vandal0.what": 4.0})
    with pytest.raises(RunError, match=r"made no step: .*r\.csv is as it was"):
        run(broken, results=tmp_path / "r.csv")
    assert (tmp_path / "r.csv").read_text() == text
    assert load(tmp_path / "r.nc").attributes == first.attributes
