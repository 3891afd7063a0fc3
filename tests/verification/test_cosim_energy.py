"""The energy balance over a connection, against mechanics."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system

from m4e_fmi.cosim import BondEnergy, Simulation, run


def balance(
    fmus: Fmus, model: str, step: float, algorithm: str, **start: float
) -> tuple[BondEnergy, float]:
    """The balance of a unit mass, x = 0.5, v = 1, driven by `model` for 3 s; its kinetic energy."""
    begin = {"a": {"body.m.x": 0.5, "body.m.vx": 1.0}, "b": start}
    settings, parts = Simulation(3.0, step, algorithm), {"a": "mass", "b": model}
    pair = system(fmus, parts, "a.m <-> b.end", start=begin, simulation=settings)
    rows, outcome = observed(pair, "a.body.m.vx", certify=False)
    (bond,) = outcome.energy
    return bond, rows[-1][1] ** 2 / 2


@pytest.mark.verifies(
    "energy that a body receives over a connection",
    analytic="its kinetic energy",
    tolerance="1e-12 J",
)
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel"])
def test_received_is_exactly_what_the_body_gained(c_fmu: Fmus, algorithm: str) -> None:
    bond, kinetic = balance(c_fmu, "spring", 0.1, algorithm, stiffness=2.0)
    # a free mass under held forces: work = change of kinetic energy, to rounding
    assert bond.received == pytest.approx(kinetic - 0.5, abs=1e-12)


def test_given_is_the_loss_of_the_springs_potential(c_fmu: Fmus) -> None:
    w = np.sqrt(2.0)
    x = 0.5 * np.cos(3 * w) + np.sin(3 * w) / w
    exact = 0.25 - x**2
    residuals = []
    for step in (0.1, 0.05, 0.025):
        bond, _ = balance(c_fmu, "spring", step, "gauss_seidel", stiffness=2.0)
        assert bond.connection == "a.m <-> b.end"
        # trapezoid of F·v (twice the frequency) and second-order values: both a fraction of H²
        assert bond.given == pytest.approx(exact, abs=step**2)
        residuals.append(abs(bond.residual))
        assert bond.relative == bond.residual / bond.exchanged
    assert np.log2(residuals[0] / residuals[2]) / 2 > 1.8


def test_jacobi_invents_energy(c_fmu: Fmus) -> None:
    jacobi, _ = balance(c_fmu, "spring", 0.1, "jacobi", stiffness=2.0)
    sweep, _ = balance(c_fmu, "spring", 0.1, "gauss_seidel", stiffness=2.0)
    assert jacobi.residual > 20 * abs(sweep.residual)


def test_without_a_coordinate_the_way_is_that_of_the_mean_velocity(c_fmu: Fmus) -> None:
    d, step = 0.7, 0.05
    bond, kinetic = balance(c_fmu, "damper", step, "gauss_seidel", damping=d)
    exact = -(1 - np.exp(-2 * d * 3.0)) / 2
    assert bond.given == pytest.approx(exact, abs=step**2)
    # the velocity is linear in time under a held force: its mean is exact
    assert bond.received == pytest.approx(kinetic - 0.5, abs=1e-12)


@pytest.mark.parametrize("options", ["+state", "+state+inputs"])
def test_nothing_is_lost_where_inputs_follow_a_course(c_fmu: Fmus, options: str) -> None:
    """A damper: force and velocity fall together, mean force · displacement lacks (dH)²/12."""
    parts = {"a": f"mass{options}", "b": f"damper{options}"}
    start = {"a": {"body.m.vx": 1.0}, "b": {"damping": 0.7}}
    shares = []
    for step in (0.2, 0.1):
        settings = Simulation(3.0, step, "corrector")
        pair = system(c_fmu, parts, "a.m <-> b.end", start=start, simulation=settings)
        (bond,) = run(pair, certify=False).energy
        exact = -(1 - np.exp(-2 * 0.7 * 3.0)) / 2
        assert bond.given == pytest.approx(exact, abs=step**4 / 10)
        assert bond.received == pytest.approx(exact, abs=step**4 / 10)
        shares.append(abs(bond.relative))
    assert shares[0] < 0.7**2 * 0.2**2 / 12 / 10
    assert shares[0] > 6 * shares[1]  # of third order at least; mean force · displacement: 4
