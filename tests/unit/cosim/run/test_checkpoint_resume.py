"""Runs that go on from a checkpoint have the bits of the run that was not interrupted."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.interrupted import check_resumed, differences
from support.small_systems import Fmus, oscillator

from m4e_fmi.cosim import Action, Simulation, System, run
from m4e_fmi.cosim.run.checkpoint import Saved, checkpoint_of
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.results.results_file import load
from m4e_fmi.units import parse_quantity

SAVING = "+state+bytes"
STUCK = Action(freeze=("spring.end.x",), at=0.5)
HELD = Action(freeze=("spring.end.x",), at=0.5, duration=1.0)
LATE = Action(set={"spring.damping": 2.0}, at=1.0)
HEAVIER = Action(set={"spring.damping": 3.0}, at=1.0)


@pytest.fixture
def ended(c_fmu: Fmus, tmp_path: Path) -> tuple[System, Path]:
    """A system with two actions, and the results of its run; its checkpoint is at the end."""
    file = tmp_path / "results.nc"
    first = oscillator(c_fmu, Simulation(2, 0.01, "jacobi", checkpoint_interval=1.0), SAVING)
    first = replace(first, scenario={"stuck": STUCK, "late": LATE})
    first = first.changed(start={"body.body.m.x": parse_quantity("1000.001 mm")})
    run(first, results=file)
    return first, file


def test_fmi_3_and_rows_at_intervals(c_fmu: Fmus, tmp_path: Path) -> None:
    """All other questions of this kind: algorithms/test_contract.py, test_of_all_kinds.py."""
    whole = oscillator(c_fmu, Simulation(12, 0.01, output_interval=0.25), SAVING, of="3:")
    check_resumed(whole, tmp_path, 0.5, [3.03])


@pytest.mark.parametrize("stop", [1.05, 1.07])
@pytest.mark.parametrize("tolerance", [None, 1e-3])
def test_an_end_between_two_rows_moves_none_of_those_that_follow(
    c_fmu: Fmus, tmp_path: Path, stop: float, tolerance: float | None
) -> None:
    settings = Simulation(
        stop, 0.05, output_interval=0.1, coupling_tolerance=tolerance, checkpoint_interval=0.5
    )
    first = oscillator(c_fmu, settings, SAVING)
    run(first, results=tmp_path / "r.nc")
    run(first.changed(stop_time=2.0), results=tmp_path / "r.nc", resume=True)
    times = load(tmp_path / "r.nc").time
    assert times == pytest.approx([*np.arange(11) / 10, stop, *np.arange(11, 21) / 10], abs=1e-9)


def test_a_checkpoint_of_a_whole_run_is_where_a_longer_one_goes_on(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    short = oscillator(c_fmu, Simulation(5, 0.01, checkpoint_interval=1e3), SAVING)
    long, file = short.changed(stop_time=9.0), tmp_path / "short.nc"
    run(short, results=file)
    files = (file, checkpoint_of(file))
    before = [path.read_bytes() for path in files]
    branch, whole = tmp_path / "branch.nc", tmp_path / "whole.nc"
    run(long, results=branch, resume=checkpoint_of(file))
    run(oscillator(c_fmu, Simulation(9, 0.01), SAVING), results=whole)
    assert [name for name in differences(branch, whole) if name != "/@changed"] == []
    assert [path.read_bytes() for path in files] == before


def test_what_differs_is_named(
    c_fmu: Fmus, ended: tuple[System, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    first, file = ended

    def refused(match: str, other: System = first, **options: Any) -> None:
        with pytest.raises(InputError, match=match):
            run(other, results=file, resume=True, **options)

    x = "body.body.m.x"
    for start, told in ((2.0, "2.0"), (parse_quantity("1000.002 mm"), "1000.002 mm")):
        other = first.changed(start={x: start})
        refused(rf"start value {re.escape(x)} was 1000\.001 mm, and is {told}", other)
    refused(r"step_size was 0\.01, and is 0\.02", first.changed(step_size=0.02))
    refused("algorithm was", first.changed(algorithm="corrector"))
    refused("the checkpoint is at t = 2 s, after the stop time", first.changed(stop_time=1.0))
    for actions, told in (
        ({"stuck": HELD, "late": LATE}, r"'for' of action stuck was not given, and is 1\.0"),
        ({"stuck": STUCK, "late": HEAVIER}, r"'set' of action late was .*2\.0}, and is .*3\.0}"),
        ({"late": LATE, "stuck": STUCK}, "the order of the actions was stuck, late, and is late"),
    ):
        refused(told, replace(first, scenario=actions))
    other = oscillator(c_fmu, first.simulation, f"{SAVING}+inputs")
    refused(
        r"file of body's FMU was .*, SHA-256 [0-9a-f]{12}, and",
        replace(first, components=(other.components[0], first.components[1])),
    )
    refused("recorded variables of spring was", variables=["body.*"])
    refused("the error estimate was on, and is off", certify=False)
    monkeypatch.setattr("platform.machine", lambda: "sparc")
    refused(r"the platform was .*, and is .* sparc")


def test_rows_of_another_run_are_refused(ended: tuple[System, Path], tmp_path: Path) -> None:
    first, file = ended
    other, told = tmp_path / "other.nc", list[str]()

    def refused(match: str) -> None:
        with pytest.raises(InputError, match=match):
            run(first, results=file, resume=True, tell=told.append)

    others: list[tuple[dict[str, Any], str]] = [
        ({"start": {"body.body.m.x": 2.0}}, "row 201 is not the one that the checkpoint was taken"),
        ({"stop_time": 1.0}, "201 rows, and it has 101"),
    ]
    for changes, match in others:
        run(first.changed(**changes), results=other)
        shutil.copy(other, file)
        refused(match)
    file.unlink()
    refused("no such file of results")
    assert told == []


def test_a_new_run_takes_the_old_checkpoint_away(ended: tuple[System, Path]) -> None:
    first, file = ended
    assert checkpoint_of(file).is_file()
    run(replace(first, simulation=Simulation(2, 0.01)), results=file)
    assert not checkpoint_of(file).exists()


def test_a_full_disk_leaves_the_checkpoint_before_and_is_told(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from m4e_fmi.cosim.run import checkpoint

    write, calls = checkpoint.write_checkpoint, list[float]()

    def full(path: Path, saved: Saved) -> None:
        calls.append(0.0)
        if len(calls) == 3:
            raise RunError("the disk is full", "")
        if len(calls) < 3:
            write(path, saved)

    monkeypatch.setattr(checkpoint, "write_checkpoint", full)
    told: list[str] = []
    settings = Simulation(4, 0.01, checkpoint_interval=1.0, algorithm="gauss_seidel")
    outcome = run(
        oscillator(c_fmu, settings, SAVING),
        results=tmp_path / "results.nc",
        warn=told.append,
    )
    assert told[0].startswith("warning: no checkpoint at t = 3 s: the disk is full; the last is of")
    assert outcome.steps == 400
