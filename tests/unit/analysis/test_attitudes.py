"""Free attitudes in equilibria, linear equations and modes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.errors import RunError
from m4e_fmi.model import Body, Bushing, Joint, Model, Point, TorsionSpring
from m4e_fmi.simulate import simulate

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


@pytest.mark.parametrize("nearest", [False, True])
def test_equilibrium_of_a_tilted_body(nearest: bool) -> None:
    """A spring pulls a body on a ball joint aside: moments about the joint vanish."""
    model = pendulum(phi=0.4, theta=-0.3, psi=0.2)
    model = Model("pulled", model.bodies, model.joints, {
        "eye": Point("bob", (0.1, 0, 0)), "post": Point("ground", (1.0, 0.7, -1.0))
    }, {"rope": Bushing(("eye", "post"), 8.0)}, dimensions=3, gravity=GRAVITY)  # fmt: skip
    point = equilibrium(model, nearest=nearest)
    values = point.values
    e = np.array([values[f"joint.hook.e{k}"] for k in range(4)])
    assert abs(np.linalg.norm(e) - 1) < 1e-12
    found = simulate(model, stop_time=5.0, start_values={
        name: value for name, value in values.items() if name.startswith("joint")
    })  # fmt: skip
    for name in ("e0", "e1", "e2", "e3"):
        assert np.ptp(found[f"joint.hook.{name}"]) < 1e-7
    linear = linearize(model, at=point)
    assert modes(linear).stable or nearest


def test_a_linear_motion_is_that_of_the_body() -> None:
    """About a tilted and turned rest: the linear equations follow a small motion."""
    ball = Joint("spherical", "arm", joint_to_child=(0.2, 0.1, -1.0), initial={"psi": 0.9})
    model = Model(
        "arm", {"arm": Body(1.0, (0.2, 0.3, 0.25, 0.02, 0.01, 0.03))}, {"ball": ball},
        loads={"twist": TorsionSpring(("ground", "arm"), 30.0)}, dimensions=3, gravity=GRAVITY,
    )  # fmt: skip
    point = equilibrium(model)
    linear = linearize(model, at=point)
    small = 1e-5
    start = {n: v for n, v in point.values.items() if n.startswith("joint")}
    start["joint.ball.omega"] = small
    found = simulate(
        model, stop_time=1.0, output_interval=0.05, tolerance=1e-12, start_values=start
    )
    names = [v.name for v in linear.states]
    x = np.zeros(len(names))
    x[names.index("joint.ball.omega")] = small
    values, vectors = np.linalg.eig(linear.A)
    weights = np.linalg.solve(vectors, x.astype(complex))
    for name in ("omega_x", "omega", "omega_z"):
        row = vectors[names.index(f"joint.ball.{name}")]
        exact = (row * weights * np.exp(np.outer(found.time, values))).sum(axis=1).real
        np.testing.assert_allclose(found[f"joint.ball.{name}"], exact, atol=1e-3 * small)


def test_a_quaternion_that_is_none_is_refused() -> None:
    zero = dict.fromkeys((f"joint.hook.e{k}" for k in range(4)), 0.0)
    with pytest.raises(RunError, match=r"the quaternion of joint\.hook is zero|nan"):
        linearize(pendulum(), at=zero)
