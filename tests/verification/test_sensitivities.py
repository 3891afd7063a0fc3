"""Exact sensitivities against central differences: in q̈, an eigenvalue, an equilibrium, 10 s."""

from __future__ import annotations

import numpy as np
import pytest
from support.chains import cantilever
from support.differences import difference

from m4e_fmi.analysis import (
    Sensitivities,
    eigenvalue_sensitivity,
    equilibrium,
    linearize,
    modes,
    sensitivity,
    trajectory_sensitivity,
)
from m4e_fmi.errors import InputError
from m4e_fmi.model import (
    Body,
    Joint,
    Model,
    Parameter,
    Point,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

BY = ("m", "L", "k", "c")
CLOSE = 1e-6


def pendulum() -> Model:
    """Two links with every kind of parameter: mass, length, stiffness, damping."""
    link = Body("m", "m*L**2/12")
    return Model(
        name="pendulum",
        gravity=9.81,
        parameters={
            "m": Parameter(1.2, "kg"),
            "L": Parameter(0.9, "m"),
            "k": Parameter(6.0, "N.m/rad"),
            "c": Parameter(0.3, "N.m.s/rad"),
        },
        bodies={"upper": link, "lower": link},
        joints={
            "shoulder": Joint(
                "revolute", "upper", joint_to_child=(0, "-L/2"), initial={"q": 0.8, "u": -0.4}
            ),
            "elbow": Joint("revolute", "lower", "upper", (0, "-L/2"), (0, "-L/2")),
        },
        points={"tip": Point("lower", (0, "-L/2")), "post": Point("ground", (1.5, -0.5))},
        loads={
            "spring": TorsionSpring(("ground", "upper"), "k", 0.2),
            "damper": TorsionDamper(("upper", "lower"), "c"),
            "rope": TensionSpring(("tip", "post"), "2*k", 1.0),
        },
    )


@pytest.mark.verifies(
    "sensitivities of accelerations and reactions",
    independent="central differences of fourth order",
    tolerance="1e-6",
)
@pytest.mark.parametrize("by", BY)
def test_accelerations_and_reactions(by: str) -> None:
    model = pendulum()
    of = ["der(joint.elbow.u)", "joint.shoulder.reaction_x", "point.tip.az", "energy.total"]
    state = {"joint.elbow.q": -0.6, "joint.elbow.u": 1.7}
    found = sensitivity(model, of=of, by=BY, at=state)
    program = model_program(model)

    def values(p: float) -> np.ndarray:
        return linearize(program, at={**state, by: p}, outputs=of).values

    expected = difference(values, model.parameters[by].value)
    exact = np.array([found[name, by] for name in of])
    assert exact == pytest.approx(expected, rel=CLOSE, abs=CLOSE)


def test_by_states_and_inputs() -> None:
    """The same numbers as in A and B."""
    model = pendulum()
    by = ["joint.elbow.q", "joint.elbow.effort"]
    found = sensitivity(model, of=["der(joint.shoulder.u)"], by=by)
    linear = linearize(model, inputs=by[1:])
    assert found.values == pytest.approx(np.array([[linear.A[2, 1], linear.B[2, 0]]]), rel=1e-13)


@pytest.mark.parametrize("by", BY)
def test_equilibrium(by: str) -> None:
    """The equilibrium moves with the parameter, and a reaction with both."""
    model = pendulum()
    of = ["joint.shoulder.q", "joint.elbow.q", "joint.shoulder.reaction_x"]
    point = equilibrium(model)
    found = sensitivity(model, of=of, by=BY, at=point, moving=True)

    def values(p: float) -> np.ndarray:
        moved = equilibrium(model, at={**point.values, by: p})
        return linearize(model, at=moved, outputs=of).values

    expected = difference(values, model.parameters[by].value)
    exact = np.array([found[name, by] for name in of])
    assert exact == pytest.approx(expected, rel=CLOSE, abs=CLOSE)


@pytest.mark.verifies(
    "sensitivities of eigenvalues, also where the equilibrium moves",
    independent="central differences of fourth order",
    tolerance="1e-6",
)
@pytest.mark.parametrize("moving", [False, True])
def test_eigenvalues(moving: bool) -> None:
    """Complex, damped ones; at a point that stays, and at an equilibrium that moves."""
    model = pendulum()
    point = equilibrium(model)
    found = eigenvalue_sensitivity(model, by=BY, at=point, moving=moving)
    assert (found.modes.eigenvalues.imag > 0).all()
    for j, by in enumerate(BY):

        def values(p: float, by: str = by) -> np.ndarray:
            at = {**point.values, by: p}
            place = equilibrium(model, at=at) if moving else at
            return modes(linearize(model, at=place)).eigenvalues

        expected = difference(values, model.parameters[by].value)
        assert found.values[:, j] == pytest.approx(expected, rel=CLOSE, abs=CLOSE)
        lengths = difference(lambda p: np.abs(values(p)), model.parameters[by].value)
        assert found.frequencies[:, j] == pytest.approx(lengths, rel=CLOSE, abs=CLOSE)


def test_frequency_by_stiffness_in_closed_form() -> None:
    """All frequencies of a beam grow with √EI: EI dω/dEI = ω/2."""
    stiffness = 5.0
    beam = cantilever(5, length=2.0, rigidity=stiffness, density=0.8)
    loads = {
        name: TorsionSpring(load.bodies, f"{load.stiffness / stiffness}*EI")  # pyrefly: ignore[missing-attribute]
        for name, load in beam.loads.items()
    }
    model = Model(
        name="beam",
        bodies=beam.bodies,
        joints=beam.joints,
        loads=loads,
        parameters={"EI": Parameter(stiffness, "N.m2")},
        gravity=0.0,
    )
    found = eigenvalue_sensitivity(model, by=["EI"])
    expected = found.modes.frequencies / (2 * stiffness)
    assert found.frequencies[:, 0] == pytest.approx(expected, rel=1e-9)


def test_equal_eigenvalues_have_no_derivative() -> None:
    """Two equal pendulums side by side."""
    model = Model(
        name="twins",
        gravity=9.81,
        parameters={"m": Parameter(1.0, "kg")},
        bodies={"a": Body("m", 0.1), "b": Body(1.0, 0.1)},
        joints={n: Joint("revolute", n, joint_to_child=(0, -0.5)) for n in "ab"},
    )
    assert np.isnan(eigenvalue_sensitivity(model, by=["m"]).values).all()
    different = eigenvalue_sensitivity(model, by=["m"], at={"m": 1.1})
    assert np.isfinite(different.values).all()


@pytest.mark.verifies(
    "sensitivities of ten seconds of motion",
    independent="central differences of fourth order",
    tolerance="1e-6",
)
def test_a_trajectory_of_ten_seconds() -> None:
    """By parameters and by a start value, of states and outputs."""
    model = pendulum()
    by = [*BY, "joint.elbow.u"]
    of = ["joint.elbow.q", "joint.elbow.u", "point.tip.x", "joint.shoulder.reaction_z"]
    found = trajectory_sensitivity(
        model, of=of, by=by, stop_time=10.0, output_interval=0.5, tolerance=1e-11
    )
    assert found.derivatives.shape == (21, 4, 5)
    program = model_program(model)

    def values(p: float, name: str) -> np.ndarray:
        # as exact as doubles allow: differences divide its error by STEP
        run = simulate(
            program,
            start_values={name: p},
            stop_time=10.0,
            output_interval=0.5,
            tolerance=1e-13,
        )
        return np.column_stack([run[n] for n in of])

    assert found.values == pytest.approx(values(model.parameters["m"].value, "m"), abs=1e-8)
    for name in by:
        start = model.parameters[name].value if name in BY else 0.0
        if start:
            expected = difference(lambda p: values(p, name), start)  # noqa: B023
        else:
            expected = difference(lambda p: values(p - 1.0, name), 1.0)  # noqa: B023
        scale = np.abs(expected).max(axis=0)
        exact = np.stack([found[n, name] for n in of], axis=1)
        assert np.abs((exact - expected) / scale).max() < CLOSE


def test_once_recorded_everywhere() -> None:
    model = pendulum()
    everywhere = Sensitivities(model, of=["energy.kinetic"], by=["L"])
    for q in (0.1, 0.9):
        at = {"joint.elbow.q": q}
        once = sensitivity(model, of=["energy.kinetic"], by=["L"], at=at)
        assert np.array_equal(everywhere.at(at).values, once.values)


def test_refusals() -> None:
    model = pendulum()
    with pytest.raises(InputError, match="no input, parameter or state n"):
        sensitivity(model, of=[], by=["n"])
    with pytest.raises(InputError, match=r"no input or parameter joint\.elbow\.q"):
        sensitivity(model, of=[], by=["joint.elbow.q"], moving=True)
    with pytest.raises(InputError, match=r"of outputs and states, got der\(joint\.elbow\.u\)"):
        trajectory_sensitivity(model, of=["der(joint.elbow.u)"], by=["m"], stop_time=1.0)
