"""The energy audit: works are integrals of powers, close the balance, and change no motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.planar_trees import random_tree

from m4e_fmi.model import Body, BodyForce, Joint, JointEffort, Model, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, rate_entries
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime.engine import Control, Engine
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.simulation import METHODS, RUNTIME_METHODS

EXAMPLES = Path(__file__).parents[2] / "examples"
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


@pytest.mark.parametrize("method", METHODS)
def test_the_balance_closes_to_the_tolerance(method: str) -> None:
    result = simulate(PENDULUM, stop_time=3.0, tolerance=1e-8, method=method)
    assert result.energy is not None
    # some hundred steps, each off by 1e-8; thousands of SciPy's methods of low order
    assert 0 < result.energy.relative < 1e-6


@pytest.mark.parametrize("method", [m for m in RUNTIME_METHODS if m != "rk4"])
def test_the_residual_falls_with_the_tolerance(method: str) -> None:
    found = [
        simulate(PENDULUM, stop_time=10.0, tolerance=tolerance, method=method).energy
        for tolerance in (1e-6, 1e-8, 1e-10)
    ]
    relative = [audit.relative for audit in found if audit]
    # an error per step in proportion to the tolerance: a factor of 100, and 5 to spare
    assert relative[0] > 20 * relative[1] > 400 * relative[2] > 0


@pytest.mark.parametrize("method", RUNTIME_METHODS)
def test_works_change_no_bit_and_no_step_of_the_motion(method: str) -> None:
    result = simulate(PENDULUM, stop_time=5.0, method=method)
    program = result.program
    engine = Engine(program, jacobian=rate_entries(program) if method == "rodas" else ())
    alone = engine.simulate(result.time, control=Control(method))
    motion = np.column_stack([result[v.name] for v in program.states])
    assert len(program.states) < sum(name.endswith((".q", ".u", ".work")) for name in result.values)
    np.testing.assert_array_equal(motion, alone.states)
    assert result.evaluations == alone.evaluations


def test_scipys_method_takes_the_steps_it_takes_without_works() -> None:
    from scipy.integrate import solve_ivp

    result = simulate(PENDULUM, stop_time=5.0, method="scipy.RK45")
    program = result.program
    form, p = load_python(program), [v.start for v in program.parameters]
    c, start = form.constants(p), [v.start for v in program.states]
    alone = solve_ivp(
        lambda t, x: form.rates(t, x.tolist(), [], p, c), (0, 5), start, rtol=1e-8, atol=1e-8
    )
    assert result.evaluations == alone.nfev
    # the same steps but for the rounding of the tolerance
    last = [result[v.name][-1] for v in program.states]
    np.testing.assert_allclose(last, alone.y[:, -1], rtol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_it_closes_with_all_loads_and_inputs(seed: int) -> None:
    model = random_tree(seed, size=6, wet=1)
    inputs = {v.name: 0.3 * (k % 5 - 2) for k, v in enumerate(model_program(model).inputs)}
    result = simulate(model, stop_time=1.0, tolerance=1e-10, start_values=inputs)
    assert result.energy is not None
    assert abs(result["inputs.work"][-1]) > 0.01
    # some hundred steps, each off by 1e-10; kinks of stops and drag cost two orders more
    assert result.energy.relative < 1e-6


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


def test_every_example_closes() -> None:
    for path in sorted(EXAMPLES.glob("*/*.model.yaml")):
        result = simulate(load_model(path), stop_time=5.0)
        assert result.energy is not None
        assert result.energy.relative < 1e-6
