"""Models of the examples in a world turned about Z: everything that has a direction is turned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.model import Model, load_model
from m4e_fmi.model.elements import inertia_of, parameter_values, vector
from m4e_fmi.model.groups import gravity_of
from m4e_fmi.multibody import model_program
from m4e_fmi.runtime.engine import Control, Engine, Run

EXAMPLES = Path(__file__).parents[2] / "examples"
ANGLE = np.radians(37.0)
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]])
STEP, TIMES = 2e-3, np.linspace(0.0, 100.0, 201)  # s


def turned(model: Model) -> Model:
    """The model with its vectors, tensors and gravity turned; joints and bodies only."""
    values = parameter_values(model.parameters)

    def vectors(owner: object, *fields: str) -> dict[str, Any]:
        given = {field: vector(owner, field) for field in fields if getattr(owner, field, None)}
        numbers = {f: np.array([float(p.evaluate(values)) for p in v]) for f, v in given.items()}
        return {f: tuple((TURN @ v).tolist()) for f, v in numbers.items() if len(v) == 3}

    bodies = {}
    for name, body in model.bodies.items():
        xx, yy, zz, xy, yz, zx = [*(float(p.evaluate(values)) for p in inertia_of(body)), 0, 0, 0][
            :6
        ]
        J = TURN @ np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) @ TURN.T
        bodies[name] = replace(body, inertia=(J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[1, 2], J[2, 0]))
    fields = ("parent_to_joint", "joint_to_child", "axis", "second_axis", "direction")
    joints = {n: replace(joint, **vectors(joint, *fields)) for n, joint in model.joints.items()}
    points = {n: replace(point, **vectors(point, "at")) for n, point in model.points.items()}
    g = TURN @ [float(part.evaluate(values)) for part in gravity_of(model)]
    return replace(model, bodies=bodies, joints=joints, points=points, gravity=tuple(-g))


def simulated(model: Model) -> tuple[Engine, Run]:
    program = model_program(model, inputs=())
    positions = [f"body.{name}.{axis}" for name in model.bodies for axis in "xyz"]
    engine = Engine(program, outputs=positions)
    x = [v.start for v in program.states]
    return engine, engine.simulate(TIMES, states=x, control=Control(method="rk4", max_step=STEP))


@pytest.mark.verifies(
    "examples in space, turned by 37° about Z: rates, and 100 s of RK4",
    analytic="symmetry: the same model, not turned", tolerance="1e-10",
)  # fmt: skip
@pytest.mark.parametrize("name", ["gyroscope/gyroscope.model.yaml", "arm/arm.urdf"])
def test_turned_examples(name: str) -> None:
    model = load_model(EXAMPLES / name)
    if name.startswith("arm"):  # falls from a pose in which all joints bear weight
        start = {f"j{k}": {"q": 0.3 * (-1) ** k} for k in range(1, 8)}
        joints = {n: replace(joint, initial=start[n]) for n, joint in model.joints.items()}
        model = replace(model, joints=joints)
    (engine, plain), (other, moved) = simulated(model), simulated(turned(model))
    r = np.random.default_rng(2)
    for _ in range(5):
        x = r.uniform(-1, 1, len(engine.program.states))
        expected = engine.rates(0.0, x)
        assert np.abs(other.rates(0.0, x) - expected).max() < 1e-10 * np.abs(expected).max()
    assert np.ptp(plain.states, axis=0).max() > 0.5
    assert np.abs(plain.states - moved.states).max() < 1e-10 * np.abs(plain.states).max()
    places = plain.outputs.reshape(len(TIMES), -1, 3) @ TURN.T
    assert np.abs(places - moved.outputs.reshape(places.shape)).max() < 1e-10
