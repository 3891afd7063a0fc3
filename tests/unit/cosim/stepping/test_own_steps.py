"""Components with a step of their own: what is read, what fits, and what is told."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from netCDF4 import Dataset
from support.half_step import checked

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Network,
    Simulation,
    System,
    Timing,
    load,
    prepare,
    run,
    start,
)
from m4e_fmi.cosim.system.simulation import ComponentStep, rate, seconds
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import read_description

Fmus = Callable[[str], Path]
MS = Fraction(1, 1000)


def pair(fmus: Fmus, own: float | str | None = None, *, options: str = "", **other: Any) -> System:
    """A mass and its partner, which may have a step of its own; H = 0.05 s."""
    settings: dict[str, Any] = {"stop_time": 1.0, "step_size": 0.05, **other}
    parts = (
        Component("a", FmuFile(fmus("mass+state")), {"stiffness": 1.0, "body.m.x": 1.0}),
        Component("b", FmuFile(fmus(f"partner+state{options}")), step_size=own),
    )
    return System("s", parts, ("a.m <-> b.end",), Simulation(**settings))


@pytest.fixture
def inside(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, float], None]:
    """`inside(name, step)` makes FMUs of a name step inside, as FMI 3.0 tells it [s]."""

    def set_step(name: str, step: float) -> None:
        read = read_description

        def stiff(path: Path) -> Any:
            found = read(path)
            return replace(found, internal_step=step) if name in path.name else found

        monkeypatch.setattr(sys.modules[prepare.__module__], "read_description", stiff)

    return set_step


def test_rates() -> None:
    assert rate(50 * MS, 50 * MS) == ComponentStep(0.05)
    assert rate(10 * MS, 50 * MS) == ComponentStep(0.01, pieces=5)
    assert rate(150 * MS, 50 * MS) == ComponentStep(0.15, every=3)
    # six digits of a third
    assert rate(seconds(0.000333333), MS) == ComponentStep(float(MS / 3), pieces=3)
    with pytest.raises(InputError, match=r"6\.0024 times") as caught:
        rate(Fraction("0.00833"), 50 * MS)
    assert "take 1/140 s or 1/120 s" in caught.value.problems[0].remedy


def test_own_steps_are_told(c_fmu: Fmus, tmp_path: Path) -> None:
    prepared = prepare(pair(c_fmu, "10 ms"))
    assert prepared.rates == {"b": ComponentStep(0.01, pieces=5)}
    assert "  b  steps by 0.01 s, 5 times in each step" in str(prepared)
    outcome = run(prepared, results=tmp_path / "r.nc")
    assert outcome.notes == ("b steps by 0.01 s, 5 times in each step",)
    with Dataset(tmp_path / "r.nc") as file:
        assert file["b"].step_size == "0.01 s"
        assert "step_size" not in file["a"].ncattrs()
    sampled = prepare(pair(c_fmu, "0.2 s"))
    found = {link.source.component: timing for link, timing in sampled.timings.items()}
    assert found == {"a": Timing.TAKEN, "b": Timing.HELD}
    (note, *_) = run(pair(c_fmu, options="+constant")).notes
    assert note == "b steps by 0.05 s (the only size of step that its FMU makes)"


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


def test_a_step_inside_an_fmu(c_fmu: Fmus, inside: Callable[[str, float], None]) -> None:
    inside("partner", 0.01)
    assert prepare(pair(c_fmu)).rates == {"b": ComponentStep(0.01, pieces=5)}
    assert prepare(pair(c_fmu, "50 ms")).rates == {"b": ComponentStep(0.05)}
    with pytest.raises(InputError, match=r"not a multiple of 0.01 s, its FMU's own step"):
        prepare(pair(c_fmu, "1/60 s"))
    with pytest.raises(InputError, match=r"has internal steps of 0.01 s .*: .* goes 3.7 times"):
        prepare(pair(c_fmu, step_size=0.037))
    with pytest.raises(InputError, match=r"has internal steps of 0.01 s .*: .* goes 2.5 times"):
        prepare(pair(c_fmu, step_size=0.025))


@pytest.mark.parametrize("size", [0.04, 0.02, 0.01])
def test_jumps_beside_steps_inside_are_in_the_stated_error(
    c_fmu: Fmus, inside: Callable[[str, float], None], size: float
) -> None:
    """A ball bounces at the end of a step inside, of 1 ms; what it drives, ∫ v dt, is h − h(0)."""
    inside("ball", 0.001)
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
    outcome, second = checked(pair(c_fmu, "10 ms"))
    assert isinstance(outcome.certificate, CouplingErrorReport)
    # both state the same error, the one at H/2 by the next order of the step less
    assert second.errors[0].error == pytest.approx(outcome.certificate.errors[0].error, rel=0.5)


@pytest.mark.parametrize("options", ["", "+discrete", "+discrete+constant"])
def test_the_error_beside_one_step_in_three(c_fmu: Fmus, options: str) -> None:
    outcome, second = checked(pair(c_fmu, "0.15 s", options=options))
    assert isinstance(outcome.certificate, CouplingErrorReport)
    # the step of b is twice, and half as long too if it is not sampled: what they differ by is of
    # the next order of it, ωH with ω² = 3
    assert outcome.certificate.errors[0].error == pytest.approx(
        second.errors[0].error, rel=1e-9 if options else 0.15 * np.sqrt(3)
    )
    assert outcome.certificate.longer == ({} if options else {"b": ""})
    assert (second.errors[0].error > 0.01) == (not options)


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


def test_rows_between_the_points_of_a_sampled_component_hold(c_fmu: Fmus, tmp_path: Path) -> None:
    run(pair(c_fmu, "0.2 s"), results=tmp_path / "r.nc")
    force = load(tmp_path / "r.nc")["b.end.force_x"].values
    np.testing.assert_array_equal(force[:20].reshape(5, 4), force[:20:4, None].repeat(4, axis=1))
    assert len(np.unique(force)) == 6
