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
)
from m4e_fmi.cosim.run.run import Observer
from m4e_fmi.report.text.summaries import run_text
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
    assert "warning: the run ended before its stop time" in told.err
    assert told.err.count("warning: ") == 1
    assert "warning" not in told.out
    results = load(file)
    assert results.time.tolist() == [0.0]
    assert results["fuse.y"].values.tolist() == [3.0]
    assert "requested the end of the simulation at t = 0 s" in results.attributes["ended"]
    assert picture.read_bytes() != b"old"


def send(number: int, at: float) -> Observer:
    return lambda t, _: os.kill(os.getpid(), number) if t == at else None


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_stop_at_a_communication_point(
    c_fmu: Fmus, tmp_path: Path, number: signal.Signals
) -> None:
    before = signal.getsignal(number)  # SIGINT is ignored where tests run in the background
    short, path = oscillator(c_fmu, Simulation(1, 0.1)), tmp_path / "r.nc"
    for at, results, notes in (
        (0.5, path, ["at t = 0.5 s of 1 s", f"results until t = 0.5 s are in {path} (6 rows)"]),
        (0.5, None, ["at t = 0.5 s of 1 s"]),
        (1, path, ["at the stop time, t = 1 s", f"results until t = 1 s are in {path} (11 rows)"]),
    ):
        with pytest.raises((KeyboardInterrupt, Terminated)) as caught:
            run(short, results=results, observers=[send(number, at)])
        assert caught.value.__notes__ == notes
        assert number is signal.SIGINT or caught.value.code == 128 + number  # pyrefly: ignore[missing-attribute]
        found = load(path)
        early = "interrupted" if number is signal.SIGINT else "ended by SIGTERM"
        ended = early if found.time[-1] == 0.5 else "at the stop time"
        assert found.attributes["ended"] == ended
    assert signal.getsignal(number) is before


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="there is no such signal")
def test_signals_that_are_ignored_stop_nothing(c_fmu: Fmus) -> None:
    usual = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        outcome = run(oscillator(c_fmu, Simulation(1, 0.1)), observers=[send(signal.SIGHUP, 0.5)])
    finally:
        signal.signal(signal.SIGHUP, usual)
    assert outcome.steps == 10


KEPT = "results until t = 1 s are in r.csv (11 rows)"
NOT_YET = "the results are complete in r.nc (11 rows); r.csv is not written"
ENDS = {  # what is called at the end of a run, and what is said if SIGTERM comes just before it
    "cosim.results.writer:ResultsWriter.close": KEPT,
    "cosim.results.writer:ResultsWriter._flush": KEPT,
    "cosim.run.running:closing_attributes": KEPT,
    "cosim.results.writer:write_netcdf": KEPT,
    "cosim.run.running:_last_outcome": NOT_YET,
    "cosim.run.running:export": NOT_YET,
    "fmu.importer.opening:shutil.rmtree": "the results are complete in r.csv (11 rows)",
}


@pytest.mark.parametrize(("where", "says"), ENDS.items(), ids=ENDS)
def test_a_signal_after_the_last_step_loses_no_row(
    where: str, says: str, c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 1e9)  # not before the end
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
    assert f"warning: {folder} was renamed or removed during the run" in run_text(outcome)
