"""Linear analysis against textbooks and matrices derived by hand."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from support.chains import cantilever, hanging_chain, hanging_chain_matrices

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.model import Body, Joint, Model, Parameter, Point, TensionSpring
from m4e_fmi.multibody import Equations


def flap() -> Model:
    """Ginsberg, "Advanced Engineering Dynamics", example 7.13, with the data of the paper's 4.1.

    An inverted pendulum of length L (θ = 0 upright); two springs from its point at the height a to
    the ground at ±b, unstretched: l₀² = a² + b².
    """
    values = {"m": 1.0, "L": 2.0, "a": 0.5, "b": 1.0, "k": 100.0, "g": 9.81}
    units = {"m": "kg", "k": "N/m", "g": "m/s2"}
    natural = "sqrt(a**2 + b**2)"
    return Model(
        name="flap",
        parameters={name: Parameter(v, units.get(name, "m")) for name, v in values.items()},
        gravity="g",
        bodies={"flap": Body("m", "m*L**2/12")},
        joints={"hinge": Joint("revolute", "flap", joint_to_child=(0, "L/2"))},
        points={
            "height": Point("flap", (0, "a - L/2")),
            "left": Point("ground", ("-b", 0)),
            "right": Point("ground", ("b", 0)),
        },
        loads={
            "left": TensionSpring(("left", "height"), "k", natural),
            "right": TensionSpring(("right", "height"), "k", natural),
        },
    )


@pytest.mark.verifies(
    "stiffness of a flap on two springs, symbolically",
    published="Ginsberg, example 7.13; Sabet and Diaz-Flores Caminero, Eq. (7)",
    tolerance="identical",
)
def test_ginsberg_7_13() -> None:
    """The paper's Eq. (7), symbolically: K = 2 k l₀ a² b²/√(a² + b²)³ − m g L/2, and its M."""
    e = Equations(flap())
    residual = e.mass_matrix * e.u_dot - e.forcing
    rest = dict.fromkeys([*e.q, *e.u, *e.u_dot], 0)
    m, L, a, b, k, g = (sp.Symbol(name, real=True) for name in ("m", "L", "a", "b", "k", "g"))
    natural = sp.sqrt(a**2 + b**2)
    expected = 2 * k * natural * a**2 * b**2 / sp.sqrt((a**2 + b**2) ** 3) - m * g * L / 2
    assert sp.simplify(residual.jacobian(e.q)[0, 0].subs(rest) - expected) == 0
    assert sp.simplify(e.mass_matrix[0, 0] - m * L**2 / 3) == 0
    assert residual.jacobian(e.u)[0, 0].subs(rest) == 0


def test_ginsberg_7_13_in_numbers() -> None:
    """The released example of the paper prints K = 30.19 N·m/rad."""
    linear = linearize(flap())
    assert linear.mechanical is not None
    # rounding of some twenty operations
    assert linear.mechanical.K[0, 0] == pytest.approx(2 * 100 * 0.25 / 1.25 - 9.81, rel=1e-14)
    frequency = np.sqrt((40 - 9.81) / (4 / 3))
    assert modes(linear).frequencies == pytest.approx([frequency], rel=1e-13)


@pytest.mark.verifies(
    "frequencies of 20 hanging links",
    independent="M and K written down from the energies, SciPy",
    tolerance="1e-9",
)
def test_frequencies_of_a_hanging_chain() -> None:
    """20 links, against the symmetric eigenvalue problem of M and K from their energies."""
    model = hanging_chain(20)
    M, K = hanging_chain_matrices(20)
    linear = linearize(model)
    assert linear.mechanical is not None
    assert pytest.approx(M, rel=1e-12) == linear.mechanical.M
    assert pytest.approx(K, rel=1e-10, abs=1e-9) == linear.mechanical.K
    expected = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True))
    found = modes(linear)
    assert found.frequencies == pytest.approx(expected, rel=1e-9)
    assert found.damping_ratios == pytest.approx(0.0, abs=1e-9)
    assert found.stable
    # the shapes solve K φ = ω² M φ
    for k in range(20):
        shape = found.shapes[:, k]
        residual = K @ shape - expected[k] ** 2 * (M @ shape)
        assert np.linalg.norm(residual) < 1e-8 * np.linalg.norm(K @ shape)


