"""Events of FMI 3.0 FMUs: steps end there, or the run reports that they did not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system, watched

from m4e_fmi.cosim import CouplingErrorReport, Outcome, Simulation, load, run, start

G, E = 10.0, 0.5
FIRST = np.sqrt(2 / G)
"""s, the fall from 1 m."""
IMPACTS = FIRST * np.array([1.0, 2.0, 2.5, 2.75, 2.875])
"""s; each flight takes E times as long as the one before."""
INTEGRAL = 2 / 3 * FIRST + 2 / 3 * (E * G * FIRST) ** 3 / G**2 * (1 + 1 / 8 + 1 / 64 + 1 / 512)
"""m s, of the height up to the fifth impact: a half parabola and four whole ones."""
NANOSECOND = 1e-9


def bounce(
    fmus: Fmus,
    ball: str,
    *,
    integrator: str = "integrator+state",
    stop: float = 5.0,
    tolerance: float | None = None,
    algorithm: str = "corrector",
    **values: float,
) -> tuple[np.ndarray, Outcome]:
    """Time, height, velocity, impacts and integral of the height at all points."""
    settings = Simulation(stop, 0.1, algorithm, coupling_tolerance=tolerance)
    pair = system(
        fmus,
        {"ball": ball, "sum": integrator},
        "ball.h -> sum.u, units ignored",
        start={"ball": {"last": 5.0, **values}},
        simulation=settings,
    )
    rows, outcome = observed(pair, "ball.h", "ball.v", "ball.hits", "sum.y")
    return np.array(rows), outcome


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
@pytest.mark.parametrize("step", [0.1, 0.0052, 1.2858 / 256])
def test_the_end_is_where_the_ball_asks_for_it(
    c_fmu: Fmus, tmp_path: Path, algorithm: str, step: float
) -> None:
    """The last of the steps may be that with which a window of the certificate closes."""
    pair = system(
        c_fmu,
        {"ball": "3:ball+events+state", "sum": "integrator+state"},
        "ball.h -> sum.u, units ignored",
        start={"ball": {"last": 5.0}},
        simulation=Simulation(5.0, step, algorithm),
    )
    outcome = run(pair, results=tmp_path / "r.nc")
    results = load(tmp_path / "r.nc")
    assert results.time[-1] == pytest.approx(IMPACTS[-1], abs=step + NANOSECOND)
    assert results["ball.hits"].values[-1] == 5.0
    assert isinstance(outcome.certificate, CouplingErrorReport)
    with start(pair) as stepped:
        times = [point.time for point in stepped]
    assert len(set(times)) == len(times) == outcome.steps + 1


@pytest.mark.verifies(
    "bouncing ball (FMI 3.0, event mode, early return) and the integral of its height",
    analytic="flights are parabolas",
    tolerance="1e-9",
)
@pytest.mark.parametrize("announces", [0.0, 1.0])
@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize("tolerance", [None, 1e-5])
def test_all_stop_at_impacts(c_fmu: Fmus, announces: float, tolerance: float | None) -> None:
    points, outcome = bounce(c_fmu, "3:ball+events+state", announces=announces, tolerance=tolerance)
    times, hits = points[:, 0], points[:, 3]
    at = [times[np.argmax(hits == k)] for k in range(1, 6)]
    np.testing.assert_allclose(at, IMPACTS, rtol=0, atol=NANOSECOND)
    assert points[-1, 2] == pytest.approx(E**5 * G * FIRST, abs=1e-12)
    # a parabola that passes through three exact values is integrated exactly
    assert points[-1, 4] == pytest.approx(INTEGRAL, abs=1e-9)
    # the fifth impact was asked to be the end
    assert times[-1] == pytest.approx(IMPACTS[-1], abs=NANOSECOND)
    assert "ball requested the end of the simulation at t = 1.2857" in outcome.notes[-1]
    if tolerance is None:
        assert outcome.rejected == (0 if announces else 5)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert outcome.certificate.errors[0].error < 1e-8


def test_the_error_is_stated_where_impacts_hang_on_the_coupling(c_fmu: Fmus) -> None:
    """Courses of other steps have theirs some nanoseconds earlier or later."""
    links = ("ball.h -> lag.u, units ignored", "lag.y -> ball.push, units ignored")
    pair = system(
        c_fmu,
        {"ball": "3:ball+events+state", "lag": "lag+state"},
        *links,
        start={"ball": {"restitution": 0.9}},
        simulation=Simulation(2.0, 0.02, "corrector"),
    )
    heights: list[list[float]] = []
    outcomes: list[Outcome] = []
    for step in (0.02, 0.001):
        rows, outcome = observed(pair.changed(step_size=step), "ball.h")
        heights.append([h for t, h in rows if abs(t / 0.02 - round(t / 0.02)) < 1e-9])
        outcomes.append(outcome)
    certificate = outcomes[0].certificate
    coarse, fine = np.array(heights)
    true = np.abs(coarse - fine).max() / np.ptp(fine)
    assert isinstance(certificate, CouplingErrorReport)
    assert true / 3 < certificate.errors[0].error < 20 * true


@pytest.mark.verifies(
    "bouncing ball without rollback",
    analytic="flights are parabolas",
    tolerance="1e-12",
)
@pytest.mark.parametrize("algorithm", ["corrector", "jacobi"])
@pytest.mark.usefixtures("loop")
def test_a_ball_that_cannot_go_back_goes_on(c_fmu: Fmus, algorithm: str) -> None:
    parts = {"integrator": "integrator", "stop": 1.2, "algorithm": algorithm}
    points, outcome = bounce(c_fmu, "3:ball+events", **parts)
    inside, _ = bounce(c_fmu, "3:ball", **parts)
    np.testing.assert_allclose(points[:, 0], np.linspace(0, 1.2, 13), rtol=0, atol=1e-12)
    # impacts are handled at their own times: as in the FMU that needs no event mode
    np.testing.assert_allclose(points[:, 1:4], inside[:, 1:4], rtol=0, atol=1e-12)
    assert points[-1, 3] == 3
    assert "ball had 3 events within steps, at which the other components" in outcome.notes[-1]


def test_announced_impacts_are_met_by_those_that_cannot_go_back(c_fmu: Fmus) -> None:
    points, outcome = bounce(
        c_fmu, "3:ball+events", integrator="integrator", announces=1.0, algorithm="gauss_seidel"
    )
    assert points[-1, 0] == pytest.approx(IMPACTS[-1], abs=NANOSECOND)
    assert not any("within steps" in note for note in outcome.notes)


def test_the_last_row_of_the_results_is_the_end(c_fmu: Fmus, tmp_path: Path) -> None:
    ball, settings = {"ball": "3:ball+events+state"}, Simulation(5.0, 0.1, output_interval=0.2)
    alone = system(c_fmu, ball, start={"ball": {"last": 1.0}}, simulation=settings)
    outcome = run(alone, results=tmp_path / "r.nc", certify=False)
    results = outcome.results()
    np.testing.assert_allclose(results.time, [0.0, 0.2, 0.4, FIRST], rtol=0, atol=NANOSECOND)
    assert results["ball.hits"].values[-1] == 1.0


def test_an_fmu_without_event_mode_ends_the_simulation_too(c_fmu: Fmus) -> None:
    points, outcome = bounce(c_fmu, "3:ball", integrator="integrator")
    assert points[-1, 0] == pytest.approx(1.3)
    assert "requested the end" in outcome.notes[-1]
    assert "the run ended before its stop time" in outcome.warnings[-1]


def test_an_fmu_that_declares_event_mode_and_refuses_it(c_fmu: Fmus) -> None:
    refusing, other = (
        watched(system(c_fmu, {"lag": fmu}, start={"lag": {"u": 1.0}}), "lag.y")
        for fmu in ("3:lag+refuses", "3:lag")
    )
    assert refusing == other


def test_a_discrete_input_and_a_tunable_parameter_are_set_in_event_mode(c_fmu: Fmus) -> None:
    settings = Simulation(1.0, 0.125, "jacobi")
    with start(system(c_fmu, {"ball": "3:ball+events+state"}, simulation=settings)) as stepped:
        before = stepped.save()
        stepped["ball.kick"] = 3.0
        stepped["ball.restitution"] = 1.0
        assert stepped["ball.v"] == 3.0
        stepped.step()
        assert stepped["ball.v"] == pytest.approx(3.0 - G * 0.125, abs=1e-12)
        while not stepped.done:
            stepped.step()
        duration = (3 + np.sqrt(9 + 2 * G)) / G
        after = np.sqrt(9 + 2 * G) - G * (1.0 - duration)
        assert stepped["ball.v"] == pytest.approx(after, abs=1e-9)
        stepped.restore(before)
        stepped.step()
        assert stepped["ball.v"] == pytest.approx(-G * 0.125, abs=1e-12)


@pytest.mark.usefixtures("loop")
def test_a_connected_discrete_input_is_set_in_event_mode_where_it_changes(c_fmu: Fmus) -> None:
    # y of the stage is the time: 0, 1/8, 2/8 ...; each change takes that off the velocity
    pair = system(
        c_fmu,
        {"stage": "stage", "ball": "3:ball+events"},
        "stage.y * -1 -> ball.kick, units ignored",
        start={"ball": {"h": 100.0, "last": 1.0}, "stage": {"gain": 0.0}},
        simulation=Simulation(0.5, 0.125, "jacobi"),
    )
    found = np.ravel(watched(pair, "ball.v"))
    kicks = np.cumsum([0, 1, 2, 3, 4]) / 8
    expected = -kicks - G * np.arange(5) / 8
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    # a kick that comes when the ball has already asked for the end
    outcome = run(pair.changed(stop_time=60.0))
    assert "ball requested the end" in outcome.notes[-1]
