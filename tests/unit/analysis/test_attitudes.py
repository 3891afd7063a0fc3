"""Free attitudes in equilibria, linear equations and modes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_fmi.analysis import (
    eigenvalue_sensitivity,
    equilibrium,
    linearize,
    modes,
    sensitivity,
)
from m4e_fmi.analysis.linearization import Linearizer
from m4e_fmi.errors import InputError
from m4e_fmi.model import Body, BodyForce, Bushing, Joint, Model, Parameter, Point, TorsionSpring

MASS, ARM, GRAVITY = 2.0, 1.5, 9.81
MOMENTS = (0.3, 0.4, 0.2)


def pendulum(**initial: float) -> Model:
    """A body that is not round on a ball joint, at rest below it where q = 0."""
    hook = Joint("spherical", "bob", joint_to_child=(0, 0, -ARM), initial=dict(initial))
    return Model("pendulum", {"bob": Body(MASS, MOMENTS)}, {"hook": hook}, dimensions=3,
                 gravity=GRAVITY)  # fmt: skip


def test_modes_of_a_pendulum_in_space() -> None:
    linear = linearize(pendulum())
    names = [v.name for v in linear.states]
    assert names[:3] == [f"joint.hook.rotation_{axis}" for axis in "xyz"]
    assert names[3:] == ["joint.hook.omega_x", "joint.hook.omega", "joint.hook.omega_z"]
    found = sorted(abs(value) for value in modes(linear).eigenvalues)
    exact = [math.sqrt(MASS * GRAVITY * ARM / (m + MASS * ARM**2)) for m in MOMENTS[:2]]
    np.testing.assert_allclose(found, [0, 0, *sorted(exact)], atol=1e-12)
    mechanical = linear.mechanical
    assert mechanical is not None
    np.testing.assert_allclose(
        np.diag(mechanical.K), [MASS * GRAVITY * ARM, MASS * GRAVITY * ARM, 0], atol=1e-12
    )


def test_a_spinning_top_is_linear_about_its_spin() -> None:
    """The fast and the slow precession of an upright top: C n Ω − A Ω² = m g l."""
    spin, across = 60.0, MOMENTS[0] + MASS * ARM**2
    top = Model("top", {"top": Body(MASS, (0.3, 0.3, 0.5))}, {
        "tip": Joint("spherical", "top", joint_to_child=(0, 0, ARM), initial={"omega_z": spin})
    }, dimensions=3, gravity=GRAVITY)  # fmt: skip
    values = modes(linearize(top)).eigenvalues
    root = math.sqrt((0.5 * spin) ** 2 - 4 * across * MASS * GRAVITY * ARM)
    exact = [(0.5 * spin + side * root) / (2 * across) for side in (1, -1)]
    found = sorted(value.imag for value in values if value.imag > 1e-9)
    np.testing.assert_allclose(found, sorted(exact), rtol=1e-9)
    assert max(value.real for value in values) < 1e-9


def held() -> Model:
    """A body that floats, held by springs at two points and pushed; parameters k and pull."""
    return Model(
        "held",
        {"hull": Body(2.0, (0.3, 0.5, 0.4, 0.02, -0.03, 0.01)), "ball": Body(1.0, (0.2, 0.2, 0.3))},
        {
            "free": Joint("floating", "hull", initial={"phi": 0.2, "psi": -0.4, "omega_z": 0.3}),
            "hook": Joint("spherical", "ball", "hull", (0.1, 0, -0.2), (0, 0.1, -0.6)),
        },
        {
            "bow": Point("hull", (0.6, 0.1, 0.1)), "stern": Point("hull", (-0.5, 0, 0.2)),
            "ahead": Point("ground", (1.5, 0.3, 1.0)), "behind": Point("ground", (-1.2, 0, 1.2)),
        },
        {
            "first": Bushing(("bow", "ahead"), "k", 4.0),
            "second": Bushing(("stern", "behind"), 60.0),
            "coil": TorsionSpring(("hull", "ball"), 0.7),
            "wind": BodyForce("hull", (0, "pull", 0), (0.2, 0, "0.3*pull")),
        },
        {"k": Parameter(50.0, "N/m"), "pull": Parameter(3.0, "N")},
        dimensions=3,
        gravity=GRAVITY,
    )  # fmt: skip


@pytest.mark.verifies(
    "derivatives of linear equations with free attitudes by parameters and states",
    independent="central differences", tolerance="1e-6",
)  # fmt: skip
@pytest.mark.parametrize(
    "name", ["k", "pull", "body.hull.e1", "body.hull.e3", "body.hull.omega_z", "joint.hook.e2"]
)
def test_the_linear_equations_change_as_differences_do(name: str) -> None:
    linearizer, step = Linearizer(held()), 1e-5
    start = {v.name: v.start for v in (*linearizer.program.states, *linearizer.program.parameters)}
    start |= {"joint.hook.e0": 0.9, "joint.hook.e1": 0.3, "joint.hook.omega": 0.7}
    point = linearizer.at(start).point
    found = linearizer.change(point, {name: 1.0})
    ahead, behind = (linearizer.at({**start, name: start[name] + h}).A for h in (step, -step))
    difference = (ahead - behind) / (2 * step)
    assert np.abs(difference).max() > 0.1
    np.testing.assert_allclose(found, difference, atol=1e-6 * np.abs(difference).max())


@pytest.mark.verifies(
    "equilibria and eigenvalues with free attitudes by parameters",
    independent="central differences of equilibria", tolerance="1e-5",
)  # fmt: skip
def test_a_moving_equilibrium() -> None:
    model, step = held(), 1e-4
    rest = equilibrium(model)
    of, by = ["body.hull.e1", "body.ball.z", "body.hull.psi"], ["k", "pull"]
    exact = sensitivity(model, of=of, by=by, at=rest, moving=True)
    eigen = eigenvalue_sensitivity(model, by=by, at=rest, moving=True)
    with pytest.raises(InputError, match=r"body\.hull\.e0 to e3 are all 0"):
        linearize(model, at=dict.fromkeys((f"body.hull.e{k}" for k in range(4)), 0.0))
    for j, name in enumerate(by):
        value = model.parameters[name].value
        assert isinstance(value, float)
        points = [equilibrium(model, at={**rest.values, name: value + h}) for h in (step, -step)]
        ends = [modes(linearize(model, at=point)).eigenvalues for point in points]
        difference = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(
            eigen.values[:, j], difference, atol=1e-5 * np.abs(difference).max()
        )
        results = [linearize(model, at=point, outputs=of).values for point in points]
        slope = (results[0] - results[1]) / (2 * step)
        np.testing.assert_allclose(exact.values[:, j], slope, atol=1e-5 * np.abs(slope).max())