@pytest.mark.verifies(
    "order in which a chain of links becomes a cantilever, modes 1 to 3",
    analytic="Euler and Bernoulli",
    tolerance="order 2 ± 0.1",
)
@pytest.mark.parametrize("mode", [0, 1, 2])
def test_a_chain_with_torsion_springs_is_a_beam(mode: int) -> None:
    """Frequencies converge to Euler and Bernoulli's (βL)² √(EI/ρA L⁴) at second order.

    βL solves cos βL cosh βL = −1: 1.875104, 4.694091, 7.854757 (Blevins, "Formulas for Natural
    Frequency and Mode Shape", table 8-1).
    """
    length, rigidity, density = 2.0, 5.0, 0.8
    wave = (1.87510406871, 4.69409113297, 7.85475743824)[mode]
    exact = wave**2 * np.sqrt(rigidity / density) / length**2
    errors = []
    for segments in (10, 20, 40):
        model = cantilever(segments, length=length, rigidity=rigidity, density=density)
        found = modes(linearize(model)).frequencies[mode]
        errors.append(abs(found / exact - 1))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    # the next term is of fourth order
    assert rates == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 3e-3 * (mode + 1)


@pytest.mark.verifies(
    "damping ratios under proportional damping",
    analytic='Rayleigh, "The Theory of Sound", §97',
    tolerance="1e-8",
)
def test_stiffness_proportional_damping() -> None:
    """C = β K gives damping ratios ζ = β ω/2 (Rayleigh, "The Theory of Sound", §97)."""
    beta = 2e-3
    data = {"length": 2.0, "rigidity": 5.0, "density": 0.8}
    free = modes(linearize(cantilever(8, **data))).frequencies[:4]
    linear = linearize(cantilever(8, **data, damping=beta))
    assert linear.mechanical is not None
    np.testing.assert_allclose(
        linear.mechanical.C, beta * linear.mechanical.K, rtol=1e-9, atol=1e-9
    )
    damped = modes(linear)
    assert damped.frequencies[:4] == pytest.approx(free, rel=1e-9)
    assert damped.damping_ratios[:4] == pytest.approx(beta * free / 2, rel=1e-8)


@pytest.mark.verifies(
    "equilibrium of a chain with springs under a tip load",
    analytic="deflection of a beam",
    tolerance="2e-3",
)
def test_a_heavy_cantilever_sags() -> None:
    """A chain of hinges and springs under a tip load: the elastica's first-order deflection."""
    length, rigidity, load = 2.0, 5.0, 1e-4
    model = cantilever(20, length=length, rigidity=rigidity, density=0.8)
    point = equilibrium(model, at={"body.s19.force_z": -load, "body.s19.moment_y": load * 0.05})
    tip = sum(-np.sin(point[f"joint.h{k}.q"]) * length / 20 for k in range(20))
    # force and moment at the tip, F L³/3EI, and the error of 20 segments, second order
    assert tip == pytest.approx(-load * length**3 / (3 * rigidity), rel=2e-3)


@pytest.mark.verifies(
    "frequency about a steady rotation", analytic="ω = Ω √(r l m/J)", tolerance="1e-5"
)
def test_equations_of_motion_about_a_steady_rotation() -> None:
    """A pendulum of length l on an arm of length r that spins at Ω, no gravity: ω = Ω √(r l m/J).

    About the radial direction the centrifugal field restores it: J δ̈ + m r l Ω² δ = 0, where J is
    about the pivot.
    """
    r, arm, m, inertia, spin = 1.2, 0.4, 2.0, 0.3, 3.0
    model = Model(
        name="rotor",
        gravity=0.0,
        bodies={"hub": Body(1e6, 1e6), "blade": Body(m, inertia)},
        joints={
            "shaft": Joint("revolute", "hub"),
            "hinge": Joint("revolute", "blade", "hub", (r, 0), (arm, 0)),
        },
    )
    linear = linearize(model, at={"joint.shaft.u": spin, "joint.hinge.u": spin})
    # absolute angles: q̇ is not zero, but the equations stand still; the heavy hub keeps its speed
    about_pivot = inertia + m * arm**2
    expected = spin * np.sqrt(m * r * arm / about_pivot)
    oscillating = modes(linear)
    assert oscillating.frequencies[-1] == pytest.approx(expected, rel=1e-5)  # hub: 1e6 against 1
