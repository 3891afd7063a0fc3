"""Runs that go on from a checkpoint have the bits of the run that was not interrupted."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.forged import forge
from support.interrupted import copied_at, differences
from support.small_systems import Fmus, system

from m4e_fmi.cosim import Action, Simulation, System, run
from m4e_fmi.cosim.checkpoint.container import checkpoint_of
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.results.results_file import load
from m4e_fmi.units import parse_quantity

ALGORITHMS = ("jacobi", "gauss_seidel", "corrector", "implicit")
SAVING = "+state+bytes"
OTHER = {"body.body.m.x": 2.0}


def oscillator(fmus: Fmus, simulation: Simulation, options: str = SAVING, of: str = "") -> System:
    names = {"body": f"{of}mass{options}", "spring": f"{of}spring{options}"}
    start = {"body": {"body.m.x": 1.0}}
    return system(fmus, names, "body.m <-> spring.end", start=start, simulation=simulation)


def check(whole: System, tmp_path: Path, times: list[float]) -> None:
    """The run, one with checkpoints, and those that go on from copies of it, are the same."""
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    run(whole, results=plain)
    saving = whole.changed(checkpoint_interval=0.5)
    run(saving, results=file, observers=[copied_at(file, times, tmp_path)])
    assert differences(plain, file) == []
    for place in range(len(times)):
        told: list[str] = []
        run(saving, results=tmp_path / str(place) / file.name, resume=True, tell=told.append)
        assert told[0].startswith("the run goes on at t = ")
        assert differences(plain, tmp_path / str(place) / file.name) == []


@pytest.mark.parametrize("tolerance", [None, 1e-3])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_bits_are_those_of_the_undisturbed_run(
    c_fmu: Fmus, tmp_path: Path, algorithm: str, tolerance: float | None
) -> None:
    step = 0.01 if tolerance is None else 0.1
    stop = 22 if algorithm == "gauss_seidel" else 3  # of 2048 steps is the first window
    settings = Simulation(stop, step, algorithm, coupling_tolerance=tolerance)
    check(oscillator(c_fmu, settings), tmp_path, [1.03, stop - 0.2])


def test_fmi_3_and_rows_at_intervals(c_fmu: Fmus, tmp_path: Path) -> None:
    settings = Simulation(12, 0.01, output_interval=0.25)
    check(oscillator(c_fmu, settings, of="3:"), tmp_path, [3.03])


@pytest.mark.parametrize("stop", [1.05, 1.07])
@pytest.mark.parametrize("tolerance", [None, 1e-3])
def test_an_end_between_two_rows_moves_none_of_those_that_follow(
    c_fmu: Fmus, tmp_path: Path, stop: float, tolerance: float | None
) -> None:
    settings = Simulation(
        stop, 0.05, output_interval=0.1, coupling_tolerance=tolerance, checkpoint_interval=0.5
    )
    first = oscillator(c_fmu, settings)
    run(first, results=tmp_path / "r.nc")
    run(first.changed(stop_time=2.0), results=tmp_path / "r.nc", resume=True)
    times = load(tmp_path / "r.nc").time
    assert times == pytest.approx([*np.arange(11) / 10, stop, *np.arange(11, 21) / 10], abs=1e-9)


def test_a_checkpoint_of_a_whole_run_is_where_a_longer_one_goes_on(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    short = oscillator(c_fmu, Simulation(5, 0.01, checkpoint_interval=1e3))
    long = short.changed(stop_time=9.0)
    run(short, results=tmp_path / "short.nc")
    before = [p.read_bytes() for p in (tmp_path / "short.nc", checkpoint_of(tmp_path / "short.nc"))]
    branch, whole = tmp_path / "branch.nc", tmp_path / "whole.nc"
    run(long, results=branch, resume=checkpoint_of(tmp_path / "short.nc"))
    run(oscillator(c_fmu, Simulation(9, 0.01)), results=whole)
    assert [name for name in differences(branch, whole) if name != "/@changed"] == []
    after = [p.read_bytes() for p in (tmp_path / "short.nc", checkpoint_of(tmp_path / "short.nc"))]
    assert after == before


@pytest.mark.parametrize(("of", "options"), [("1:", ""), ("", "+state"), ("", "")])
def test_fmus_without_states_in_bytes_make_the_run_again(
    c_fmu: Fmus, tmp_path: Path, of: str, options: str
) -> None:
    whole = oscillator(c_fmu, Simulation(12, 0.01), options, of)
    saving = whole.changed(checkpoint_interval=1.0)
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    told: list[str] = []
    run(whole, results=plain)
    run(saving, results=file, observers=[copied_at(file, [5.5], tmp_path)], tell=told.append)
    assert told == [
        "checkpoints have no states: body and spring cannot save states for another process "
        "(canSerializeFMUstate); to go on, a run is made again up to there"
    ]
    again = tmp_path / "0" / file.name
    run(saving, results=again, resume=True, tell=told.append)
    assert told[1] == (
        "the run is made again from its start to t = 5 s, as body and spring cannot save states "
        "for another process (canSerializeFMUstate)"
    )
    assert differences(plain, again) == []


def test_what_differs_is_named(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "results.nc"
    first = oscillator(c_fmu, Simulation(2, 0.01, checkpoint_interval=1.0))
    run(first, results=file)
    others: Mapping[str, System] = {
        "start value body.body.m.x was 1.0, and is 2.0": first.changed(
            start={"body.body.m.x": 2.0}
        ),
        "step_size was 0.01, and is 0.02": first.changed(step_size=0.02),
        "algorithm was": first.changed(algorithm="jacobi"),
        r"file of body's FMU was .*, SHA-256 [0-9a-f]{12}, and is mass_state": oscillator(
            c_fmu, first.simulation, "+state+bytes+inputs"
        ),
        "the checkpoint is at t = 2 s, after the stop time": first.changed(stop_time=1.0),
    }
    for message, other in others.items():
        with pytest.raises(InputError, match=message):
            run(other, results=tmp_path / "other.nc", resume=checkpoint_of(file))
    with pytest.raises(InputError, match="recorded variables of spring was"):
        run(first, results=file, resume=True, variables=["body.*"])


def test_start_values_are_compared_in_all_digits(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "results.nc"
    plain = oscillator(c_fmu, Simulation(2, 0.01, checkpoint_interval=1.0))
    first, other = (
        plain.changed(start={"body.body.m.x": parse_quantity(f"1000.00{k} mm")}) for k in (1, 2)
    )
    run(first, results=file)
    with pytest.raises(InputError, match=r"start value body\.body\.m\.x was 1000\.001 mm, and is"):
        run(other, results=file, resume=True)


def test_actions_that_differ_are_named_by_their_keys(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "results.nc"
    stuck, late = (
        Action(freeze=("spring.end.x",), at=0.5),
        Action(set={"spring.damping": 2.0}, at=1.0),
    )
    actions = {"stuck": stuck, "late": late}
    settings = Simulation(2, 0.01, "jacobi", checkpoint_interval=1.0)
    first = replace(oscillator(c_fmu, settings), scenario=actions)
    run(first, results=file)
    held, heavier = Action(freeze=("spring.end.x",), at=0.5, duration=1.0), {"spring.damping": 3.0}
    others = {
        "'for' of action stuck was not given, and is 1.0": {**actions, "stuck": held},
        "'set' of action late was {'spring.damping': 2.0}, and is {'spring.damping': 3.0}": {
            **actions, "late": Action(set=heavier, at=1.0)
        },
        "the order of the actions was stuck, late, and is late, stuck": {
            "late": late, "stuck": stuck
        },
    }  # fmt: skip
    for message, scenario in others.items():
        with pytest.raises(InputError, match=f"another run: {re.escape(message)}\n"):
            run(replace(first, scenario=scenario), results=file, resume=True)


def test_another_platform_is_refused(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(2, 0.01, checkpoint_interval=1.0))
    run(whole, results=file)
    monkeypatch.setattr("platform.machine", lambda: "sparc")
    with pytest.raises(InputError, match=r"the platform was .*, and is .* sparc"):
        run(whole, results=file, resume=True)


def test_rows_of_another_run_are_refused(c_fmu: Fmus, tmp_path: Path) -> None:
    file, other = tmp_path / "results.nc", tmp_path / "other.nc"
    first = oscillator(c_fmu, Simulation(2, 0.01, checkpoint_interval=1.0))
    run(first, results=file)
    run(first.changed(start=OTHER), results=other)
    shutil.copy(other, file)
    with pytest.raises(InputError, match="row 201 is not the one that the checkpoint was taken"):
        run(first, results=file, resume=True)
    run(first.changed(stop_time=1.0), results=other)
    shutil.copy(other, file)
    told: list[str] = []
    with pytest.raises(InputError, match="201 rows, and it has 101"):
        run(first, results=file, resume=True, tell=told.append)
    assert told == []
    file.unlink()
    with pytest.raises(InputError, match="no such file of results"):
        run(first, results=file, resume=True)


def test_a_new_run_takes_the_old_checkpoint_away(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "results.nc"
    first = oscillator(c_fmu, Simulation(2, 0.01, checkpoint_interval=1.0))
    run(first, results=file)
    assert checkpoint_of(file).is_file()
    run(replace(first, simulation=Simulation(2, 0.01)), results=file)
    assert not checkpoint_of(file).exists()
    with pytest.raises(InputError, match="no such file"):
        run(first, results=file, resume=True)


def test_a_full_disk_leaves_the_checkpoint_before_and_is_told(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from m4e_fmi.cosim.master import checkpoints

    write, calls = checkpoints.write_checkpoint, list[float]()

    def full(path: Path, parts: Mapping[str, object]) -> None:
        calls.append(0.0)
        if len(calls) == 3:
            raise RunError("the disk is full", "")
        if len(calls) < 3:
            write(path, parts)

    monkeypatch.setattr(checkpoints, "write_checkpoint", full)
    told: list[str] = []
    settings = Simulation(4, 0.01, checkpoint_interval=1.0, algorithm="gauss_seidel")
    outcome = run(
        oscillator(c_fmu, settings),
        results=tmp_path / "results.nc",
        warn=told.append,
        observers=[lambda _, __: None],
    )
    assert told[0].startswith("warning: no checkpoint at t = 3 s: the disk is full; the last is of")
    assert outcome.steps == 400


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"place":2', b'"place":9'),
        (b'"place":2', b'"place":1'),
        (b'"steps":200,"shortened"', b'"steps":2e2,"shortened"'),
        (b'"most":', b'"must":'),
        (b'"class":"EnergySnapshot","sums"', b'"class":"LoopSnapshot","sums"  '),
        (b'"fmu_states":[[3,', b'"fmu_states":[[7,'),
        (b'"time":2.0,"steps"', b'"time":NaN,"steps"'),
        (b'"time":2.0,"steps"', b'"time":Infinity,"steps"'),
        (b'"time":2.0,"steps"', b'"time":2.5,"steps"'),
        (b'"last":2.0,"digest"', b'"last":NaN,"digest"'),
    ],
)
def test_a_forged_state_is_refused(c_fmu: Fmus, tmp_path: Path, old: bytes, new: bytes) -> None:
    file = tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(2, 0.01, "jacobi", checkpoint_interval=1.0))
    run(whole, results=file)
    forge(checkpoint_of(file), old, new)
    with pytest.raises(InputError, match="is damaged"):
        run(whole.changed(stop_time=3.0), results=file, resume=True)


def test_a_forged_time_of_the_last_row_is_refused(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "results.nc"
    whole = oscillator(c_fmu, Simulation(2, 0.01, checkpoint_interval=1.0))
    run(whole, results=file)
    forge(checkpoint_of(file), b'"last":2.0,"digest"', b'"last":-5,"digest"')
    with pytest.raises(InputError, match="row 201 is not the one that the checkpoint was taken"):
        run(whole, results=file, resume=True)
