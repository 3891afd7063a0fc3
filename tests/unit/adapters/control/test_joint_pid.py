"""The controller of joints: what its parameters may be, and the way that it leads."""

from __future__ import annotations

import math

import pytest
from support.programs import Evaluated

from m4e_adapters.control.joint_pid import JointPidConfig, joint_pid
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program
from m4e_fmi.simulate import simulate


def controller(**joint: float) -> Program:
    elbow = {"target": 0.8, "proportional": 400.0, **joint}
    return joint_pid(JointPidConfig(joints={"elbow": elbow}, duration=2.0), name="c")


def test_parameters_have_the_limits_of_the_keys() -> None:
    limits = {v.name: v.minimum for v in controller(most=3.0).parameters}
    assert limits.pop("duration") == 1e-6
    places = {name: limits.pop(f"elbow.{name}") for name in ("target", "begin")}
    assert set(places.values()) == {-math.inf}
    assert set(limits.values()) == {0.0}
    for name, value in (("duration", 0.0), ("elbow.integral", -1.0)):
        with pytest.raises(InputError, match="outside its range"):
            simulate(controller(), stop_time=1.0, start_values={name: value})


def test_the_way_and_the_limit_of_the_effort() -> None:
    """Half of the way after half of the time; 400 N.m/rad of 0.4 rad are more than 30 N.m."""
    outputs = Evaluated(controller(most=30.0)).outputs({"elbow.q": 0.0}, t=1.0)
    assert outputs["elbow.wanted"] == pytest.approx(0.4, rel=1e-15)
    assert outputs["elbow.effort"] == 30.0
