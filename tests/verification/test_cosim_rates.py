"""Components with more or fewer steps than their system: order, error, exact samples.

Two-mass oscillator of support/two_masses.py, one of the two stepped by H/n. The order follows from
what acts on it (`m4e_fmi/cosim/stepping/input_interpolation.py`): held values with the first moment
of the course leave third order, one held value, right in its mean only, second. A sampled component
gives constants to the others, so that its system has the exact course whatever the step. A longer
step of a mass is an approximation like any other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from support.small_systems import Fmus, observed, system, watched
from support.two_masses import EXACT, STATES, two_masses

from m4e_fmi.cosim import Component, CouplingErrorReport, Outcome, Simulation, System, prepare
from m4e_fmi.cosim.error.report import LARGE

STEPS = (0.1, 0.05, 0.025)
FAST = np.sqrt(3.0)
EVERY = ["jacobi", "gauss_seidel", "corrector", "implicit"]
HOLDS, FOLLOWS = "+state", "+state+inputs"


def stepped(fmus: Fmus, options: str, side: str, pieces: int, step: float) -> System:
    """The oscillator at H = `step`, the component `side` stepped by H/pieces."""
    pair = two_masses(fmus, f"mass{options}", f"partner{options}")
    return replace(pair.changed(step_size=step), components=own_step(pair, side, step / pieces))


def own_step(given: System, name: str, step: float) -> tuple[Component, ...]:
    """The components, the one of this name with a step of its own [s]."""
    return tuple(replace(c, step_size=step) if c.name == name else c for c in given.components)


@pytest.mark.verifies(
    "order of the default, one side of the two-mass oscillator stepped by H/n, n = 1, 2, 3, 5, 8",
    analytic="exact solution; third order but for one held value a step",
    tolerance="0.1",
)
@pytest.mark.parametrize("options", [HOLDS, FOLLOWS])
@pytest.mark.parametrize("side", ["a", "b"])
@pytest.mark.parametrize("pieces", [1, 2, 3, 5, 8])
def test_order(c_fmu: Fmus, options: str, side: str, pieces: int) -> None:
    runs = [observed(stepped(c_fmu, options, side, pieces, step), *STATES) for step in STEPS]
    errors = np.abs([np.subtract(rows[-1][1:], [*EXACT.values()]) for rows, _ in runs]).max(axis=1)
    order = 2 if (options, pieces) == (HOLDS, 1) else 3
    assert {outcome.order for _, outcome in runs} == {order}
    # terms of the next order change it by 0.1 at these steps
    assert np.log2(errors[:-1] / errors[1:]).min() > order - 0.1
    if order == 3:
        assert errors[0] < 1e-3  # of what third order promises by 6 (H w)^3 / 10 periods
    assert any(f"{side} makes one step" in note for note in runs[0][1].notes) == (order == 2)


@pytest.mark.verifies(
    "coupling error that a run with own steps states: true one at most so many times as large",
    analytic="exact solution",
    tolerance="3",
)
@pytest.mark.parametrize("algorithm", EVERY)
@pytest.mark.parametrize(("options", "pieces"), [(HOLDS, 1), (HOLDS, 2), (HOLDS, 5), (FOLLOWS, 1)])
def test_the_certificate_knows_of_own_steps(
    c_fmu: Fmus, algorithm: str, options: str, pieces: int
) -> None:
    """Force and displacements over their ranges, at every communication point."""
    pair = stepped(c_fmu, options, "b", pieces, 0.05).changed(algorithm=algorithm)
    rows, outcome = observed(pair, "b.end.force_x", *STATES[:2])
    t, *values = np.array(rows).T
    slow, fast = np.cos(t), np.cos(FAST * t)
    exact = (-fast, (slow + fast) / 2, -(np.sin(t) + FAST * np.sin(FAST * t)) / 2)
    true = (np.abs(np.subtract(values, exact)).max(axis=1) / np.ptp(values, axis=1)).max()
    stated = outcome.certificate.errors[0].error  # pyrefly: ignore[missing-attribute]
    assert true < 3 * stated
    assert stated < 10 * true


Oscillators = tuple[float, float, float]


def coupled(
    fmus: Fmus, algorithm: str, side: str, own: float, given: Oscillators, options: str = ""
) -> tuple[System, np.ndarray]:
    """Two masses of 1 kg in steps of 0.01 s, but `side` of `own`, and their exact course.

    `given` are the stiffness of b to the wall and of the coupling [N/m], and the damping [N.s/m] of
    both walls and the coupling; a has 1 N/m to its wall. The course is x and v of a, and the force.
    """
    wall, between, damping = given
    models = {"a": "mass+state", "b": "partner+state"}
    models[side] += options
    start = {
        "a": {"stiffness": 1.0, "damping": damping, "body.m.x": 1.0},
        "b": {"stiffness": wall, "coupling": between, "damping": damping, "wall_damping": damping},
    }
    settings = Simulation(6.0, 0.01, algorithm)
    pair = system(fmus, models, "a.m <-> b.end", start=start, simulation=settings)
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-1.0 - between, -2.0 * damping, between, damping],
            [0.0, 0.0, 0.0, 1.0],
            [between, damping, -wall - between, -2.0 * damping],
        ]
    )
    whole, states = expm(0.01 * matrix), [np.array([1.0, 0.0, 0.0, 0.0])]
    for _ in range(600):
        states.append(whole @ states[-1])
    x, v, x_b, v_b = np.array(states).T
    exact = np.column_stack((x, v, between * (x_b - x) + damping * (v_b - v)))
    return replace(pair, components=own_step(pair, side, own)), exact


def stated_and_true(given: System, exact: np.ndarray) -> tuple[Outcome, float]:
    """The outcome, and the largest error over the range of its output."""
    rows, outcome = observed(given, *STATES[:2], "b.end.force_x")
    errors = np.abs(np.array(rows)[:, 1:] - exact).max(axis=0)
    return outcome, (errors / np.ptp(exact, axis=0)).max()


@pytest.mark.verifies(
    "coupling error stated of two oscillators in steps of 10 ms, one of 20, 30 or 50 ms, of "
    "several stiffnesses and dampings: true one at most so many times as large",
    analytic="matrix exponential",
    tolerance="3",
)
@pytest.mark.parametrize("algorithm", EVERY)
@pytest.mark.parametrize("side", ["a", "b"])
@pytest.mark.parametrize("own", [0.02, 0.03, 0.05])
def test_longer_steps_of_a_mass_are_in_the_stated_error(
    c_fmu: Fmus, algorithm: str, side: str, own: float
) -> None:
    cases = [(1.0, 1.0, 0.0), (100.0, 1.0, 0.0), (1.0, 0.1, 0.05), (10.0, 50.0, 0.5)]
    for given in cases if own == 0.03 else cases[:1]:
        outcome, true = stated_and_true(*coupled(c_fmu, algorithm, side, own, given))
        report = outcome.certificate
        assert isinstance(report, CouplingErrorReport)
        assert report.worst
        assert true < 3 * report.worst.error
        assert report.worst.error < 3 * true or true > LARGE  # twice the steps are unstable
        assert f"half the step and that of {side} would give" in str(report)
        assert not outcome.warnings or "unusable" in outcome.warnings[0]


@pytest.mark.parametrize("algorithm", EVERY)
def test_an_unstable_longer_step_is_unusable(c_fmu: Fmus, algorithm: str) -> None:
    outcome, true = stated_and_true(*coupled(c_fmu, algorithm, "b", 0.05, (10.0, 50.0, 0.0)))
    assert true > 10.0
    assert "and that of b, or another algorithm" in " ".join(outcome.warnings)


@pytest.mark.parametrize("algorithm", EVERY)
def test_longer_steps_that_no_other_can_replace_are_named(c_fmu: Fmus, algorithm: str) -> None:
    """True error 0.06 of the range; the FMU makes steps of one size only."""
    pair = coupled(c_fmu, algorithm, "b", 0.03, (1.0, 1.0, 0.0), "+constant")
    outcome, true = stated_and_true(*pair)
    assert true > 0.03
    report = outcome.certificate
    assert isinstance(report, CouplingErrorReport)
    assert not report.errors
    assert "longer steps of b" in str(report)
    assert any("does not count the longer steps of b" in line for line in outcome.warnings)


@pytest.mark.parametrize("version", ["", "1:", "3:"])
def test_a_sampled_controller_is_known_by_its_discrete_outputs(c_fmu: Fmus, version: str) -> None:
    found: list[list[list[float]]] = []
    for options, longer in (("", {"c"}), ("+discrete", set[str]())):
        loop = controlled(c_fmu, f"{version}integrator{options}", 0.3, Simulation(3.0, 0.1))
        assert {*prepare(loop).longer} == longer
        rows, outcome = observed(loop, "plant.y", "c.y")
        found.append(rows)
        report = outcome.certificate
        assert isinstance(report, CouplingErrorReport)
        assert report.worst
        # half the samples are another controller; what is left of a sampled one is Runge and
        # Kutta's error (0.1/20)^4
        assert (report.worst.error > 0.01) == bool(longer)
        assert (report.worst.error < 1e-9) == (not longer)
    assert found[0] == found[1]  # to the last bit


def controlled(
    fmus: Fmus, controller: str, every: float, settings: Simulation, gain: float = 1.0
) -> System:
    """A plant x' = u - x, x = 1 at first, under an integrating controller with its own step."""
    parts = {"plant": "lag+state", "c": controller}
    start = {"plant": {"y": 1.0}, "c": {"gain": gain}}
    links = ("plant.y * -1 -> c.u", "c.y -> plant.u")
    loop = system(fmus, parts, *links, start=start, simulation=settings)
    return replace(loop, components=own_step(loop, "c", every))


