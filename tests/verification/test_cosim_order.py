"""Order, error, stability and energy of the algorithms on systems with exact solutions.

See support/two_masses.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_systems import Fmus, system, watched
from support.two_masses import EXACT, TIME, errors, orders, two_integrators, two_masses, two_places

from m4e_fmi.cosim import Simulation, System
from m4e_fmi.errors import RunError

STEPS = (0.1, 0.05, 0.025, 0.0125)


def body(fmus: Fmus, model: str, settings: Simulation, damping: float = 0.0) -> System:
    """A unit mass, x(0) = 1 m, on a spring of 1 N/m in another FMU."""
    start = {"a": {"body.m.x": 1.0}, "b": {"damping": damping}}
    parts = {"a": "mass", "b": model}
    return system(fmus, parts, "a.m <-> b.end", start=start, simulation=settings)


@pytest.mark.verifies(
    "order of `gauss_seidel`, two-mass oscillator",
    analytic="exact solution",
    tolerance="order 2 ± 0.15",
)
@pytest.mark.parametrize("partner", ["partner", "moving_partner"])
def test_force_displacement_gauss_seidel_is_second_order(c_fmu: Fmus, partner: str) -> None:
    pair = two_masses(c_fmu, "mass", partner)
    found = errors(pair, EXACT, STEPS, "gauss_seidel")
    # 0.15 is what terms of the next order change at these steps
    np.testing.assert_allclose(orders(found), 2.0, atol=0.15)
    assert found[0] < 6e-3  # not worse than the best of the others, in one pass
    turned = replace(pair, components=pair.components[::-1], connections=("b.end <-> a.m",))
    again = errors(turned, EXACT, STEPS, "gauss_seidel")
    np.testing.assert_allclose(again, found, rtol=1e-9)  # listing order does not matter


def test_without_declared_derivatives_gauss_seidel_is_second_order_and_less_exact(
    c_fmu: Fmus,
) -> None:
    plain = two_masses(c_fmu, "plain_mass", "plain_partner")
    found = errors(plain, EXACT, STEPS, "gauss_seidel")
    np.testing.assert_allclose(orders(found), 2.0, atol=0.15)
    # the figures of docs/coupling.md, to their digits
    assert found[0] == pytest.approx(1.53e-2, abs=5e-5)
    assert found[-1] == pytest.approx(2.43e-4, abs=5e-7)
    better = errors(two_masses(c_fmu, "mass", "partner"), EXACT, STEPS, "gauss_seidel")
    assert better[0] == pytest.approx(5.84e-3, abs=5e-6)
    assert better[-1] == pytest.approx(9.06e-5, abs=5e-8)


@pytest.mark.verifies(
    "error of `jacobi` at H = 0.1 s, two-mass oscillator: 0.413 m",
    independent="other FMI masters that exchange fresh values",
    tolerance="5e-4 m",
)
def test_force_displacement_jacobi_is_first_order(c_fmu: Fmus) -> None:
    found = errors(two_masses(c_fmu, "mass", "partner"), EXACT, STEPS, "jacobi")
    np.testing.assert_allclose(orders(found), 1.0, atol=0.15)
    # the same scheme with fresh feed-through in other masters: 0.413 and 0.0444, to their digits
    assert found[0] == pytest.approx(0.413, abs=5e-4)
    assert found[-1] == pytest.approx(0.0444, abs=5e-5)


def test_displacement_displacement(c_fmu: Fmus) -> None:
    pair, exact = two_places(c_fmu, "partner", "partner")
    (jacobi,) = errors(pair, exact, STEPS[:1], "jacobi")
    assert jacobi == pytest.approx(0.304, abs=5e-4)  # other masters, to their digits
    found = errors(pair, exact, STEPS, "gauss_seidel")
    np.testing.assert_allclose(orders(found), 2.0, atol=0.3)  # third-order part is larger here


def test_a_cycle_of_unpredictable_outputs_is_second_order(c_fmu: Fmus) -> None:
    """One of the two inputs is extrapolated."""
    found = errors(*two_integrators(c_fmu, "integrator", "integrator"), STEPS, "gauss_seidel")
    np.testing.assert_allclose(orders(found), 2.0, atol=0.15)


@pytest.mark.parametrize(("model", "damping"), [("spring", 0.0), ("spring", 0.2), ("line", 0.0)])
def test_body_and_force_are_second_order(c_fmu: Fmus, model: str, damping: float) -> None:
    zeta = damping / 2
    w = np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * TIME)
    exact = {
        "a.body.m.x": decay * (np.cos(w * TIME) + zeta / w * np.sin(w * TIME)),
        "a.body.m.vx": -decay * np.sin(w * TIME) / w,
    }
    coupled = body(c_fmu, model, Simulation(TIME, 0.1), damping)
    found = errors(coupled, exact, STEPS, "gauss_seidel")
    np.testing.assert_allclose(orders(found), 2.0, atol=0.15)


def amplitude(fmus: Fmus, model: str, step: float, periods: int) -> float:
    """Mean amplitude over the last period of a unit oscillator that started with 1."""
    stop = round(2 * np.pi * periods / step) * step
    coupled = body(fmus, model, Simulation(stop, step, "gauss_seidel"))
    course = np.array(watched(coupled, "a.body.m.x", "a.body.m.vx"))
    last = course[np.arange(len(course)) * step > stop - 2 * np.pi]
    return float(np.sqrt(np.mean((last**2).sum(axis=1))))


@pytest.mark.verifies(
    "energy that the coupling of body and force takes, 130 periods",
    analytic="amplitude factor 1 − (ωH)⁴/32, line 1 − 5(ωH)⁴/48",
    tolerance="5e-6",
)
@pytest.mark.parametrize(("model", "rate"), [("spring", 1 / 32), ("line", 5 / 48)])
def test_energy_over_130_periods(c_fmu: Fmus, model: str, rate: float) -> None:
    step, periods = 0.01, 130
    lost = 1 - amplitude(c_fmu, model, step, periods)
    assert 0 < lost < 5e-4
    # the theory's loss per step, rate · H⁴; 5e-6 is the bounded wobble of x² + v², H²/12 · 1/2
    assert lost == pytest.approx(rate * step**4 * 2 * np.pi * periods / step, abs=5e-6)


@pytest.mark.verifies(
    "largest stable step of body and force, ωH = 2.19 and 1.73",
    analytic="roots of the recursion",
    tolerance="0.97 to 1.03",
)
@pytest.mark.parametrize(("model", "limit"), [("spring", 2.19), ("line", 1.73)])
def test_stability_limits(c_fmu: Fmus, model: str, limit: float) -> None:
    # from the eigenvalues of the recursion; 60 periods tell 3 % on either side apart
    assert amplitude(c_fmu, model, round(0.97 * limit, 6), 60) < 1
    with pytest.raises(RunError, match=r"unstable: a\.body\.m\.\w+ .* is "):
        amplitude(c_fmu, model, round(1.03 * limit, 6), 400)
