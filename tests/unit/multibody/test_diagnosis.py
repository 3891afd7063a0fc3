"""Failures of a simulation name the body, the joint, the quantity and the time."""

from __future__ import annotations

from dataclasses import replace

import pytest

from m4e_fmi.errors import RunError
from m4e_fmi.model import Body, Joint, Model, Parameter, Point, PointForce
from m4e_fmi.simulate import simulate


def arm() -> Model:
    """Two links in hinges; mass and inertia of the second and a force on it are parameters."""
    return Model(
        name="arm",
        parameters={
            "m": Parameter(1.0, "kg"),
            "J": Parameter(1.0, "kg.m2"),
            "k": Parameter(1.0, "N"),
        },
        bodies={"upper": Body(mass=1.0, inertia=0.1), "fore": Body(mass="m", inertia="J")},
        joints={
            "shoulder": Joint(type="revolute", child="upper", joint_to_child=(1.0, 0.0)),
            "elbow": Joint(
                type="revolute",
                child="fore",
                parent="upper",
                parent_to_joint=(1.0, 0.0),
                joint_to_child=(0.5, 0.0),
            ),
        },
        points={"hand": Point("fore", (0.5, 0.0))},
        loads={"pull": PointForce("hand", ("k / (1.0 - t)", 0.0))},
    )


def test_a_singular_mass_matrix_names_body_joint_and_time() -> None:
    """An added mass, given from outside, takes away all inertia of the second link."""
    model = replace(arm(), bodies={**arm().bodies, "fore": Body("m", "J", added_mass=True)})
    less = {f"added_mass[{k},{k}]": -1.0 for k in (1, 2, 3)}
    with pytest.raises(RunError) as caught:
        simulate(model, stop_time=0.1, start_values=less)
    assert "the mass matrix is singular: nothing resists a motion of body fore in joint elbow" in (
        str(caught.value)
    )
    assert "t = 0 s" in str(caught.value)


def test_a_pole_names_load_and_time() -> None:
    model = replace(arm(), loads={"pull": PointForce("hand", ("k / t", 0.0))})
    with pytest.raises(RunError, match=r"arm at t = 0 s.*load pull cannot be computed: .*division"):
        simulate(model, stop_time=1.0)


def test_a_rate_that_grows_beyond_bounds_names_its_body_and_the_time() -> None:
    model = replace(arm(), loads={"pull": PointForce("hand", ("k / (t - 0.25)**3", 0.0))})
    with pytest.raises(RunError, match=r"arm at t = 0\.2(5|49999)\d* s"):
        simulate(model, stop_time=1.0)
