"""Components with a step of their own: what is read, what fits, and what is told."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Network,
    Simulation,
    System,
    Timing,
    load,
    load_system,
    prepare,
    run,
    save_system,
    start,
)
from m4e_fmi.cosim.stepping.input_interpolation import PARABOLA, InputInterpolation
from m4e_fmi.cosim.system.component_step import ComponentStep, common_step, rate, seconds
from m4e_fmi.cosim.system.simulation import TICK
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import read_description
from m4e_fmi.report import run_numbers

Fmus = Callable[[str], Path]
MS = Fraction(1, 1000)


def pair(fmus: Fmus, own: float | str | None = None, *, options: str = "", **other: Any) -> System:
    """A mass and its partner, which may have a step of its own; H = 0.05 s."""
    settings = {"stop_time": 1.0, "step_size": 0.05, **other}
    parts = (
        Component("a", FmuFile(fmus("mass+state")), {"stiffness": 1.0, "body.m.x": 1.0}),
        Component("b", FmuFile(fmus(f"partner+state{options}")), step_size=own),
    )
    return System("s", parts, ("a.m <-> b.end",), Simulation(**settings))


@pytest.mark.parametrize(
    ("given", "time"),
    [
        (0.01, 10 * MS),
        ("0.01", 10 * MS),
        ("10 ms", 10 * MS),
        ("1/3 ms", MS / 3),
        ("2 min", Fraction(120)),
    ],
)
def test_times(given: float | str, time: Fraction) -> None:
    assert seconds(given) == time


@pytest.mark.parametrize(
    "given", ["soon", "5 m", "", "1/0 s", "1e999999999 s", 0, -1.0, float("nan"), "inf"]
)
def test_what_is_no_time(given: float | str) -> None:
    with pytest.raises(InputError, match="step_size"):
        seconds(given)


@pytest.mark.parametrize(
    ("step", "macro", "found"),
    [
        (50 * MS, 50 * MS, ComponentStep(0.05)),
        (10 * MS, 50 * MS, ComponentStep(0.01, pieces=5)),
        (150 * MS, 50 * MS, ComponentStep(0.15, every=3)),
        (seconds(0.000333333), MS, ComponentStep(float(MS / 3), pieces=3)),  # six digits of a third
    ],
)
def test_rates(step: Fraction, macro: Fraction, found: ComponentStep) -> None:
    assert rate(step, macro) == found


@pytest.mark.parametrize(
    ("step", "message", "remedy"),
    [
        (20 * MS, "2.5 times into the system's 0.05 s", "take 1/60 s or 0.025 s"),
        (120 * MS, "is 2.4 times the system's 0.05 s", "take 0.1 s or 0.15 s"),
        (Fraction("0.00833"), "6.0024 times", "take 1/140 s or 1/120 s"),
    ],
)
def test_what_does_not_fit_names_the_nearest_that_does(
    step: Fraction, message: str, remedy: str
) -> None:
    with pytest.raises(InputError, match="step_size") as caught:
        rate(step, 50 * MS)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert remedy in problem.remedy


@pytest.mark.parametrize(
    ("steps", "found"),
    [
        ((50, 10, 150), 50),
        ((20,), 10),
        ((75,), 25),
        ((125, 10), 5),  # 10 ms went into 50 ms, but not into 25 ms
        ((75, 40), 5),
    ],
)
def test_common_steps(steps: tuple[int, ...], found: int) -> None:
    own = {str(step): step * MS for step in steps}
    assert common_step(50 * MS, own, TICK) == (found * MS, {})


def test_steps_that_have_none_in_common_are_told_one_by_one() -> None:
    own = {"a": 20 * MS, "b": 33 * MS, "c": MS * 43 / 100}
    found, problems = common_step(50 * MS, own, TICK)
    assert found == 10 * MS
    assert set(problems) == {"b", "c"}
    assert problems["b"].message == "step_size 0.033 s goes 1.51515 times into the system's 0.05 s"


def test_own_steps_that_do_not_meet_one_another() -> None:
    own = {"a": 75 * MS, "b": MS * 50 / 3}  # each of them would fit
    _, problems = common_step(50 * MS, own, TICK)
    assert problems["b"].message == "step_size 0.0166667 s and 0.075 s of 'a' do not meet"


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_any_ratio_of_steps(c_fmu: Fmus, tmp_path: Path, algorithm: str) -> None:
    own, ends = "75 ms", []
    for step in (0.05, 0.025):
        file = tmp_path / f"{step}.nc"
        system = pair(c_fmu, own, algorithm=algorithm, step_size=step, output_interval=0.05)
        outcome = run(system, results=file)
        assert outcome.steps == 40
        ends.append(load(file)["a.body.m.x"].values)
    assert len(ends[0]) == 21  # the rows of the step that was given
    np.testing.assert_array_equal(ends[0], ends[1])
    outcome = run(pair(c_fmu, own, algorithm=algorithm))
    assert outcome.notes[0] == (
        "the system steps by 0.025 s, 2 times in each 0.05 s, to meet all points of b"
    )
    assert outcome.notes[0] in str(outcome.prepared)


def test_an_fmu_of_constant_step_keeps_the_one_that_was_given(c_fmu: Fmus) -> None:
    system = pair(c_fmu, "75 ms")
    part = Component("c", FmuFile(c_fmu("partner+state+constant")))
    prepared = prepare(replace(system, components=(*system.components, part)))
    assert prepared.system.simulation.step_size == 0.025
    assert prepared.rates["c"] == ComponentStep(0.05, every=2, constant=True)


def test_a_step_that_does_not_fit_is_told_with_its_place(c_fmu: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(
        "name: s\n"
        "components:\n"
        f"  a: {{fmu: '{c_fmu('mass')}', step_size: 33 ms}}\n"
        f"  b: {{fmu: '{c_fmu('mass')}', step_size: 5 m}}\n"
        "simulation: {stop_time: 1, step_size: 0.05, algorithm: jakobi}\n"
    )
    with pytest.raises(InputError) as caught:
        load_system(path)
    told = [str(problem) for problem in caught.value.problems]
    assert "unknown algorithm 'jakobi'" in told[0]
    path.write_text(path.read_text().replace("jakobi", "jacobi"))
    with pytest.raises(InputError) as caught:
        load_system(path)
    first, second = caught.value.problems
    assert f"{path}:3:" in str(first)
    assert "component 'a': step_size 0.033 s goes 1.51515 times" in first.message
    assert f"{path}:4:" in str(second)
    assert "step_size '5 m' is not a valid duration" in second.message
    path.write_text(path.read_text().replace("33 ms", "10 ms").replace("5 m}", "1/3 ms}"))
    system = load_system(path.rename(tmp_path / "good.yaml")).changed(step_size=0.01)
    assert [part.step_size for part in system.components] == ["10 ms", "1/3 ms"]
    with pytest.raises(InputError, match=r"component 'b': step_size 0.000333333 s goes 30.03"):
        system.changed(step_size=0.01001)


def test_own_steps_are_told(c_fmu: Fmus, tmp_path: Path) -> None:
    system = pair(c_fmu, "10 ms")
    prepared = prepare(system)
    assert prepared.rates == {"b": ComponentStep(0.01, pieces=5)}
    assert "  b  steps by 0.01 s, 5 times in each step" in str(prepared)
    outcome = run(prepared, results=tmp_path / "r.nc")
    assert outcome.notes == ("b steps by 0.01 s, 5 times in each step",)
    from netCDF4 import Dataset

    with Dataset(tmp_path / "r.nc") as file:
        assert file["b"].step_size == "0.01 s"
        assert "step_size" not in file["a"].ncattrs()


def test_ssp_keeps_own_steps(c_fmu: Fmus, tmp_path: Path) -> None:
    for own in (0.01, "1/60 s", None):
        back = load_system(
            save_system(pair(c_fmu, own), tmp_path / "s.ssp", build_directory=tmp_path)
        )
        assert back.notes == ()
        assert [part.step_size for part in back.components] == [None, own]


def test_sampled_links_are_told(c_fmu: Fmus) -> None:
    prepared = prepare(pair(c_fmu, "0.2 s"))
    found = {link.source.component: timing for link, timing in prepared.timings.items()}
    assert found == {"a": Timing.TAKEN, "b": Timing.HELD}
    assert "b  steps by 0.2 s, once in 4 steps" in str(prepared)


@pytest.mark.parametrize(
    ("other", "own", "message"),
    [
        ({"coupling_tolerance": 1e-4}, None, "its FMU makes steps of one size only"),
        ({"stop_time": 1.02}, None, "the last step would be one of 0.02 s"),
        ({"stop_time": 1.02}, "10 ms", "the last step would be one of 0.02 s"),
    ],
)
def test_what_an_fmu_of_constant_step_cannot(
    c_fmu: Fmus, other: dict[str, Any], own: str | None, message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        prepare(pair(c_fmu, own, options="+constant", **other))
    assert caught.value.problems[0].remedy


@pytest.mark.parametrize(
    ("own", "told"),
    [
        (0.05, "b is stepped with the system, whose steps are of 0.05 s at most"),
        (0.025, "b makes 2 steps in each of the system's, of 0.025 s at most"),
    ],
)
def test_adaptive_steps_do_not_sample_a_component(c_fmu: Fmus, own: float, told: str) -> None:
    system = pair(c_fmu, own, coupling_tolerance=1e-4)
    assert told in str(prepare(system)).replace("b  ", "b ")
    assert told in " ".join(run(system).notes)


def test_steps_are_whole_nanoseconds_and_that_is_told(c_fmu: Fmus) -> None:
    parts = (Component("b", FmuFile(c_fmu("mass"))),)
    system = System("s", parts, (), Simulation(1.0, 0.0333333333333))
    (note,) = prepare(system).notes
    assert note == (
        "steps are whole nanoseconds: those of step_size 0.0333333333333 s are 33333333 ns long, "
        "but the last one, up to the stop time, which is 10 ns long"
    )
    assert run(system).steps == 31
    (note,) = prepare(system.changed(stop_time=0.33333333)).notes
    assert note.endswith("33333333 ns long")
    for step in (0.1, 1e-3, 7.812e-6, 3e-9):
        assert not prepare(system.changed(step_size=step, stop_time=1.0)).notes


def test_adaptive_steps_do_not_meet_the_points_of_a_sampled_component(c_fmu: Fmus) -> None:
    with pytest.raises(InputError, match="once in 2 steps, and with a coupling_tolerance"):
        prepare(pair(c_fmu, 0.1, coupling_tolerance=1e-4))


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector"])
def test_outputs_that_follow_inputs_at_once_do_not_wait_for_a_step_inside(
    c_fmu: Fmus, tmp_path: Path, algorithm: str
) -> None:
    """y = u + t of an FMU with an internal step of 0.1 s, in a system that steps by 0.01 s."""

    def values(stage: str) -> np.ndarray:
        parts = (
            Component("u", FmuFile(c_fmu("integrator+state")), {"u": 2.0}),
            Component("stage", FmuFile(c_fmu(stage))),
        )
        links = ("u.y -> stage.u, units ignored",)
        run(System("s", parts, links, Simulation(1.0, 0.01, algorithm)), results=tmp_path / "r.nc")
        results = load(tmp_path / "r.nc")
        found = results["stage.y"].values
        np.testing.assert_allclose(found, results["u.y"].values + results.time, rtol=1e-12)
        return found

    np.testing.assert_array_equal(values("3:stage+tenth"), values("3:stage"))


@pytest.mark.parametrize(
    ("fmu", "rates"),
    [
        ("3:stage+tenth", {}),  # its output follows the input
        ("3:stage+tenth+rigid", {"b": ComponentStep(0.1, every=10, constant=True)}),
        ("3:lag+tenth", {"b": ComponentStep(0.1, every=10)}),
    ],
)
def test_which_steps_inside_are_own_steps(
    c_fmu: Fmus, fmu: str, rates: dict[str, ComponentStep]
) -> None:
    parts = (Component("a", FmuFile(c_fmu("integrator"))), Component("b", FmuFile(c_fmu(fmu))))
    settings = Simulation(1.0, 0.01)
    assert prepare(System("s", parts, ("a.y -> b.u, units ignored",), settings)).rates == rates


def test_a_step_inside_an_fmu(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    """As FMUs of FMI 3.0 tell it (fixedInternalStepSize)."""
    read = read_description

    def stiff(path: Path) -> Any:
        found = read(path)
        return replace(found, internal_step=0.01) if "partner" in path.name else found

    monkeypatch.setattr(sys.modules[prepare.__module__], "read_description", stiff)
    assert prepare(pair(c_fmu)).rates == {"b": ComponentStep(0.01, pieces=5)}
    assert prepare(pair(c_fmu, "50 ms")).rates == {"b": ComponentStep(0.05)}
    with pytest.raises(InputError, match=r"not a multiple of 0.01 s, its FMU's own step"):
        prepare(pair(c_fmu, "1/60 s"))
    with pytest.raises(InputError, match=r"has internal steps of 0.01 s .*: .* goes 3.7 times"):
        prepare(pair(c_fmu, step_size=0.037))
    found = prepare(pair(c_fmu, step_size=0.025))
    assert found.rates == {"b": ComponentStep(0.01, every=2)}
    assert found.notes == (
        "the system steps by 0.005 s, 5 times in each 0.025 s, to meet all points of b",
    )


@pytest.mark.parametrize("size", [0.04, 0.02, 0.01])
def test_jumps_beside_steps_inside_are_in_the_stated_error(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, size: float
) -> None:
    """A ball bounces at the end of a step inside, of 1 ms; what it drives, ∫ v dt, is h − h(0)."""
    read = read_description

    def stiff(path: Path) -> Any:
        found = read(path)
        return replace(found, internal_step=0.001) if "ball" in path.name else found

    monkeypatch.setattr(sys.modules[prepare.__module__], "read_description", stiff)
    parts = (
        Component("ball", FmuFile(c_fmu("3:ball+state+events")), {"gravity": 2 / 0.455**2}),
        Component("sum", FmuFile(c_fmu("integrator+state+inputs"))),
    )
    links = ("ball.v -> sum.u, units ignored",)
    off: list[float] = []

    def observe(_: float, network: Network) -> None:
        off.append(abs(network.read("sum.y") - (network.read("ball.h") - 1.0)))

    outcome = run(System("s", parts, links, Simulation(1.2, size)), observers=[observe])
    assert outcome.prepared.rates["ball"] == ComponentStep(0.001, pieces=round(size / 0.001))
    assert isinstance(outcome.certificate, CouplingErrorReport)
    # over the range of the sum, 1 as that of h
    assert max(off) / 3 < outcome.certificate.errors[0].error < 10 * max(off)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
@pytest.mark.parametrize("options", ["", "+inputs"])
def test_an_fmu_is_stepped_by_its_own_step_to_the_last_bit(
    c_fmu: Fmus, algorithm: str, options: str
) -> None:
    """The FMU refuses all but 0.01 s, of which H = 0.05 s is no exact multiple; a course at 2 H."""
    system = pair(c_fmu, "10 ms", options=f"{options}+hundredth", algorithm=algorithm)
    assert run(system).certificate.errors  # type: ignore[union-attr]
    with pytest.raises(RunError, match=r"I make steps of 0.01 s") as caught:
        run(pair(c_fmu, options=f"{options}+hundredth", algorithm=algorithm))
    first = "fix the problem stated by the FMU first; "
    own = r"if 0\.0\d+ s is not the step that it was made for, give the component that as its own"
    assert re.match(first + own, caught.value.remedy)
    with pytest.raises(RunError) as caught:
        run(pair(c_fmu, options=f"{options}+hundredth+constant", algorithm=algorithm))
    assert re.match(f"{first}it accepts one step size only: {own}", caught.value.remedy)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
@pytest.mark.parametrize("options", ["", "+inputs"])
def test_an_fmu_of_constant_step_is_never_stepped_otherwise(
    c_fmu: Fmus, algorithm: str, options: str
) -> None:
    outcome = run(pair(c_fmu, options=f"{options}+constant", algorithm=algorithm))
    assert outcome.notes[0] == "b steps by 0.05 s (the only size of step that its FMU makes)"
    assert outcome.certificate.errors  # type: ignore[union-attr]
    lost = algorithm == "corrector" and not options
    assert any("second order instead of third" in note for note in outcome.notes) == lost


def test_no_drift_in_thirds_of_a_millisecond(c_fmu: Fmus) -> None:
    part = Component("b", FmuFile(c_fmu("rogue")), step_size="1/3 ms")
    seen: list[tuple[float, float]] = []
    run(
        System("s", (part,), (), Simulation(20.0, 0.001, "jacobi")),
        observers=[lambda t, n: seen.append((t, n.read("b.y")))],  # start + length of its last step
    )
    assert [t for t, _ in seen] == [k / 1000 for k in range(20_001)]
    # rounding of t + (2/3) H, and of what the FMU adds to it; 60,000 sums would give 1e-11
    assert max(abs(own - t) for t, own in seen) <= 2 * np.spacing(20.0)


def test_a_check_halves_the_steps_within_a_step(c_fmu: Fmus) -> None:
    outcome = run(pair(c_fmu, "10 ms"), check=True)
    assert outcome.checked is not None
    assert isinstance(outcome.certificate, type(outcome.checked))
    # both state the same error, the one at H/2 by the next order of the step less
    assert outcome.checked.errors[0].error == pytest.approx(
        outcome.certificate.errors[0].error, rel=0.5
    )
    with pytest.raises(InputError, match="half the step, which b cannot"):
        run(pair(c_fmu, options="+constant"), check=True)
    assert run(pair(c_fmu, "0.1 s"), check=True).checked


@pytest.mark.parametrize("options", ["", "+discrete", "+discrete+constant"])
def test_where_longer_steps_miss_points_shorter_ones_tell(c_fmu: Fmus, options: str) -> None:
    outcome = run(pair(c_fmu, "0.15 s", options=options), check=True)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert outcome.checked is not None
    # both compare with a course at half the step, which is that of b too if it is not sampled
    assert outcome.certificate.errors[0].error == pytest.approx(
        outcome.checked.errors[0].error, rel=1e-9
    )
    assert outcome.certificate.longer == ({} if options else {"b": ""})
    assert (outcome.checked.errors[0].error > 0.01) == (not options)


@pytest.mark.parametrize("inside", [None, 0.05])
def test_longer_steps_that_cannot_be_halved_are_named(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, inside: float | None
) -> None:
    """Of an FMU that makes steps of one size, or of its own inside: nothing that is known is 0."""
    read = read_description

    def stiff(path: Path) -> Any:
        found = read(path)
        return replace(found, internal_step=inside) if "partner" in path.name else found

    monkeypatch.setattr(sys.modules[prepare.__module__], "read_description", stiff)
    system = pair(c_fmu, "0.15 s", options="" if inside else "+constant")
    outcome = run(system, check=True, results=tmp_path / "r.nc")
    for report in (outcome.certificate, outcome.checked):
        assert isinstance(report, CouplingErrorReport)
        assert report.longer == {"b": "its FMU makes steps of one length only"}
        assert report.errors == ()
        known = "the coupling error is not known: it is rounding, without the longer steps of b"
        assert str(report) == known
    (warning,) = outcome.warnings
    assert "the longer steps of b (its FMU makes steps of one length only): take" in warning
    numbers, _ = run_numbers(outcome)
    assert not any("coupling error" in str(number["name"]) for number in numbers)
    others = (
        Component("c", FmuFile(c_fmu("mass+state")), {"stiffness": 1.0, "body.m.x": 1.0}),
        Component("d", FmuFile(c_fmu("spring+state"))),
    )
    parts, links = (*system.components, *others), (*system.connections, "c.m <-> d.end")
    outcome = run(replace(system, components=parts, connections=links), results=tmp_path / "r.nc")
    report = outcome.certificate
    assert isinstance(report, CouplingErrorReport)
    assert all(one.error > 0.0 for one in report.errors)
    assert ", without the longer steps of b; halve the step for" in str(report)
    numbers, _ = run_numbers(outcome)
    (name,) = (str(one["name"]) for one in numbers if "coupling error" in str(one["name"]))
    assert name.endswith(", without the longer steps of b")


@pytest.mark.parametrize(
    ("options", "step", "why"),
    [
        ("+alone", 0.05, "a second set of FMUs fails: b ("),
        ("", 0.050000001, "there are no steps of half the length: two sets of FMUs, and steps of"),
    ],
)
def test_the_reason_why_longer_steps_are_not_halved_is_named(
    c_fmu: Fmus, options: str, step: float, why: str
) -> None:
    outcome = run(pair(c_fmu, 2 * step, options=options, step_size=step, stop_time=20 * step))
    assert f"the longer steps of b ({why}" in outcome.warnings[0]
    assert "one length" not in outcome.warnings[0]


def test_a_run_that_goes_back_does_not_know_its_longer_steps(c_fmu: Fmus) -> None:
    with start(pair(c_fmu, "0.15 s")) as execution:
        execution.step()
        state = execution.save()
        execution.step()
        execution.restore(state)
        for _ in execution:
            pass
    assert execution.outcome.certificate == (
        "the run went on from a saved state, a second set of FMUs did not"
    )


def test_where_no_other_steps_fit_the_run_says_so(c_fmu: Fmus) -> None:
    system = pair(c_fmu, "0.15 s")
    rigid = Component("c", FmuFile(c_fmu("partner+state+constant")))
    outcome = run(replace(system, components=(*system.components, rigid)))
    assert outcome.certificate == (
        "steps of twice the length miss points of a component (b steps by 0.15 s, once in 3 "
        "steps), and there are no steps of half the length: c steps by 0.05 s (the only size "
        "of step that its FMU makes)"
    )


def test_rows_between_the_points_of_a_sampled_component_hold(c_fmu: Fmus, tmp_path: Path) -> None:
    run(pair(c_fmu, "0.2 s"), results=tmp_path / "r.nc")
    force = load(tmp_path / "r.nc")["b.end.force_x"].values
    np.testing.assert_array_equal(force[:20].reshape(5, 4), force[:20:4, None].repeat(4, axis=1))
    assert len(np.unique(force)) == 6


@pytest.mark.parametrize("pieces", range(1, 12))
def test_held_values_have_the_moments_of_the_course(pieces: int) -> None:
    """∫u ds of one, ∫s u ds of two and ∫s² u ds of three values that are held one after another."""
    bounds = InputInterpolation.PARABOLA.known(pieces, held=True)
    assert (bounds[0], bounds[-1]) == (0, pieces)
    held = np.array([InputInterpolation.PARABOLA.held(k, pieces) for k in range(pieces)])
    edges = np.arange(pieces + 1) / pieces
    for first, last in pairwise(bounds):
        assert last - first == min(pieces, 3 if last == pieces and pieces % 2 else 2)
        for power in range(last - first):
            per_piece = np.diff(edges ** (power + 1)) / (power + 1)
            found = per_piece[first:last] @ held[first:last]
            ends = (edges[last], edges[first])
            exact = sum(
                (ends[0] ** (n := power + k + 1) - ends[1] ** n) / n * c
                for k, c in enumerate(PARABOLA)
            )
            np.testing.assert_allclose(found, exact, atol=1e-14)  # rounding


@pytest.mark.parametrize("pieces", range(1, 8))
def test_held_values_have_the_means_of_straight_lines(pieces: int) -> None:
    means = [InputInterpolation.LINES.held(k, pieces) for k in range(pieces)]
    np.testing.assert_allclose(np.mean(means, axis=0), InputInterpolation.LINES.mean, atol=1e-15)
