"""Runs: results on disk, consistent starts, exact time, and failures that say what happened."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from support.interrupted import tell_every_step
from support.small_study import written_study
from support.small_systems import Fmus, oscillator, system

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Simulation,
    System,
    load_system,
    prepare,
    run,
    save_system,
    start,
)
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu.importer.opening import Unpacked
from m4e_fmi.model import load_model
from m4e_fmi.report.text.summaries import run_text


def test_calculated_parameters_reach_parameters_in_order(c_fmu: Fmus) -> None:
    names = {"c": "stage", "b": "stage", "a": "stage"}
    links = ("a.twice -> b.gain", "b.twice -> c.gain", "a.y -> c.u")
    start = {"a": {"gain": 3.0, "u": 7.0}}
    read: dict[str, float] = {}

    def observe(t: float, network: Network) -> None:
        if t == 0.0:
            read.update(gain=network.read("c.gain"), y=network.read("c.y"))

    run(system(c_fmu, names, *links, start=start), observers=[observe])
    assert read == {"gain": 12.0, "y": 12.0 * 21.0}


@pytest.mark.parametrize(("longest", "creeps"), [(5e-4, False), (2e-5, True)])
def test_a_run_that_creeps_ends(c_fmu: Fmus, longest: float, creeps: bool) -> None:
    """The FMU discards steps longer than that: where steps of a thousandth of those of the system
    are discarded again and again, the run would go on without end."""
    names = {"pump": "rogue+state", "next": "stage+state"}
    start = {"pump": {"what": 5.0, "when": longest}}
    settings = Simulation(0.2, 0.1)
    parts = system(c_fmu, names, "pump.y -> next.u", start=start, simulation=settings)
    if not creeps:
        assert run(parts).steps > 0.1 / longest  # each is made in halves
        return
    with pytest.raises(RunError) as caught:
        run(parts)
    assert re.search(
        r"pump has discarded 128 steps since t = 0 s, of 0\.1 s down to", caught.value.message
    )
    assert "no step_size helps: check what pump" in caught.value.remedy


def test_fmus_are_unpacked_below_a_plain_path(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    strange = tmp_path / "Ünser Ordner #1"
    strange.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(strange))
    unpacked = Unpacked(c_fmu("mass"))
    assert re.fullmatch(r"[A-Za-z0-9_./\\:-]+", str(unpacked.folder))
    assert (unpacked.folder / "modelDescription.xml").is_file()
    unpacked.remove()
    assert not unpacked.folder.exists()


def test_progress_tells_simulated_time(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    tell_every_step(monkeypatch)
    told: list[float] = []
    run(oscillator(c_fmu, Simulation(1, 0.1)), progress=told.append)
    assert told == [k / 10 for k in range(1, 11)]


@pytest.mark.parametrize(("step", "warned"), [(0.01, False), (0.4, True)])
def test_a_coupling_that_is_all_wrong_is_warned_of(
    c_fmu: Fmus, tmp_path: Path, step: float, *, warned: bool
) -> None:
    a = Component("a", FmuFile(c_fmu("mass+state")), {"body.m.x": 1.0})
    b = Component("b", FmuFile(c_fmu("partner+state")), {"coupling": 10.0})
    settings = Simulation(10.0, step, "gauss_seidel" if step < 0.1 else "jacobi")
    told: list[str] = []
    system = System("s", (a, b), ("a.m <-> b.end",), settings)
    outcome = run(system, results=tmp_path / "r.nc", warn=told.append)
    notes = outcome.results().attributes.get("notes", "")
    for text in (run_text(outcome), "\n".join(outcome.warnings), "\n".join(told), notes):
        assert ("the results are unusable" in text) == warned


def test_a_system_may_be_given_by_its_path(c_fmu: Fmus, tmp_path: Path) -> None:
    package = save_system(oscillator(c_fmu, Simulation(1, 0.1)), tmp_path / "s.ssp")
    expected = run(load_system(package)).steps
    build = tmp_path / "b"
    assert run(package, build_directory=build).steps == expected
    with start(str(package), build_directory=build) as stepped:
        assert len(list(stepped)) == expected + 1
    for wrong in (42, None, b"s.ssp", load_model):
        for verb in (run, prepare):
            with pytest.raises(InputError, match="expected a System, or the path of a system"):
                verb(wrong)  # pyrefly: ignore[bad-argument-type]


SCRIPT = """
import json
from concurrent.futures import ThreadPoolExecutor
from m4e_fmi.cosim import load, load_system, prepare, run

system = load_system("system.yaml").changed(stop_time=0.5)
prepared = prepare(system)

def last(k):
    outcome = run(prepared, results=f"{k}.nc")
    return [float(outcome.results()["cart.body.cart.x"].values[-1]) for _ in range(3)]

with ThreadPoolExecutor(4) as pool:
    print(json.dumps(list(pool.map(last, range(12)))))
"""


def test_runs_with_results_may_be_asked_for_by_threads(tmp_path: Path) -> None:
    """netCDF's library ends the process if two threads call it at once."""
    written_study(tmp_path, "")
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found == [found[0]] * 12
    assert found[0] == [found[0][0]] * 3
