"""The energy audit: works are integrals of powers, and close the balance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.model import (
    Body,
    BodyForce,
    Joint,
    JointEffort,
    JointStop,
    Model,
    Point,
    TensionSpring,
)
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.audit import KINETIC, POTENTIAL, TOTAL, energy_audit

EXAMPLES = Path(__file__).parents[3] / "examples"
PENDULUM = EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml"
"""With dampers and a force on its second body."""


def slider(**loads: BodyForce | JointEffort) -> Model:
    """2 kg on a horizontal rail, from rest."""
    joint = Joint("prismatic", "block", direction=(1.0, 0.0), initial={"u": 3.0})
    return Model("slider", {"block": Body(2.0, 1.0)}, {"rail": joint}, loads=loads)


def test_works_of_loads_and_inputs_as_written_down_by_hand() -> None:
    """2ẍ = −4ẋ + 6 from 3 m/s: ẋ = 1.5 (1 + e^(−2t)); −4ẋ is a load, 6 N come from outside."""
    model = slider(drag=JointEffort("rail", "-4*joint.rail.u"))
    result = simulate(model, stop_time=2.0, start_values={"body.block.force_x": 6.0})
    t = result.time
    # ∫ 4ẋ² dt and ∫ 6ẋ dt
    drag = -9 * (t + (1 - np.exp(-2 * t)) + (1 - np.exp(-4 * t)) / 4)
    pull = 9 * (t + (1 - np.exp(-2 * t)) / 2)
    # a local error of 1e-8·(1 + |x|) per step, some tens of steps, a power of some 10 W
    assert result["load.drag.work"] == pytest.approx(drag, abs=1e-5)
    assert result["inputs.work"] == pytest.approx(pull, abs=1e-5)
    assert result["inputs.power"] == pytest.approx(9 * (1 + np.exp(-2 * t)), abs=1e-6)
    audit = result.energy
    assert audit is not None
    assert audit.scale == pytest.approx(-drag[-1], abs=1e-4)
    assert audit.relative < 1e-6
    assert result.variables["load.drag.work"].unit == "J"


@pytest.mark.parametrize("method", ["dop853", "rk45", "rodas"])
def test_works_allow_the_motion_no_larger_error(method: str) -> None:
    """Many works that hardly change beside a motion that does: the steps stay as short."""
    slow = {f"rub{k}": JointEffort("rail", "-1e-9*joint.rail.u") for k in range(40)}
    spring = TensionSpring(("wall", "hook"), stiffness=50.0, length=0.0)
    points = {"wall": Point("ground", (0.0, 0.0)), "hook": Point("block", (0.0, 0.0))}
    model = replace(slider(), points=points, loads={"spring": spring})
    heavy = replace(model, loads={"spring": spring, **slow})
    alone, beside = (simulate(m, stop_time=5.0, method=method) for m in (model, heavy))
    exact = 3 / 5 * np.sin(5 * alone.time)
    errors = [np.abs(run["joint.rail.q"] - exact).max() for run in (alone, beside)]
    # the loads change the motion by 40e-9/4 of it in each second
    assert errors[1] < 1.5 * errors[0] + 5 * 40e-9 / 4
    assert beside.evaluations > 0.9 * alone.evaluations


@pytest.mark.parametrize("method", ["dop853", "rk45", "rodas"])
def test_the_balance_closes_at_kinks_that_the_motion_does_not_have(method: str) -> None:
    """At the end of a damped contact the force is zero on both sides; the power is not."""
    stop = JointStop("rail", 1e4, lower=0.0, damping=20.0)
    fall = Joint("prismatic", "ball", direction=(0.0, 1.0), initial={"q": 1.0})
    model = Model("ball", {"ball": Body(1.0, 1.0)}, {"rail": fall}, loads={"floor": stop})
    found = [
        simulate(model, stop_time=5.0, tolerance=tolerance, method=method).energy
        for tolerance in (1e-6, 1e-8, 1e-10)
    ]
    relative = [audit.relative for audit in found if audit]
    # some thousand steps, each off by the tolerance: times 3 orders, and 5 for growth at contacts
    assert relative[0] < 5e-3
    assert relative[1] < 1e-5
    assert relative[2] < 1e-7


def test_a_power_that_is_missing_is_seen() -> None:
    result = simulate(without_power(model_program(PENDULUM), "load.push.power"), stop_time=5.0)
    assert result.energy is not None
    assert result.energy.relative > 0.01


def without_power(program: Program, name: str) -> Program:
    zero = program.tape.constant(0.0).index
    named = zip(program.outputs, program.results, strict=True)
    return replace(program, results=tuple(zero if v.name == name else k for v, k in named))


def test_nothing_happens_and_no_energy() -> None:
    still = slider()
    resting = simulate(still, stop_time=1.0, start_values={"joint.rail.u": 0.0})
    assert resting.energy is not None
    assert (resting.energy.relative, resting.energy.scale) == (0.0, 0.0)
    program = model_program(still)
    bare = replace(program, outputs=(), results=())
    assert simulate(bare, stop_time=1.0).energy is None


def test_the_height_of_the_origin_does_not_hide_a_residual() -> None:
    """1 J falls from a height where the potential is 1 MJ; 0.1 J are missing at the end."""
    kinetic, potential = np.array([0.0, 0.9]), np.array([1e6, 1e6 - 1.0])
    audit = energy_audit({KINETIC: kinetic, POTENTIAL: potential, TOTAL: kinetic + potential})
    assert audit is not None
    assert audit.scale == pytest.approx(1.0, rel=1e-9)
    assert audit.relative == pytest.approx(0.1, rel=1e-8)