@pytest.mark.verifies(
    "plant under a sampled integrating controller, 1, 2, 3 and 5 steps from sample to sample",
    analytic="x(k+1) = e^-T x(k) + (1 − e^-T) u(k), u(k+1) = u(k) − g T x(k)",
    tolerance="1e-9",
)
@pytest.mark.parametrize("algorithm", EVERY)
@pytest.mark.parametrize("every", [1, 2, 3, 5])
def test_samples_are_exact(c_fmu: Fmus, algorithm: str, every: int) -> None:
    step, gain, begin = 0.1, 2.0, 0.5
    settings = Simulation(begin + 3.2, step, algorithm, start_time=begin)
    loop = controlled(c_fmu, "integrator+discrete", every * step, settings, gain)
    seen = watched(loop, "plant.y", "c.y")
    x, u, decay = 1.0, 0.0, np.exp(-every * step)
    for k in range(33):
        since = k % every
        if k and not since:
            x, u = decay * x + (1 - decay) * u, u - gain * every * step * x
        now = np.exp(-since * step)
        # of the plant's own integration: Runge and Kutta's error (0.1/20)^4 at most
        assert seen[k] == pytest.approx([now * x + (1 - now) * u, u], abs=1e-9)


@pytest.mark.verifies(
    "order of the default beside a sampled component that makes others jump",
    analytic="matrix exponential from sample to sample",
    tolerance="0.1",
)
@pytest.mark.parametrize(
    ("options", "pieces", "order"), [(HOLDS, 2, 2), (HOLDS, 4, 3), (FOLLOWS, 1, 2), (FOLLOWS, 3, 3)]
)
def test_order_beside_a_sampled_component(
    c_fmu: Fmus, options: str, pieces: int, order: int
) -> None:
    """x' = -y - c, y' = x + y/5, and c grows by 0.4 y every 0.8 s."""
    sample, count = 0.8, 10
    matrix = np.array([[0.0, -1.0, -1.0], [1.0, 0.2, 0.0], [0.0, 0.0, 0.0]])
    state, whole = np.array([1.0, 1.0, 0.0]), expm(matrix * sample)
    for _ in range(count):
        state = whole @ state + [0.0, 0.0, 0.5 * sample * state[1]]
    errors = []
    for step in (0.1, 0.05, 0.025):
        parts = {"x": f"roessler_x{options}", "yz": f"roessler_yz{options}", "c": "integrator"}
        start = {"x": {"x": 1.0}, "yz": {"y": 1.0}, "c": {"gain": 0.5}}
        links = ("x.x -> yz.x", "yz.y -> x.y", "yz.y -> c.u", "c.y -> x.z")
        settings = Simulation(count * sample, step)
        ring = system(c_fmu, parts, *links, start=start, simulation=settings)
        ring = replace(ring, components=own_step(ring, "c", sample))
        ring = replace(ring, components=own_step(ring, "x", step / pieces))
        rows, outcome = observed(ring, "x.x", "yz.y")
        assert outcome.order == order
        assert any("does not show jumps" in note for note in outcome.notes) == (order == 2)
        errors.append(np.abs(rows[-1][1:] - state[:2]).max())
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > order - 0.1


@pytest.mark.parametrize("algorithm", EVERY)
def test_a_stiff_component_has_shorter_steps(c_fmu: Fmus, algorithm: str) -> None:
    """y' = 50 (1 - y) by Euler's method, stable up to 0.04 s, in a system that steps by 0.1 s."""
    start = {"b": {"rate": 50.0, "u": 1.0}}
    alone = system(
        c_fmu, {"b": "euler+state"}, start=start, simulation=Simulation(1, 0.1, algorithm)
    )
    wild, tame = (
        np.ravel(watched(replace(alone, components=own_step(alone, "b", own)), "b.y"))
        for own in (0.05, 0.01)
    )
    count = np.arange(11)
    # each Euler step takes the factor 1 - 50 h off what is missing
    np.testing.assert_allclose(1 - wild, (1 - 50 * 0.05) ** (2 * count), rtol=1e-12)
    np.testing.assert_allclose(1 - tame, (1 - 50 * 0.01) ** (10 * count), atol=1e-15)
