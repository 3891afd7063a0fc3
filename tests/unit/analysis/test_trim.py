"""Equilibria with given properties, against statics by hand."""

from __future__ import annotations

import math

import pytest

from m4e_fmi.analysis import trimmed
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.model import Body, Joint, JointEffort, Model, Parameter

G = 9.81


def model() -> Model:
    """A pendulum of mass m with a torsion spring k, and a mass on a spring with a constant push."""
    return Model(
        "two",
        {"bob": Body("m", 0.1), "block": Body(2.0, 1.0)},
        {
            "hinge": Joint("revolute", "bob", joint_to_child=(0.5, 0.0)),
            "rail": Joint("prismatic", "block", direction=(1.0, 0.0)),
        },
        parameters={
            "m": Parameter(1.0, "kg"),
            "k": Parameter(20.0, "N.m/rad"),
            "push": Parameter(0.0, "N"),
        },
        loads={
            "torsion": JointEffort("hinge", "-k*joint.hinge.q"),
            "spring": JointEffort("rail", "push - 100*joint.rail.q"),
        },
        gravity=G,
    )


def test_one_parameter_for_one_value() -> None:
    point = trimmed(model(), such_that={"joint.hinge.q": 0.3}, vary=["m"])
    # the bob hangs at an angle q below the horizontal: m g 0.5 cos q = k q
    assert point["m"] == pytest.approx(20 * 0.3 / (G * 0.5 * math.cos(0.3)), rel=1e-9)
    assert point["joint.hinge.q"] == pytest.approx(0.3, abs=1e-9)


def test_two_at_once_with_units() -> None:
    wanted = {"joint.hinge.q": "20 deg", "joint.rail.q": "-4 cm"}
    point = trimmed(model(), such_that=wanted, vary=["push", "k"])
    angle = math.radians(20)
    assert point["push"] == pytest.approx(-4.0, rel=1e-9)
    assert point["k"] == pytest.approx(G * 0.5 * math.cos(angle) / angle, rel=1e-9)


def test_limits_of_parameters_hold() -> None:
    """No mass lifts the bob: the search ends with a mass that is not negative."""
    with pytest.raises(RunError, match=r"no equilibrium with these values .* m = \d"):
        trimmed(model(), such_that={"joint.hinge.q": -0.3}, vary=["m"])


def test_a_parameter_without_effect() -> None:
    with pytest.raises(RunError, match="do not change them one by one"):
        trimmed(model(), such_that={"joint.hinge.q": 0.3}, vary=["push"])


def test_counts_and_values_are_told_together() -> None:
    with pytest.raises(InputError) as caught:
        trimmed(model(), such_that={"joint.rail.q": "4 kg"}, vary=["push", "k"])
    text = str(caught.value)
    assert "kg is not m" in text
    assert "1 values are given, 2 parameters may vary" in text
