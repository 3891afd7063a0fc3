"""Runs stepped from Python: what may be set, what is refused, results after going back."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    Execution,
    FmuFile,
    Simulation,
    System,
    load,
    start,
)
from m4e_fmi.errors import InputError, RunError

Fmus = Callable[[str], Path]


def oscillator(fmus: Fmus, options: str = "+state") -> System:
    """A damped mass of 1 kg on a spring of 1 N/m, released at rest at x = 1 m."""
    body = Component("body", FmuFile(fmus(f"mass{options}")), {"body.m.x": 1.0, "damping": 0.2})
    spring = Component("spring", FmuFile(fmus(f"spring{options}")))
    return System("s", (body, spring), ("body.m <-> spring.end",), Simulation(2, 0.1))


def go(run: Execution, steps: int) -> None:
    for _ in range(steps):
        run.step()


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("body.dampin", 1.0, "'body.damping'"),
        ("mass", 1.0, "no variable is called mass"),
        ("body.body.m.x", 1.0, "output\n.*body.damping, spring.damping"),
        ("body.mass", 1.0, "fixed parameter"),
        ("body.body.m.force_x", 1.0, "connected to spring.end.force_x"),
        ("body.damping", "2 kg", "N.s/m"),
        ("body.damping", True, "wrong"),
        ("body.damping", float("nan"), "finite"),
    ],
)
def test_what_cannot_be_set(c_fmu: Fmus, name: str, value: float | str, message: str) -> None:
    with start(oscillator(c_fmu)) as run, pytest.raises(InputError, match=message):
        run[name] = value


def test_what_is_set_shows_at_once(c_fmu: Fmus) -> None:
    with start(oscillator(c_fmu)) as run:
        assert run.settable == ["body.damping", "spring.damping"]
        point = run.step()
        expected = -run["spring.stiffness"] * point["body.body.m.x"]
        assert point["spring.end.force_x"] == pytest.approx(expected, rel=1e-12)
        run["spring.damping"] = "500 g/s"
        expected -= 0.5 * point["body.body.m.vx"]
        assert run["spring.damping"] == 0.5
        assert point["spring.end.force_x"] == pytest.approx(expected, rel=1e-12)
        assert point["body.body.m.ax"] == pytest.approx(
            expected - 0.2 * point["body.body.m.vx"], rel=1e-12
        )


def test_what_a_run_refuses(c_fmu: Fmus) -> None:
    with start(oscillator(c_fmu)) as run, start(oscillator(c_fmu)) as other:
        point = run.point
        run.step()
        with pytest.raises(RunError, match=r"the run has passed t = 0 s"):
            point["body.body.m.x"]
        with pytest.raises(RunError, match="no outcome yet"):
            _ = run.outcome
        with pytest.raises(RunError, match="belongs to another run"):
            other.restore(run.save())
    with pytest.raises(RunError, match="the run has ended"):
        run.step()
    with start(oscillator(c_fmu, options="")) as run:
        with pytest.raises(RunError, match="cannot be saved: body and spring cannot roll back"):
            run.save()
        assert len(list(run)) == 21


def test_branches_leave_no_trace_in_the_certificate(c_fmu: Fmus) -> None:
    """It is that of the course that led here, of 600 steps, past its first two windows."""
    system = oscillator(c_fmu).changed(stop_time=60.0, algorithm="gauss_seidel")
    with start(system) as straight:
        go(straight, 600)
    with start(system) as run:
        first = run.save()
        go(run, 100)
        early = run.save()
        go(run, 50)
        later = run.save()
        run.restore(first)
        run["body.damping"] = 30.0  # far too much for such a step
        go(run, 400)
        late = run.save()
        run.restore(early)
        go(run, 20)
        for state in (late, early, later):
            run.restore(state)
        go(run, 450)
    assert isinstance(straight.outcome.certificate, CouplingErrorReport)
    assert run.outcome.certificate == straight.outcome.certificate


@pytest.mark.parametrize("options", ["", "+state"])
def test_a_step_that_failed_leaves_an_outcome(c_fmu: Fmus, options: str) -> None:
    """And can be left behind, if the FMUs can go back."""
    pump = Component("pump", FmuFile(c_fmu(f"rogue{options}")), {"what": 3.0, "when": 0.5})
    parts = (*oscillator(c_fmu, options).components, pump)
    system = System("s", parts, ("body.m <-> spring.end",), Simulation(2, 0.1))
    with start(system) as run:
        state = run.save() if options else None
        go(run, 4)
        with pytest.raises(RunError, match="the pump ran dry"):
            run.step()
        if state:
            run.restore(state)
            with pytest.raises(RunError, match="the pump ran dry"):
                list(run)
    assert run.outcome.steps == 4
    assert run.outcome.certificate


@pytest.mark.parametrize("flush", [False, True])
@pytest.mark.parametrize("name", ["r.nc", "r.csv"])
def test_results_are_of_the_last_course(
    c_fmu: Fmus, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch, *, flush: bool
) -> None:
    if flush:  # each row reaches the disk
        monkeypatch.setattr("m4e_fmi.cosim.results.writer.FLUSH", 0.0)
    with start(oscillator(c_fmu), results=tmp_path / name) as run:
        go(run, 5)
        state = run.save()
        run.step()
        later = run.save()
        list(run)
        run.restore(state)
        with pytest.raises(RunError, match="were discarded"):
            run.restore(later)
        run["body.damping"] = 2.0
        expected = [run.step()["body.body.m.x"] for _ in range(3)]
    results = load(tmp_path / "r.nc")
    np.testing.assert_allclose(results.time, np.arange(9) * 0.1, atol=1e-12)
    assert results["body.body.m.x"].values[-3:].tolist() == expected
    assert results["body.body.m.x"].unit == "m"
    if name == "r.csv":
        rows = list(csv.reader((tmp_path / name).open(encoding="utf-8")))
        assert float(rows[-1][0]) == pytest.approx(0.8)


def test_a_mistake_in_the_block_leaves_the_results(c_fmu: Fmus, tmp_path: Path) -> None:
    def mistaken() -> None:
        with start(oscillator(c_fmu), results=tmp_path / "r.csv") as run:
            run.step()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        mistaken()
    rows = list(csv.reader((tmp_path / "r.csv").open(encoding="utf-8")))
    assert float(rows[-1][0]) == 0.1
