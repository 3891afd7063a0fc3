"""Exact sensitivities of models with free attitudes, against differences, some in 80 digits.

The differences turn a body by a rotation of finite size; of the small rotations that the exact
derivatives use they know nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath
import numpy as np
import pytest
from support.differences import difference
from support.tape_values import exact_values

from m4e_fmi.analysis import (
    Linearizer,
    eigenvalue_sensitivity,
    equilibrium,
    linearize,
    modes,
    sensitivity,
    trajectory_sensitivity,
)
from m4e_fmi.model import (
    Body,
    Bushing,
    Joint,
    Model,
    Parameter,
    Point,
    TensionSpring,
    TorsionDamper,
)
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.simulate import simulate

BY = ("m", "L", "k", "c")
CLOSE = 1e-6
DIGITS, H = 80, mpmath.mpf("1e-15")
"""Differences are off by H² of third derivatives, and need 45 of the digits."""


def moored() -> Model:
    """A free body on three elastic lines that hold it askew, with a second one on a ball joint."""
    places = {"a": (1.2, 0.1, 0.3), "b": (-0.6, 1.0, 0.2), "c": (-0.5, -0.8, -0.1)}
    return Model(
        name="moored",
        dimensions=3,
        gravity=9.81,
        parameters={
            "m": Parameter(2.3, "kg"),
            "L": Parameter(0.8, "m"),
            "k": Parameter(60.0, "N/m"),
            "c": Parameter(3.0, "N.s/m"),
        },
        bodies={
            "hull": Body(5.0, (0.9, 1.1, 1.4, 0.1, -0.05, 0.08)),
            "bob": Body("m", (0.2, "0.1 + 0.1*m*L**2", 0.15, 0.01, 0.02, 0.0)),
        },
        joints={
            "free": Joint("floating", "hull", initial={"phi": 0.3, "psi": -0.2, "omega_x": 0.5}),
            "ball": Joint(
                "spherical", "bob", "hull", (0.1, 0.2, -0.3), (0.05, 0, "-L"),
                initial={"theta": 0.4, "omega": -0.7, "omega_z": 1.1},
            ),
        },
        points={n: Point("hull", at) for n, at in places.items()}
        | {f"{n}_post": Point("ground", (2 * x, 2 * y, 1.5)) for n, (x, y, _) in places.items()}
        | {"tip": Point("bob", (0.1, 0, 0)), "tip_post": Point("ground", (0.5, 0.6, -2.0))},
        loads={n: Bushing((n, f"{n}_post"), "k", damping="c") for n in places}
        | {
            "pull": TensionSpring(("tip", "tip_post"), "k/3", 0.4),
            "damper": TorsionDamper(("hull", "bob"), 0.2),
        },
    )  # fmt: skip


def turned(e: Sequence[Any], axis: int, angle: Any) -> list[Any]:
    """The quaternion `e` (4,) turned about an axis of the world by `angle` [rad]."""
    c, s = mpmath.cos(angle / 2), mpmath.sin(angle / 2)
    p = [c, 0, 0, 0]
    p[axis + 1] = s
    return [
        p[0] * e[0] - p[1] * e[1] - p[2] * e[2] - p[3] * e[3],
        p[0] * e[1] + p[1] * e[0] + p[2] * e[3] - p[3] * e[2],
        p[0] * e[2] - p[1] * e[3] + p[2] * e[0] + p[3] * e[1],
        p[0] * e[3] + p[1] * e[2] - p[2] * e[1] + p[3] * e[0],
    ]


def moved(values: dict[str, Any], state: str, by: Any) -> dict[str, Any]:
    """`values` with a state changed, or a body turned."""
    owner, _, last = state.rpartition(".")
    if not last.startswith("rotation_"):
        return values | {state: values[state] + by}
    names = [f"{owner}.e{k}" for k in range(4)]
    e = turned([values[name] for name in names], "xyz".index(last[-1]), by)
    return values | dict(zip(names, e, strict=True))


def exact_A(program: Program, states: Sequence[str], values: dict[str, Any]) -> Any:
    """A of the `states` by differences; θ̇ = ω × θ + δω of small rotations as the book says."""
    n = len(states)
    A = mpmath.zeros(n, n)
    rates = dict(zip((v.name for v in program.states), program.rates, strict=True))
    rows = [k for k, name in enumerate(states) if "rotation" not in name]
    for j, state in enumerate(states):
        ahead, behind = (
            exact_values(program, [rates[states[k]] for k in rows], moved(values, state, side * H))
            for side in (1, -1)
        )
        for k, a, b in zip(rows, ahead, behind, strict=True):
            A[k, j] = (a - b) / (2 * H)
    for k, name in enumerate(states):
        owner, _, last = name.rpartition(".")
        if not last.startswith("rotation_"):
            continue
        omega = [f"{owner}.{part}" for part in ("omega_x", "omega", "omega_z")]
        i = "xyz".index(last[-1])
        A[k, states.index(omega[i])] = 1
        later, after = (i + 1) % 3, (i + 2) % 3
        A[k, states.index(f"{owner}.rotation_{'xyz'[after]}")] = values[omega[later]]
        A[k, states.index(f"{owner}.rotation_{'xyz'[later]}")] = -values[omega[after]]
    return A


@pytest.mark.verifies(
    "sensitivities of linear equations with free attitudes",
    independent="second differences in 80 digits",
    tolerance="1e-11",
)
@pytest.mark.parametrize("seed", [0, 1])
def test_change_of_the_linear_equations(seed: int) -> None:
    """By parameters and along all numbers of a quaternion, at a point that moves and turns."""
    model, random = moored(), np.random.default_rng(seed)
    program = model_program(model)
    linearizer = Linearizer(model)
    names = [v.name for v in linearizer.states]
    at = {v.name: v.start + random.uniform(-0.3, 0.3) for v in program.states}
    for owner in ("body.hull", "joint.ball"):
        e = np.array([at[f"{owner}.e{k}"] for k in range(4)])
        at |= {f"{owner}.e{k}": part for k, part in enumerate(e / np.linalg.norm(e))}
    linear = linearizer.at(at)
    along = {name: random.uniform(-1, 1) for name in (*BY, *(v.name for v in program.states))}
    values: dict[str, Any] = {n: mpmath.mpf(v) for n, v in linear.point.values.items()}
    for direction in ({"L": 1.0}, along):
        found = linearizer.change(linear.point, direction)
        with mpmath.workdps(DIGITS):
            step = mpmath.mpf("1e-12")
            ahead, behind = (
                exact_A(program, names, values | {
                    n: values[n] + side * step * d for n, d in direction.items()
                })
                for side in (1, -1)
            )  # fmt: skip
            exact = np.array(((ahead - behind) / (2 * step)).tolist(), dtype=float)
        assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()
    with mpmath.workdps(DIGITS):
        exact = np.array(exact_A(program, names, values).tolist(), dtype=float)
    assert np.abs(linear.A - exact).max() < 1e-12 * np.abs(exact).max()


def test_the_equilibrium_moves() -> None:
    """Attitudes, places and reactions at rest, by each parameter."""
    model = moored()
    of = ["body.hull.phi", "body.hull.e2", "body.bob.theta", "body.bob.z", "joint.ball.reaction_x"]
    point = equilibrium(model)
    found = sensitivity(model, of=of, by=BY, at=point, moving=True)

    for by in BY:

        def values(p: float, by: str = by) -> np.ndarray:
            rest = equilibrium(model, at={**point.values, by: p})
            return linearize(model, at=rest, outputs=of).values

        expected = difference(values, model.parameters[by].value)
        exact = np.array([found[name, by] for name in of])
        assert exact == pytest.approx(expected, rel=CLOSE, abs=CLOSE)
    assert np.abs(found.values[:, 0]).max() > 0.01


@pytest.mark.verifies(
    "sensitivities of eigenvalues with free attitudes, also where the equilibrium moves",
    independent="central differences of fourth order",
    tolerance="1e-6",
)
@pytest.mark.parametrize("moving", [False, True])
def test_eigenvalues(moving: bool) -> None:
    model = moored()
    point = equilibrium(model)
    found = eigenvalue_sensitivity(model, by=BY, at=point, moving=moving)
    assert np.isfinite(found.values).all()
    for j, by in enumerate(BY):

        def values(p: float, by: str = by) -> np.ndarray:
            at = {**point.values, by: p}
            rest = equilibrium(model, at=at) if moving else at
            return modes(linearize(model, at=rest)).eigenvalues

        expected = difference(values, model.parameters[by].value)
        assert found.values[:, j] == pytest.approx(expected, rel=CLOSE, abs=CLOSE)


def test_a_top_in_closed_form() -> None:
    """Fast and slow precession of an upright top, by its spin: C n Ω − A Ω² = m g l."""
    mass, arm, polar, across, spin = 2.0, 0.5, 0.5, 0.3 + 2.0 * 0.25, 60.0
    top = Model("top", {"top": Body(mass, (0.3, 0.3, polar))}, {
        "tip": Joint("spherical", "top", joint_to_child=(0, 0, arm), initial={"omega_z": spin})
    }, dimensions=3, gravity=9.81)  # fmt: skip
    linearizer = Linearizer(top)
    linear = linearizer.at()
    change = linearizer.change(linear.point, {"joint.tip.omega_z": 1.0})
    found = modes(linear)
    root = np.sqrt((polar * spin) ** 2 - 4 * across * mass * 9.81 * arm)
    for side in (1, -1):
        rate = (polar * spin + side * root) / (2 * across)
        k = int(np.argmin(np.abs(found.eigenvalues - 1j * rate)))
        slope = found.left[:, k].conj() @ change @ found.right[:, k]
        assert slope == pytest.approx(1j * polar * rate / (side * root), rel=1e-8)


def test_a_trajectory() -> None:
    """Two seconds, by parameters and by the angular velocity at the start."""
    model = moored()
    by, of = ["L", "k", "joint.ball.omega_z"], ["body.hull.psi", "body.bob.x", "joint.ball.e1"]
    found = trajectory_sensitivity(
        model, of=of, by=by, stop_time=2.0, output_interval=0.5, tolerance=1e-11
    )
    program = model_program(model)
    start = {v.name: v.start for v in (*program.parameters, *program.states)}

    for name in by:

        def values(p: float, name: str = name) -> np.ndarray:
            run = simulate(program, start_values={name: p}, stop_time=2.0, output_interval=0.5,
                           tolerance=1e-13)  # fmt: skip
            return np.column_stack([run[n] for n in of])

        expected = difference(values, start[name])
        exact = np.stack([found[n, name] for n in of], axis=1)
        assert np.abs((exact - expected) / np.abs(expected).max(axis=0)).max() < CLOSE
