"""Runs: results on disk, consistent starts, exact time, and failures that say what happened."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, oscillator, system

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Simulation,
    System,
    load,
    load_system,
    prepare,
    read_parameters,
    run,
    save_system,
    start,
)
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu.importer.unpack import Unpacked
from m4e_fmi.model import load_model
from m4e_fmi.report.text.summaries import run_summary


@pytest.mark.parametrize("algorithm", ["jacobi", "corrector", "implicit"])
@pytest.mark.parametrize(("stop", "step"), [(0.3, 0.1), (0.7, 0.1), (2e-4, 1e-4), (0.9, 0.3)])
def test_no_step_goes_beyond_the_stop_time(
    c_fmu: Fmus, algorithm: str, stop: float, step: float
) -> None:
    """0.2 + 0.1 is more than 0.3 in doubles."""
    outcome = run(oscillator(c_fmu, Simulation(stop, step, algorithm), "+state+strict"))
    assert outcome.steps == round(stop / step)


def test_time_never_drifts(c_fmu: Fmus) -> None:
    seen: list[float] = []
    settings = Simulation(1000, 0.1)
    alone = system(c_fmu, {"clock": "rogue"}, simulation=settings)
    outcome = run(alone, observers=[lambda t, _: seen.append(t)])
    assert outcome.steps == 10_000
    assert seen[-1] == 1000.0
    assert seen == [k / 10 for k in range(10_001)]


def test_the_last_step_is_shortened_to_the_stop_time(c_fmu: Fmus) -> None:
    seen: list[float] = []
    values: list[float] = []

    def observe(t: float, network: Network) -> None:
        seen.append(t)
        values.append(network.read("body.body.m.x"))

    run(oscillator(c_fmu, Simulation(1.025, 0.01)), observers=[observe])
    assert seen[-2:] == [1.02, 1.025]
    assert values[-1] == pytest.approx(np.cos(1.025), abs=2e-5)  # H²/12 and phase, as above


def test_feed_through_is_fresh_and_consistent_from_the_start(c_fmu: Fmus) -> None:
    # y = gain u + t in a row of three, listed against the flow
    names = {"third": "stage", "second": "stage", "first": "stage"}
    chain = ("first.y -> second.u", "second.y -> third.u")
    start = {"first": {"gain": 2.0, "u": 5.0}, "second": {"gain": 3.0}, "third": {"gain": 4.0}}
    for algorithm in ("jacobi", "gauss_seidel"):
        seen: dict[float, float] = {}

        def observe(t: float, network: Network, seen: dict[float, float] = seen) -> None:
            seen[t] = network.read("third.y")

        settings = Simulation(0.2, 0.1, algorithm=algorithm)
        run(
            system(c_fmu, names, *chain, start=start, simulation=settings),
            observers=[observe],
        )
        # ((2·5 + t)·3 + t)·4 + t at the same instant everywhere
        expected = {t: ((10 + t) * 3 + t) * 4 + t for t in (0.0, 0.1, 0.2)}
        assert seen == pytest.approx(expected, abs=1e-12)


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


def test_an_output_that_is_only_recorded_is_checked_too(c_fmu: Fmus, tmp_path: Path) -> None:
    start = {"pump": {"what": 9.0, "when": 0.5}}
    with pytest.raises(RunError, match=r"pump\.y at t = 0\.5 s is nan"):
        run(system(c_fmu, {"pump": "rogue"}, start=start), results=tmp_path / "r.nc")
    assert load(tmp_path / "r.nc").time[-1] == pytest.approx(0.4)


def test_a_tolerance_that_is_missed_ends_the_run(c_fmu: Fmus, tmp_path: Path) -> None:
    """y'' = 1e24 y: no step is small enough for it."""
    names = {"a": "integrator+state", "b": "integrator+state"}
    start = {"a": {"y": 1.0, "gain": 1e12}, "b": {"gain": 1e12}}
    settings = Simulation(2, 0.1, "corrector", start_time=1.0, coupling_tolerance=1e-4)
    with pytest.raises(RunError) as caught:
        run(
            system(c_fmu, names, "a.y -> b.u", "b.y -> a.u", start=start, simulation=settings),
            results=tmp_path / "r.nc",
        )
    assert "stays above coupling_tolerance" in caught.value.message
    assert "remove coupling_tolerance" in caught.value.remedy
    results = load(tmp_path / "r.nc")
    assert f"results until t = {results.time[-1]:.9g} s" in caught.value.remedy


def test_a_loop_without_solution_ends_the_run(c_fmu: Fmus, tmp_path: Path) -> None:
    """a.y = a.u + t, b.y = b.u + t in a ring: 0 = 2 t, and any input solves it at the start."""
    names = {"a": "stage+state", "b": "stage+state"}
    settings = Simulation(1, 0.1, "implicit")
    loop = system(c_fmu, names, "a.y -> b.u", "b.y -> a.u", simulation=settings)
    with pytest.raises(RunError) as caught:
        run(loop, results=tmp_path / "r.nc")
    assert re.search(r"[ab]\.u", caught.value.message)
    assert "is singular at t = 0 s" in caught.value.message


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


def test_a_start_value_of_the_wrong_type_is_refused(c_fmu: Fmus) -> None:
    wrong = System(
        "test",
        (Component("body", FmuFile(c_fmu("mass")), {"mass": "heavy"}),),
        (),
        Simulation(1, 0.1),
    )
    with pytest.raises(
        InputError, match=r"'heavy' of body\.mass is wrong\n +'heavy' is not a number"
    ):
        run(wrong)


@pytest.mark.parametrize("value", ["nan N", float("nan"), float("-inf")])
def test_numbers_that_are_not_finite_are_refused_where_they_are_given(
    c_fmu: Fmus, value: str | float
) -> None:
    given = oscillator(c_fmu, Simulation(1, 0.1))
    wrong = given.changed(start={"body.body.m.force_x": value}, origin="command line")
    with pytest.raises(InputError, match=r"command line: start value .* is wrong") as caught:
        prepare(wrong)
    assert caught.value.problems[0].remedy == "give a finite number"
    with start(given) as stepped, pytest.raises(InputError, match="give a finite number"):
        stepped["body.damping"] = value if isinstance(value, float) else "nan N.s/m"
    if isinstance(value, float):
        with pytest.raises(InputError, match=r"command line: output_interval .*expected"):
            given.changed(output_interval=value, origin="command line")


def test_progress_tells_simulated_time(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.master.ticking.PROGRESS_INTERVAL", 0.0)
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
    for text in (run_summary(outcome), "\n".join(outcome.warnings), "\n".join(told), notes):
        assert ("the results are unusable" in text) == warned


def test_what_was_given_wrong_is_told_where_it_was_given(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "set.yaml"
    file.write_text("values:\n  body.body.m.y: 1\n  bdy.x: 2\n  body: 3\n")
    given = oscillator(c_fmu, Simulation(1, 0.1))
    with pytest.raises(InputError) as caught:
        given.changed(start=read_parameters(file))
    (first, second) = caught.value.problems
    assert str(first).startswith(f"{file}:3:3: start value 'bdy.x': there is no component 'bdy'")
    assert "did you mean 'body'?" in first.remedy
    assert "expected COMPONENT.VARIABLE" in second.message
    file.write_text("values:\n  body.body.m.y: 1\n")
    both = given.changed(start=read_parameters(file))
    both = both.changed(start={"body.body.m.xx": 1}, origin="command line")
    with pytest.raises(InputError) as caught:
        prepare(both)
    texts = [str(problem) for problem in caught.value.problems]
    assert texts[0].startswith(f"{file}:2:3: 'body' has no variable 'body.m.y'")
    assert texts[1].startswith("command line: 'body' has no variable 'body.m.xx'")
    assert "did you mean 'body.m.x'?" in texts[1]
    with pytest.raises(InputError) as caught:
        given.changed(start={"bdy.x": 1}, origin="command line", stop_time=-1.0)
    assert [problem.file for problem in caught.value.problems] == ["command line"] * 2


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
                verb(wrong)  # pyright: ignore[reportArgumentType]
