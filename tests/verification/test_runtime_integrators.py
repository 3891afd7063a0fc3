"""Integrators of the runtime: SciPy's step control, orders of convergence, stiff problems."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.runtime_programs import chain, exact, robertson, van_der_pol

from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.program.functions import sin
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime.engine import DONE, Control, Engine

CONTROLLED = {"rk45": 4, "dop853": 7, "rodas": 3}  # order of dense output
ORDERS = {"rk45": 5, "dop853": 8, "rodas": 4, "rk4": 4}  # of steps
STEPS = {"rk45": 0.2, "dop853": 0.4, "rodas": 0.2, "rk4": 0.2}  # s; errors well above rounding


def _scipy(program: Program, method: str, end: float, rtol: float, atol: float, x0=None):
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c = form.constants(p)
    start = [v.start for v in program.states] if x0 is None else x0
    return solve_ivp(
        lambda t, x: form.rates(t, list(x), [], p, c), (0, end), start, method, rtol=rtol, atol=atol
    )


@pytest.mark.verifies(
    "steps and evaluations of `rk45` and `dop853`",
    independent="SciPy's RK45 and DOP853",
    tolerance="identical",
)
@pytest.mark.parametrize("method", ["rk45", "dop853"])
@pytest.mark.parametrize(
    ("program", "end", "tolerance"),
    [
        (chain(1), 30.0, 1e-8),
        (chain(3), 2.0, 1e-8),
        (chain(10), 2.0, 1e-6),
        (exact(), 10.0, 1e-9),
        (van_der_pol(5.0)[0], 20.0, 1e-5),
    ],
    ids=["pendulum", "three links", "ten links", "exact", "van der Pol"],
)
def test_steps_are_those_of_scipy(
    method: str, program: Program, end: float, tolerance: float
) -> None:
    reference = _scipy(program, method.upper(), end, tolerance, tolerance)
    run = Engine(program).simulate([0.0, end], control=Control(method, tolerance, tolerance))
    assert run.evaluations == reference.nfev
    assert run.accepted == len(reference.t) - 1
    # the same steps up to rounding, which the step control magnifies: far below the tolerance
    np.testing.assert_allclose(run.states[-1], reference.y[:, -1], atol=0.01 * tolerance)


def test_the_published_count_of_evaluations_of_one_pendulum() -> None:
    """A rod of 2 m let go horizontally, angle from the vertical: 3932 in 30 s at 1e-8 (RK45)."""
    recorder = Recorder("rod", "pendulum of the benchmark")
    theta = recorder.state(Variable("theta", "rad", "from the vertical", start=np.pi / 2))
    omega = recorder.state(Variable("omega", "rad/s", "angular velocity"))
    recorder.rate("theta", omega)
    recorder.rate("omega", -(1.5 * 9.81 / 2.0) * sin(theta))
    times = np.linspace(0.0, 30.0, 3001)  # output times do not shorten steps
    assert Engine(recorder.program()).simulate(times, control=Control("rk45")).evaluations == 3932


def _errors(method: str, step: float, times: np.ndarray) -> float:
    """Largest error at `times` with steps of `step` (tolerances so loose that they never bind)."""
    control = Control(method, rtol=0.0, atol=1e6, max_step=step)
    run = Engine(exact()).simulate(times, control=control)
    assert run.rejected == 0
    solution = np.column_stack([np.exp(np.sin(times)), 1 / (1 + times)])
    return float(np.abs(run.states - solution).max())


@pytest.mark.verifies("order of all methods", analytic="exact solution", tolerance="order ± 0.4")
@pytest.mark.parametrize("method", ORDERS)
def test_order_of_the_steps(method: str) -> None:
    end = np.array([0.0, 4.0])
    coarse, fine = (_errors(method, h, end) for h in (STEPS[method], STEPS[method] / 2))
    # steps are not quite halved everywhere (the first ones grow from 1e-4 s): 0.4 for that
    assert np.log2(coarse / fine) > ORDERS[method] - 0.4


@pytest.mark.parametrize("method", CONTROLLED)
def test_order_of_the_dense_output(method: str) -> None:
    times = np.linspace(0.0, 4.0, 1001)
    coarse, fine = (_errors(method, h, times) for h in (0.25, 0.125))
    # an interpolant of order p is off by h^(p + 1) within a step: p is what must hold at least
    assert np.log2(coarse / fine) > CONTROLLED[method]


@pytest.mark.verifies(
    "van der Pol's oscillator, μ = 1000",
    published="test set for initial value problems, vdpol",
    tolerance="1e-6",
)
@pytest.mark.parametrize("exact_jacobian", [True, False])
def test_van_der_pol_with_mu_1000(exact_jacobian: bool) -> None:
    program, entries = van_der_pol(1000.0)
    engine = Engine(program, jacobian=entries if exact_jacobian else ())
    run = engine.simulate([0.0, 2000.0], control=Control("rodas", 1e-7, 1e-13))
    reference = _scipy(program, "Radau", 2000.0, 1e-10, 1e-14).y[:, -1]
    assert run.status == DONE
    # local errors of 1e-7 over some 2,000 steps on contracting branches; the jumps dominate
    np.testing.assert_allclose(run.states[-1], reference, rtol=1e-6)
    assert run.accepted < 5000  # an explicit method takes millions
    # reference of the test set for initial value problems (vdpol, t = 2 there, scaled by mu)
    published = [1.706167732170469, -0.8928097010248125e-3]
    np.testing.assert_allclose(run.states[-1], published, rtol=1e-6)


@pytest.mark.verifies(
    "Robertson's reaction over eleven decades",
    published="test set for initial value problems, rober",
    tolerance="1e-5",
)
def test_robertson_over_eleven_decades() -> None:
    program, entries = robertson()
    control = Control("rodas", 1e-7, 1e-14)
    run = Engine(program, jacobian=entries).simulate([0.0, 1e11], control=control)
    assert run.status == DONE
    # published reference of the test set at t = 1e11 (problem rober)
    expected = [0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050]
    np.testing.assert_allclose(run.states[-1], expected, rtol=1e-5)
    assert run.accepted < 5000


@pytest.mark.parametrize("method", CONTROLLED)
def test_energy_of_a_pendulum_in_the_error_of_the_tolerance(method: str) -> None:
    times = np.linspace(0.0, 30.0, 301)
    run = Engine(chain(1)).simulate(times, control=Control(method, 1e-8, 1e-8))
    theta, omega = run.states.T
    inertia, weight = 40 / 3, 98.1  # about the joint; moment of weight about it is −98.1 cos θ … up
    energy = 0.5 * inertia * omega**2 - weight * np.sin(theta)
    # 300 to 3,000 steps of local error 1e-8 (1 + |x|), |x| up to 4: below 1e-4 if they add up
    assert np.abs(energy - energy[0]).max() < 1e-4 * weight
