"""Adaptive steps: error per FMU step, rejections, and where the steps must end.

Two-mass oscillator with a damper of 0.1 N·s/m between the masses, t = 10; the best of other
adaptive masters has an error of 3.4e-5 at 3,300 steps of one FMU.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from support.small_systems import Fmus, observed, system
from support.two_masses import STATES, two_masses

from m4e_fmi.cosim import Outcome, Simulation, System, run
from m4e_fmi.cosim.stepping.step_control import SMALLEST
from m4e_fmi.errors import RunError

D = 0.1
MATRIX = np.array([[0, 1, 0, 0], [-2, -D, 1, D], [0, 0, 0, 1], [1, D, -2, -D]])
EXACT = expm(10 * MATRIX)[:, 0]


def oscillator(fmus: Fmus, options: str, **settings: Any) -> System:
    pair = two_masses(fmus, f"mass{options}", f"partner{options}").changed(**settings)
    first, second = pair.components
    return replace(pair, components=(first, replace(second, start={"damping": D})))


def error(
    fmus: Fmus,
    options: str,
    tolerance: float | None,
    step: float = 0.5,
    algorithm: str = "corrector",
) -> tuple[float, Outcome]:
    settings = {"step_size": step, "algorithm": algorithm, "coupling_tolerance": tolerance}
    rows, outcome = observed(oscillator(fmus, options, **settings), *STATES)
    return float(np.abs(rows[-1][1:] - EXACT).max()), outcome


def fmu_steps(outcome: Outcome, pieces: int) -> int:
    """Steps of one FMU: two passes in so many pieces, three in the first step."""
    return pieces * (2 * (outcome.steps + outcome.rejected) + 1)


@pytest.mark.verifies(
    "damped two-mass oscillator by adaptive steps, below 3,300 steps of one FMU",
    analytic="matrix exponential",
    tolerance="3e-6",
)
@pytest.mark.parametrize(("options", "pieces"), [("+state", 4), ("+state+inputs", 2)])
def test_error_and_steps(c_fmu: Fmus, options: str, pieces: int) -> None:
    found, outcome = error(c_fmu, options, 1e-5)
    assert found < 3e-6
    assert fmu_steps(outcome, pieces) < 3300
    assert 0 < outcome.rejected < 0.1 * outcome.steps  # while the first step is found


@pytest.mark.parametrize("options", ["+state", "+state+inputs"])
def test_fixed_steps_are_of_third_order_with_a_damper_too(c_fmu: Fmus, options: str) -> None:
    # the force follows a velocity at once: what is predicted least well
    errors = [error(c_fmu, options, None, step)[0] for step in (0.1, 0.05, 0.025)]
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > 2.9


def test_error_follows_the_tolerance(c_fmu: Fmus) -> None:
    errors, steps = zip(
        *((e, o.steps) for e, o in (error(c_fmu, "+state", t) for t in (1e-3, 1e-4, 1e-5))),
        strict=True,
    )
    # a tenth of the tolerance: a tenth of the error, at 10^(1/3) = 2.2 times the steps
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert 1.5 < steps[1] / steps[0] < 3
    assert 1.5 < steps[2] / steps[1] < 3


def test_steps_are_within_bounds_and_meet_the_rows(c_fmu: Fmus, tmp_path: Path) -> None:
    settings = {"step_size": 0.25, "output_interval": 0.5, "coupling_tolerance": 1e-4}
    rows, outcome = observed(oscillator(c_fmu, "+state", **settings), results=tmp_path / "r.nc")
    times = np.ravel(rows)
    assert times[-1] == 10.0
    assert np.diff(times).max() <= 0.25 + 1e-12
    np.testing.assert_allclose(outcome.results().time, np.arange(0, 21) * 0.5, atol=1e-12)


def test_an_fmu_that_cannot_go_back_is_named(c_fmu: Fmus) -> None:
    with pytest.raises(RunError, match="which a and b cannot"):
        run(oscillator(c_fmu, "", coupling_tolerance=1e-4))


@pytest.mark.parametrize(
    ("algorithm", "order"), [("gauss_seidel", 2), ("implicit", 2), ("jacobi", 1)]
)
def test_other_algorithms_double_their_steps(c_fmu: Fmus, algorithm: str, order: int) -> None:
    coarse, _ = error(c_fmu, "+state", 1e-3, algorithm=algorithm)
    fine, outcome = error(c_fmu, "+state", 1e-4, algorithm=algorithm)
    # the error of a step falls to a tenth, steps by the power 1/(p + 1), what they add up to by
    # p/(p + 1); a half of that is left to the sizes that do not fit exactly
    assert coarse / fine > 10 ** (order / (order + 1)) / 2
    assert outcome.rejected > 0


def test_the_certificate_holds_for_halves_too(c_fmu: Fmus) -> None:
    found, outcome = error(c_fmu, "+state", 1e-6, algorithm="gauss_seidel")
    assert not isinstance(outcome.certificate, str)
    assert found < 3 * outcome.certificate.errors[0].error


def test_what_no_step_resolves_is_an_error(c_fmu: Fmus) -> None:
    # y'' = 1e18 y needs steps of 1e-11 s
    parts = {"a": "integrator+state", "b": "integrator+state"}
    start = {"a": {"y": 1.0, "gain": 1e9}, "b": {"gain": 1e9}}
    settings = Simulation(1.0, 0.5, "corrector", coupling_tolerance=1e-6)
    pair = system(c_fmu, parts, "a.y -> b.u", "b.y -> a.u", start=start, simulation=settings)
    with pytest.raises(RunError, match=r"coupling error of .* stays above coupling_tolerance"):
        run(pair)


def two_integrals(fmus: Fmus, settings: Simulation, **start: float) -> System:
    """A source s, its integral a, and the integral b of that."""
    parts = {"s": "rogue+state", "a": "integrator+state", "b": "integrator+state"}
    links = ("s.y -> a.u, units ignored", "a.y -> b.u")
    return system(fmus, parts, *links, start={"s": start}, simulation=settings)


def test_a_signal_that_starts_at_zero_does_not_stop_the_run(c_fmu: Fmus) -> None:
    # of y = t²/2 a first-order step misses a share that does not depend on its size
    settings = Simulation(2.0, 0.1, "jacobi", coupling_tolerance=1e-5)
    rows, outcome = observed(two_integrals(c_fmu, settings, when=9.0), "a.y", "b.y")
    t, a, b = np.array(rows).T
    off = np.abs([a - t**2 / 2, b - t**3 / 6])
    assert not isinstance(outcome.certificate, str)
    stated = next(e for e in outcome.certificate.errors if e.connection == "a.y -> b.u")
    assert off.max() < 3 * stated.error * 2.0  # of a range of 2
    assert off.max() > stated.error * 2.0 / 5


@pytest.mark.verifies(
    "two-position control, which switches within steps at times nobody announces",
    analytic="triangle wave",
    tolerance="2 per second of passing steps",
)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_steps_shrink_onto_a_jump_and_pass_over_it(c_fmu: Fmus, tolerance: float) -> None:
    # x' = y, where y is 1 up to x = 0.5 and -1 down to x = -0.5
    parts = {"r": "relay+state+inputs", "i": "integrator+state+inputs"}
    step, stop = 0.1, 5.2
    settings = Simulation(stop, step, coupling_tolerance=tolerance)
    loop = system(c_fmu, parts, "r.y -> i.u", "i.y -> r.u", simulation=settings)
    rows, outcome = observed(loop, "i.y")
    t, x = np.array(rows).T
    s = (t + 0.5) % 2.0
    off = np.abs(x - np.where(s <= 1, -0.5 + s, 1.5 - s))
    # each of five jumps is found in a step of 1e-6 of the largest; the slope then changes by 2
    assert off.max() < 5 * 2 * SMALLEST * step
    assert outcome.rejected > 5 * 6  # from the largest step to the smallest, by fifths at most


def test_a_jump_costs_no_more_than_finding_it(c_fmu: Fmus) -> None:
    # y = t, and 100 more from 0.737 s on; the source alone knows when
    settings = Simulation(2.0, 0.1, coupling_tolerance=1e-5)
    rows, outcome = observed(two_integrals(c_fmu, settings, what=7.0, when=0.737), "a.y")
    assert 0 < outcome.rejected <= 20
    assert outcome.steps < 20 + 3 * 20
    # the jump lies in one step of at most 1e-6 of the largest, and in no other
    exact = 2.0 + 100 * (2.0 - 0.737)
    assert rows[-1] == [2.0, pytest.approx(exact, abs=100 * SMALLEST * 0.1)]
