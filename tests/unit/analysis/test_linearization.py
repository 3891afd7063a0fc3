"""Linear equations: against difference quotients of the program, names, what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.planar_trees import random_tree
from support.programs import Evaluated, random_values

from m4e_fmi.analysis import linearize
from m4e_fmi.model import Body, BodyForce, Joint, Model, Parameter, Point, TensionSpring
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Recorder, Variable

STEP = 1e-6
QUOTIENT = 1e-8
"""Of central differences with STEP in doubles: STEP² and 1e-16/STEP, times values up to 1e2."""


@pytest.mark.parametrize("seed", range(6))
def test_state_space_of_trees(seed: int) -> None:
    """A, B, C, D in motion, under load, about a point that accelerates."""
    program = model_program(random_tree(seed, size=4, wet=seed % 2))
    values = random_values(program, seed)
    inputs = [program.inputs[0].name, program.inputs[-1].name, program.parameters[0].name]
    outputs = [program.outputs[k].name for k in (0, 7, -1)] + [program.states[1].name]
    linear = linearize(program, at=values, inputs=inputs, outputs=outputs)
    evaluated = Evaluated(program)
    states = [v.name for v in linear.states]

    def everything(values: dict[str, float]) -> np.ndarray:
        found = {**values, **evaluated.outputs(values)}
        rates = evaluated.rates(values)
        return np.array([*(rates[n] for n in states), *(found[n] for n in outputs)])

    given = {v.name: v.start for v in program.parameters} | values
    found = np.block([[linear.A, linear.B], [linear.C, linear.D]])
    for j, name in enumerate([*states, *inputs]):
        ahead, behind = (everything({**given, name: given[name] + side * STEP}) for side in (1, -1))
        quotient = (ahead - behind) / (2 * STEP)
        assert found[:, j] == pytest.approx(quotient, rel=1e-6, abs=QUOTIENT * 1e2)
    assert np.concatenate([linear.rates, linear.values]) == pytest.approx(
        everything(given), rel=1e-12
    )


def cart(**initial: float) -> Model:
    """A cart on a rail with a pole on it; a spring from the tip to the ground."""
    return Model(
        name="cart_pole",
        gravity=9.81,
        parameters={"m": Parameter(0.4, "kg"), "k": Parameter(3.0, "N/m")},
        bodies={"cart": Body(1.5, 1.0), "pole": Body("m", 0.05)},
        joints={
            "rail": Joint("prismatic", "cart", direction=(1, 0)),
            "pivot": Joint(
                "revolute", "pole", "cart", joint_to_child=(0, 0.4), initial={"q": 0.3, **initial}
            ),
        },
        points={"tip": Point("pole", (0, 0.4)), "wall": Point("ground", (2.0, 1.0))},
        loads={
            "spring": TensionSpring(("tip", "wall"), "k", 1.2),
            "wind": BodyForce("pole", ("0.1*m", 0)),
        },
    )


@pytest.mark.parametrize("coordinate", ["absolute", "relative"])
def test_efforts_are_generalised_forces(coordinate: Any) -> None:
    """F of a joint's effort: on its coordinate, and if angles are absolute, off the parent's."""
    half = (0.0, -0.4)
    model = Model(
        name="arm",
        gravity=9.81,
        bodies={name: Body(1.3, 0.2) for name in "abc"},
        joints={
            "a": Joint("revolute", "a", "ground", joint_to_child=half),
            "b": Joint("revolute", "b", "a", half, half, coordinate=coordinate),
            "c": Joint("revolute", "c", "b", half, half, coordinate=coordinate),
        },
    )
    at = {"joint.a.q": 0.4, "joint.b.q": -0.7, "joint.c.u": 1.5}
    linear = linearize(model, at=at, inputs=[f"joint.{name}.effort" for name in "abc"])
    expected = np.eye(3) if coordinate == "relative" else np.eye(3) - np.eye(3, k=1)
    assert linear.mechanical is not None
    assert pytest.approx(expected, abs=1e-13) == linear.mechanical.F
    assert pytest.approx(linear.mechanical.M.T, rel=1e-14) == linear.mechanical.M


def test_other_states_come_last() -> None:
    r = Recorder("actuator", "a mass behind a slow actuator")
    command = r.input(Variable("command", "N", "command"))
    force = r.state(Variable("force", "N", "force"))
    x = r.state(Variable("x", "m", "position"))
    v = r.state(Variable("v", "m/s", "velocity", derivative_of="x"))
    r.rate("force", (command - force) / 0.5)
    r.rate("x", v)
    r.rate("v", force - 4.0 * x)
    linear = linearize(r.program(), inputs=["command"])
    assert [v.name for v in linear.states] == ["x", "v", "force"]
    assert np.array_equal(linear.C, np.eye(3))  # outputs are the states
    assert np.array_equal(linear.A, [[0, 1, 0], [-4, 0, 1], [0, 0, -2]])
    assert np.array_equal(linear.B, [[0], [0], [2]])
    assert linear.mechanical is None
