"""The stated coupling error against the true one, for systems with sudden events."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import xarray as xr
from support.c_fmus.kinds import build_kinds
from support.eventful_systems import Event, EventfulSystem, eventful_system, made
from support.small_systems import Fmus

from m4e_fmi.cosim import Component, CouplingErrorReport, FmuFile, Simulation, run
from m4e_fmi.cosim.error import estimator


@pytest.mark.verifies(
    "coupling error that every run states, chains with contacts, impacts, switches and bursts at "
    "random times, half of them nonlinear: true error at most",
    independent="one set of equations, DOP853, tolerance 1e-13",
    tolerance="3",
)
@pytest.mark.parametrize(
    ("event", "seed"),
    [("contact", 1), ("impact", 2), ("impact", 3), ("switch", 4), ("switch", 5), ("burst", 6)],
)
def test_what_happens_at_once_is_in_the_stated_error(c_fmu: Fmus, event: Event, seed: int) -> None:
    rng = np.random.default_rng(seed)
    system = eventful_system(
        c_fmu, rng, algorithm="corrector", event=event, nonlinear=seed % 2 == 0, steps=(60, 150)
    )
    true, stated, outcome = system.true_and_stated()
    assert true / 3 < stated < 10 * true
    certificate = outcome.certificate
    assert isinstance(certificate, CouplingErrorReport)
    assert certificate.coverage is not None
    assert certificate.coverage.share == 1.0


@pytest.mark.parametrize(("rigid", "seed"), [("some", 7), ("all", 8)])
def test_a_second_set_meets_what_happens_at_once(
    c_fmu: Fmus, rigid: Literal["some", "all"], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    system = eventful_system(
        c_fmu, rng, algorithm="gauss_seidel", event="impact", rigid=rigid, steps=(60, 150)
    )
    true, stated, _ = system.true_and_stated()
    assert true / 3 < stated < 10 * true


@pytest.mark.parametrize("seed", [9, 10])
def test_the_error_of_a_switch_is_of_first_order(c_fmu: Fmus, seed: int) -> None:
    rng = np.random.default_rng(seed)
    system = eventful_system(
        c_fmu, rng, algorithm="gauss_seidel", event="switch", rigid="some", steps=(60, 100)
    )
    true, stated, outcome = system.true_and_stated()
    assert true < stated < 5 * true
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert outcome.certificate.errors[0].halved == pytest.approx(stated / 2)


def test_a_switch_beyond_the_first_window_is_repeated(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    # the first 256 steps are a window; the switch is at about nine tenths of 400
    monkeypatch.setattr(estimator, "FIRST", 256)
    rng = np.random.default_rng(3)
    system = eventful_system(
        c_fmu, rng, algorithm="corrector", event="switch", steps=(400, 401), share=(0.9, 0.91)
    )
    true, stated, outcome = system.true_and_stated()
    assert true / 3 < stated < 10 * true
    certificate = outcome.certificate
    assert isinstance(certificate, CouplingErrorReport)
    assert certificate.coverage is not None
    spans = certificate.coverage.repeated[1:]
    assert any(since * 1e-9 < system.moment < until * 1e-9 for since, until in spans)


def test_the_results_say_how_large_the_error_is(c_fmu: Fmus, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    system = eventful_system(
        c_fmu, rng, algorithm="corrector", event="contact", steps=(60, 61)
    ).system
    outcome = run(system, results=tmp_path / "r.nc")
    assert isinstance(outcome.certificate, CouplingErrorReport)
    attributes = xr.open_datatree(tmp_path / "r.nc").attrs
    assert attributes["coupling_error"] == str(outcome.certificate)
    assert attributes["coupling_error_from"] == str(outcome.certificate.coverage)


@pytest.mark.verifies(
    "coupling error stated where kinks are many, of which windows tell: true error at most",
    independent="one set of equations, DOP853, tolerance 1e-13",
    tolerance="3",
)
def test_many_kinks_are_judged_in_windows(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    # as in a run of 2,048 steps for each 256
    monkeypatch.setattr(estimator, "FIRST", 256)
    monkeypatch.setattr(estimator, "MANY", 6)
    system = eventful_system(
        c_fmu,
        np.random.default_rng(30),
        algorithm="gauss_seidel",
        event="contact",
        nonlinear=True,
        steps=(1500, 2000),
        share=(0.01, 0.1),
    )
    true, stated, outcome = system.true_and_stated()
    assert true / 3 < stated < 5 * true
    assert isinstance(outcome.certificate, CouplingErrorReport)
    coverage = outcome.certificate.coverage
    assert coverage is not None
    assert coverage.share < 0.7


def springs(fmus: Fmus, hard: float, mild: float, later: float, steps: int) -> EventfulSystem:
    """Three masses: mild contacts all along, and hard ones from a step on."""
    step = 0.04
    return made(
        fmus,
        [
            {"coupling": 0.0},
            {"between": 1.0, "stop": 0.0, "stop_stiffness": mild, "armed": 0.0},
            {"coupling": 0.5, "stop": 0.5, "stop_stiffness": hard, "armed": later * step},
        ],
        [1.0, -0.6, 0.8],
        Simulation(steps * step, step, "gauss_seidel"),
    )


@pytest.mark.verifies(
    "coupling error stated where hard contacts come after many mild ones: true error at most",
    independent="one set of equations, DOP853, tolerance 1e-13",
    tolerance="3",
)
def test_hard_contacts_after_many_mild_ones(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(estimator, "FIRST", 512)
    true, stated, outcome = springs(c_fmu, 100.0, 0.05, 1250, 2200).true_and_stated()
    assert true / 3 < stated < 5 * true
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert outcome.certificate.coverage is not None


@pytest.mark.verifies(
    "coupling error stated of ringing after a burst that no window meets: true error at most",
    independent="one set of equations, DOP853, tolerance 1e-13",
    tolerance="2",
)
@pytest.mark.parametrize("stop", [9.0, 0.05], ids=["alone", "with contacts"])
def test_ringing_after_a_burst(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, stop: float) -> None:
    monkeypatch.setattr(estimator, "FIRST", 256)
    step = 0.03
    burst = {"burst": 550 * step + 0.007, "burst_width": 8 * step, "burst_force": 30.0}
    contact = {"stop": stop, "stop_stiffness": 2.0, "armed": 0.0}
    system = made(
        c_fmu,
        [
            {"coupling": 0.0, "mass": 0.05, "stiffness": 8.0, **burst, **contact},
            {"coupling": 0.3},
            {"coupling": 0.5},
        ],
        [0.02, -0.6, 0.8],
        Simulation(1020 * step, step, "gauss_seidel"),
    )
    true, stated, _ = system.true_and_stated()
    assert true / 2 < stated < 5 * true


@pytest.mark.parametrize("late", [0.4, 1.4])
def test_a_switch_is_seen_wherever_it_is_in_the_longer_step(c_fmu: Fmus, late: float) -> None:
    """In the second half of a step of twice the length, both runs would meet it at its end."""
    step = 0.005
    switch = {"switched": (16 + late) * step, "switch_factor": 2.5}
    system = made(
        c_fmu,
        [{"coupling": 0.0}, {"coupling": 2.0, **switch}],
        [0.5, -0.3],
        Simulation(40 * step, step, "jacobi"),
    )
    true, stated, _ = system.true_and_stated()
    assert true < stated < 10 * true


@pytest.mark.verifies(
    "coupling error stated where a motion leaves an unstable rest beyond its first window: true"
    " error over it",
    independent="one set of equations, DOP853, tolerance 1e-13",
    tolerance="0.5 to 1.5",
)
def test_errors_that_grow_quickly_are_followed(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimator, "FIRST", 128)
    system = made(
        c_fmu,
        [{"coupling": 0.0, "stiffness": -1.0, "cubic": 1.0}, {"coupling": 0.2}],
        [1e-4, 0.0],
        Simulation(30.0, 0.02, "gauss_seidel"),
    )
    true, stated, _ = system.true_and_stated()
    assert 0.5 < true / stated < 1.5


def test_a_run_that_diverges_is_not_called_accurate(c_fmu: Fmus) -> None:
    """The steps that may be made again are spent before it has grown."""
    system = made(
        c_fmu,
        [{"coupling": 0.0, "stiffness": 10.0}, {"coupling": 20.0, "stiffness": 10.0}],
        [0.1, 0.0],
        Simulation(200.0, 0.02, "jacobi"),
    ).system
    certificate = run(system).certificate
    assert isinstance(certificate, CouplingErrorReport)
    assert certificate.coverage
    assert certificate.coverage.lost
    assert certificate.errors[0].error > 0.1


def test_kinks_of_fmus_that_make_one_size_of_step_only(c_fmu: Fmus) -> None:
    """Nothing tells their errors but steps of twice the length, all of which these can make."""
    system = made(
        c_fmu,
        [
            {"coupling": 0.0},
            {"between": 1.0, "stop": 0.0, "stop_stiffness": 0.05, "armed": 0.0},
            {"coupling": 0.5},
        ],
        [1.0, -0.6, 0.8],
        Simulation(40.0, 0.04, "gauss_seidel"),
        kind="member+state+constant",
    )
    true, stated, outcome = system.true_and_stated()
    assert true / 3 < stated < 3 * true
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert str(outcome.certificate.coverage) == "all of the run repeated"


def test_changes_in_every_step_leave_an_estimate_or_a_reason(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A window without a step of another length tells nothing."""
    monkeypatch.setattr(estimator, "FIRST", 64)
    system = springs(c_fmu, 100.0, 5.0, 0, 300).system
    kinds = FmuFile(build_kinds(2, ["state"], tmp_path))
    encoder = (Component("a", kinds, {"period": 0.04}), Component("b", kinds, {"period": 0.0}))
    system = replace(
        system,
        components=(*system.components, *encoder),
        connections=(*system.connections, "a.y_bool -> b.u_bool"),
    )
    outcome = run(system)
    assert outcome.certificate
