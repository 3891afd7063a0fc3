"""Ends of runs: failures, Ctrl-C and other signals; the results until then are kept."""

from __future__ import annotations

import importlib
import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.small_systems import Fmus, oscillator, system

from m4e_fmi.cli import main
from m4e_fmi.cosim import (
    Network,
    Simulation,
    load,
    prepare,
    run,
    save_system,
    start,
)
from m4e_fmi.cosim.error_estimate.report import Trace
from m4e_fmi.cosim.master.master import Observer
from m4e_fmi.report.text.summaries import run_summary
from m4e_fmi.signals import Terminated


def test_an_end_in_the_first_step_replaces_the_results_of_before(
    c_fmu: Fmus, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, picture = tmp_path / "r.nc", tmp_path / "r.png"
    fuse = system(c_fmu, {"fuse": "ending"}, start={"fuse": {"when": 0.5, "y": 3.0}})
    assert len(run(fuse, results=file).results().time) == 6
    path = save_system(fuse.changed(start={"fuse.when": 0.0}), tmp_path / "s.ssp")
    picture.write_bytes(b"old")
    assert main(["run", str(path), "--output-file", str(file)]) == 0
    told = capsys.readouterr()
    assert "warning: the run ended before its first step" in told.err
    assert "in PythonFMU, do_step must return True" in told.err
    assert told.err.count("warning: ") == 1
    assert "warning" not in told.out
    results = load(file)
    assert results.time.tolist() == [0.0]
    assert results["fuse.y"].values.tolist() == [3.0]
    assert "requested the end of the simulation at t = 0 s" in results.attributes["ended"]
    assert picture.read_bytes() != b"old"


def test_a_stepped_run_without_a_step_has_its_own_results(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "r.nc"
    fuse = system(c_fmu, {"fuse": "ending"})
    run(fuse, results=file)
    with start(fuse.changed(start={"fuse.y": 3.0}), results=file) as stepped:
        pass
    assert stepped.outcome.results()["fuse.y"].values.tolist() == [3.0]


def test_ctrl_c_stops_at_a_communication_point(c_fmu: Fmus, tmp_path: Path) -> None:
    def observe(t: float, _: Network) -> None:
        if t == 0.5:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)  # ignored where tests run in the background
    system, path = oscillator(c_fmu, Simulation(1, 0.1)), tmp_path / "r.nc"
    with pytest.raises(KeyboardInterrupt) as caught:
        run(system, results=path, observers=[observe])
    assert caught.value.__notes__ == [
        "at t = 0.5 s of 1 s", f"results until t = 0.5 s are in {path} (6 rows)"
    ]  # fmt: skip
    assert load(path).time[-1] == 0.5
    with pytest.raises(KeyboardInterrupt) as caught:
        run(system, observers=[observe])
    assert caught.value.__notes__ == ["at t = 0.5 s of 1 s"]
    assert signal.getsignal(signal.SIGINT) is before


def test_signals_stop_at_a_communication_point_unless_ignored(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def send(number: signal.Signals) -> Observer:
        return lambda t, _: os.kill(os.getpid(), number) if t == 0.5 else None

    short = oscillator(c_fmu, Simulation(1, 0.1))
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Terminated) as caught:
        run(short, results=tmp_path / "r.nc", observers=[send(signal.SIGTERM)])
    assert caught.value.code == 128 + signal.SIGTERM
    assert signal.getsignal(signal.SIGTERM) is before is signal.SIG_DFL
    results = load(tmp_path / "r.nc")
    assert (results.time[-1], results.attributes["ended"]) == (0.5, "ended by SIGTERM")
    last: list[Observer] = [lambda t, _: os.kill(os.getpid(), signal.SIGTERM) if t == 1 else None]
    with pytest.raises(Terminated) as caught:
        run(short, results=tmp_path / "r.nc", observers=last)
    assert caught.value.__notes__[0] == "at the stop time, t = 1 s"
    assert "(11 rows)" in caught.value.__notes__[1]
    assert load(tmp_path / "r.nc").attributes["ended"] == "at the stop time"
    second = iter([False, True])

    def in_second_run(t: float, _: Network) -> None:
        if t == 0.5 and next(second):
            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(Trace, "__call__", lambda _, t, network: in_second_run(t, network))
    with pytest.raises(Terminated) as caught:
        run(short, results=tmp_path / "r.nc", check=True)
    assert caught.value.__notes__ == [
        "at t = 0.5 s of 1 s",
        "this was the second run, at half the step",
        f"the results of the first are complete, in {tmp_path / 'r.nc'}",
    ]
    if hasattr(signal, "SIGHUP"):
        usual = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
        try:
            outcome = run(short, results=tmp_path / "r.nc", observers=[send(signal.SIGHUP)])
        finally:
            signal.signal(signal.SIGHUP, usual)
        assert outcome.results().time[-1] == 1.0


KEPT = "results until t = 1 s are in r.csv (11 rows)"


NOT_YET = "the results are complete in r.nc (11 rows); r.csv is not written"


ENDS = {  # what is called at the end of a run, and what is said if SIGTERM comes just before it
    "cosim.results.writer:ResultsWriter.close": KEPT,
    "cosim.results.writer:ResultsWriter._flush": KEPT,
    "cosim.master.begun:closing_attributes": KEPT,
    "cosim.results.writer:write_netcdf": KEPT,
    "cosim.master.begun:Outcome": NOT_YET,
    "cosim.master.recording:export": NOT_YET,
    "files.temporary:_leave": "the results are complete in r.csv (11 rows)",
}


@pytest.mark.parametrize(("where", "says"), ENDS.items(), ids=ENDS)
def test_a_signal_after_the_last_step_loses_no_row(
    where: str, says: str, c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ready = prepare(oscillator(c_fmu, Simulation(1, 0.1)))
    module, _, path = where.partition(":")
    owner: Any = importlib.import_module(f"m4e_fmi.{module}")
    *parents, name = path.split(".")
    for parent in parents:
        owner = getattr(owner, parent)
    known, sent = getattr(owner, name), []

    def send(*arguments: Any, **options: Any) -> Any:
        if not sent:
            sent.append(True)
            signal.raise_signal(signal.SIGTERM)
        return known(*arguments, **options)

    monkeypatch.setattr(owner, name, send)
    with pytest.raises(Terminated) as caught:
        run(ready, results="r.csv")
    assert sent
    estimating = ["while the coupling error was estimated"] if "closing_attrib" in where else []
    assert caught.value.__notes__ == [*estimating, "at the stop time, t = 1 s", says]
    results = load("r.nc")
    assert results.time.tolist() == pytest.approx(np.arange(11) / 10)
    assert results.attributes["ended"] == "at the stop time"


@pytest.mark.skipif(os.name == "nt", reason="open files keep their folder there")
def test_a_folder_that_is_renamed_during_the_run(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of the results are in one place, and it is said where."""
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 0.0)
    folder, other = tmp_path / "folder", tmp_path / "other"
    folder.mkdir()
    monkeypatch.chdir(folder)

    def rename(time: float, _: Network) -> None:
        if time == 0.5:
            folder.rename(other)

    ready = prepare(oscillator(c_fmu, Simulation(1, 0.1)))
    outcome = run(ready, results="r.csv", observers=[rename])
    assert outcome.path == folder / "r.nc"
    assert len(outcome.results().time) == 11
    assert {path.name for path in folder.iterdir()} == {"r.nc", "r.csv"}
    assert f"warning: {folder} was renamed or removed during the run" in run_summary(outcome)
