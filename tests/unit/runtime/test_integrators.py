"""The integrators in plain Python: order, error control, exact ends, steps kept, failures."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.runtime_programs import chain

from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import DormandPrince, IntegrationError, RungeKutta
from m4e_fmi.runtime.engine import Control, Engine

Rates = Callable[[float, Sequence[float]], list[float]]
EXAMPLES = Path(__file__).parents[3] / "examples"


def rotation(t: float, x: Sequence[float]) -> list[float]:
    """A linear system with time in it: x₀ = cos(t²/2), x₁ = sin(t²/2)."""
    return [-t * x[1], t * x[0]]


def error(x: Sequence[float], t: float) -> float:
    return abs(complex(*x) - complex(math.cos(t * t / 2), math.sin(t * t / 2)))


def of(program: Program) -> tuple[Rates, list[float]]:
    """Rates and start of a program."""
    form = load_python(program)
    p, u, x = ([v.start for v in g] for g in (program.parameters, program.inputs, program.states))
    c = form.constants(p)
    return lambda t, x: form.rates(t, x, u, p, c), x


def pendulum() -> tuple[Rates, list[float]]:
    """The double pendulum of the paper's section 5.1."""
    return of(model_program(EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml"))


class TestOrder:
    def test_global_error_is_of_order_five(self) -> None:
        errors = []
        for steps in (20, 40, 80):
            integrator, x = DormandPrince(rotation, tolerance=1e6), [1.0, 0.0]
            for k in range(steps):  # one accepted step per call
                integrator.step = math.inf
                x = integrator.advance(2.0 * k / steps, x, 2.0 * (k + 1) / steps)
            assert (integrator.accepted, integrator.rejected) == (steps, 0)
            errors.append(error(x, 2.0))
        orders = [math.log2(a / b) for a, b in pairwise(errors)]
        # the next term of the error is one power smaller: below 0.2 in the order at these steps
        assert orders == pytest.approx([5.0, 5.0], abs=0.2)
        assert errors[-1] > 1e-12  # not yet rounding

    def test_fixed_steps_are_of_order_four(self) -> None:
        errors = [
            error(RungeKutta(rotation, step=h, tolerance=1.0).advance(0.0, [1.0, 0.0], 2.0), 2.0)
            for h in (0.1, 0.05, 0.025)
        ]
        for coarse, fine in pairwise(errors):
            # the next term of the error is a step smaller: 0.1 s on a time scale of 1 s
            assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.4)

    @pytest.mark.parametrize("step", [0.1, 0.03, math.inf])
    def test_fixed_steps_are_those_of_the_library(self, step: float) -> None:
        program, times, calls = chain(2), [0.0, 0.1, 0.2], []
        rates, x = of(program)

        def counted(t: float, x: Sequence[float]) -> list[float]:
            calls.append(t)
            return rates(t, x)

        method = RungeKutta(counted, step=step, tolerance=1.0)
        for t, t_end in pairwise(times):
            x = method.advance(t, x, t_end)
        control = Control("rk4", max_step=step)
        run = Engine(program).simulate(times, states=[0.0] * 4, control=control)
        assert len(calls) == run.evaluations
        # sines of another library, and sums in another order, in some ten steps
        np.testing.assert_allclose(x, run.states[-1], rtol=1e-13)

    @pytest.mark.parametrize("tolerance", [1e-5, 1e-9])
    def test_like_scipy_on_the_double_pendulum(self, tolerance: float) -> None:
        """The same pair with the same norm of the error, but SciPy's scale is |x| + 1, too."""
        (rates, start), t_end = pendulum(), 3.0
        reference = solve_ivp(rates, (0, t_end), start, method="DOP853", rtol=1e-13, atol=1e-13)
        scipy = solve_ivp(rates, (0, t_end), start, method="RK45", rtol=tolerance, atol=tolerance)
        integrator = DormandPrince(rates, tolerance=tolerance)
        x = integrator.advance(0.0, start, t_end)
        ours = np.abs(np.array(x) - reference.y[:, -1]).max()
        theirs = np.abs(scipy.y[:, -1] - reference.y[:, -1]).max()
        # the same local errors; the two choose slightly different steps
        assert ours < 3 * theirs
        assert integrator.evaluations == pytest.approx(scipy.nfev, rel=0.1)

    def test_error_is_in_proportion_to_the_tolerance(self) -> None:
        errors = [
            error(DormandPrince(rotation, tolerance=one).advance(0.0, [1.0, 0.0], 6.0), 6.0)
            for one in (1e-6, 1e-8, 1e-10)
        ]
        for coarse, fine in pairwise(errors):
            # per step ∝ h⁵ = tolerance, steps ∝ 1/h: global ∝ tolerance^(4/5) to tolerance
            assert 100**0.7 < coarse / fine < 100**1.1


class TestEnds:
    @pytest.mark.parametrize("t_end", [1.0, 1e-9, 1e6 / 3])
    def test_the_end_is_met_exactly_and_never_passed(self, t_end: float) -> None:
        times: list[float] = []

        def rates(t: float, x: Sequence[float]) -> list[float]:
            times.append(t)
            return [math.cos(t / t_end) / t_end + 0.0 * x[0]]

        x = DormandPrince(rates, tolerance=1e-10).advance(0.0, [0.0], t_end)
        assert max(times) == t_end
        assert x[0] == pytest.approx(math.sin(1.0), abs=1e-9)

    @pytest.mark.parametrize(("excess", "steps"), [(0, 1), (1e-13, 1), (3e-12, 1), (1e-9, 2)])
    def test_no_sliver_is_left_at_the_end(self, excess: float, steps: int) -> None:
        """A step that ends just short of the end, by less than time resolves, is the last one.

        Nor is an interval below that resolution a failure.
        """
        integrator = DormandPrince(lambda *_: [1.0], step=1e-2)
        t_end = 1000.0 + 1e-2 + excess
        x = integrator.advance(1000.0, [0.0], t_end)
        assert x[0] == pytest.approx(t_end - 1000.0, rel=1e-13)
        assert integrator.accepted == steps
        later = math.nextafter(t_end, math.inf)
        assert integrator.advance(t_end, [1.0], later) == [1.0 + (later - t_end)]


class TestStepsFromCallToCall:
    def test_the_step_is_kept(self) -> None:
        """Many calls cost one evaluation each more than one call, and no small first steps."""
        whole, pieces = (DormandPrince(rotation, tolerance=1e-8) for _ in range(2))
        whole.advance(0.0, [1.0, 0.0], 5.0)
        x, calls = [1.0, 0.0], 20
        for k in range(calls):
            x = pieces.advance(5.0 * k / calls, x, 5.0 * (k + 1) / calls)
        assert pieces.accepted <= whole.accepted + calls
        assert pieces.step == pytest.approx(whole.step, rel=0.5)
        assert error(x, 5.0) < 1e-6
        before = pieces.step
        pieces.advance(5.0, x, 5.0 + 1e-6)  # a step cut short does not shrink the next
        assert pieces.step >= before


class TestFailures:
    @pytest.mark.parametrize(
        ("rates", "when", "cause"),
        [
            (lambda _, x: [x[0] * x[0]], 1.0, ""),  # x = 1 / (1 − t)
            (lambda _, x: [x[0] ** 2], 1.0, ""),  # Python's power raises OverflowError
            (lambda _, x: [-1 / x[0]], 0.5, ""),  # x = √(1 − 2t)
            (lambda t, _: [math.sqrt(1 - t)], 1.0, "math domain error"),
            (lambda t, _: [math.nan if t > 1 else 1.0], 1.0, "a rate is not finite"),
            (lambda t, _: [math.inf if t > 1 else 1.0], 1.0, "a rate is not finite"),
        ],
    )
    def test_singularities_are_told_with_time_and_cause(
        self, rates: Rates, when: float, cause: str
    ) -> None:
        with pytest.raises(IntegrationError, match=r"step size .* at t = .* too small") as caught:
            DormandPrince(rates, tolerance=1e-8).advance(0.0, [1.0], 3.0)
        t = float(str(caught.value).split("t = ")[1].split(" s")[0])
        # nine digits are printed; the solution near the singularity is off by its tolerance
        assert t == pytest.approx(when, abs=1e-6)
        assert cause in str(caught.value)

    def test_no_rate_at_the_start(self) -> None:
        with pytest.raises(IntegrationError, match=r"no rates at t = 3 s: .*division by zero"):
            DormandPrince(lambda _, x: [1 / x[0]]).advance(3.0, [0.0], 4.0)
        for tolerance in (0.0, -1e-8, math.nan):
            with pytest.raises(ValueError, match="tolerance must be positive"):
                DormandPrince(rotation, tolerance=tolerance)

    def test_a_trial_step_too_far_is_tried_again_shorter(self) -> None:
        """√x is met at x < 0 only by trial steps that are too long."""
        integrator = DormandPrince(lambda _, x: [-math.sqrt(x[0])], step=10.0)
        x = integrator.advance(0.0, [1.0], 1.9)
        assert x[0] == pytest.approx((1 - 1.9 / 2) ** 2, abs=1e-6)
        assert integrator.rejected > 0
