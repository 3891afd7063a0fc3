"""Springs, dampers and stops whose two points coincide, at the start or on the way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.programs import Evaluated

from m4e_fmi.analysis import equilibrium, linearize, sensitivity
from m4e_fmi.errors import RunError
from m4e_fmi.model import (
    Body,
    Bushing,
    Joint,
    Model,
    Parameter,
    Point,
    PointDrag,
    TensionDamper,
    TensionSpring,
    TensionStop,
)
from m4e_fmi.model.loads import Load
from m4e_fmi.multibody import model_program
from m4e_fmi.report import animate, draw_model
from m4e_fmi.simulate import simulate

MASS = 2.0
ENDS = ("wall", "hook")
METHODS = ("dop853", "rk45", "rodas")


def sliding(**loads: Load) -> Model:
    """A block of 2 kg on a rail along X, at q; its hook is at the wall where q = 0."""
    return Model(
        name="block",
        gravity=0.0,
        bodies={"block": Body(MASS, 1.0)},
        joints={"rail": Joint("prismatic", "block", direction=(1.0, 0.0))},
        points={"hook": Point("block", (0.0, 0.0)), "wall": Point("ground", (0.0, 0.0))},
        loads=loads,
        parameters={"none": Parameter(0.0, "m")},
    )


def flying(**loads: Load) -> Model:
    """The same block, free in the plane."""
    return replace(sliding(**loads), joints={"air": Joint("floating", "block")})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("length", [0.0, "none"])
def test_a_spring_without_length_swings_through_its_anchor(method: str, length: str) -> None:
    """ẍ = −k x from (0, 0) and 3 m/s: also where the length is 0 by the value of a parameter."""
    model = sliding(spring=TensionSpring(ENDS, stiffness=50.0, length=length))
    run = simulate(model, stop_time=4.0, method=method, start_values={"joint.rail.u": 3.0})
    # 1e-8 in each of some hundred steps
    np.testing.assert_allclose(run["joint.rail.q"], 0.6 * np.sin(5 * run.time), atol=3e-6)
    assert run.energy is not None
    assert run.energy.relative < 1e-5
    extension = np.abs(run["joint.rail.q"])
    np.testing.assert_allclose(run["load.spring.extension"], extension, atol=1e-14)
    np.testing.assert_allclose(run["load.spring.tension"], 50 * extension, atol=1e-12)


def test_at_rest_in_one_place_nothing_happens() -> None:
    loads = {
        "spring": TensionSpring(ENDS, stiffness=50.0, length=0.3),
        "rubber": TensionSpring(ENDS, length=0.1, law="40*l + 3*l**3 + ld"),
        "damper": TensionDamper(ENDS, damping=4.0),
        "rope": TensionStop(ENDS, 1e3, upper=2.0, damping=3.0),
        "strut": TensionStop(ENDS, 1e3, lower=0.2, damping=3.0),
        "foot": Bushing(ENDS, stiffness=9.0, damping=3.0),
        "drag": PointDrag("hook", 3.0),
    }
    for name, load in loads.items():
        rates = Evaluated(model_program(flying(**{name: load}))).rates({})
        assert set(rates.values()) == {0.0}, name


def test_a_bushing_is_linear_in_the_plane() -> None:
    """Both coordinates are damped oscillators: x = e^(−dt) …, with c/2m = 1 and k/m = 5."""
    model = flying(foot=Bushing(ENDS, stiffness=10.0, damping=4.0))
    values = {"body.block.vx": 3.0, "body.block.z": 0.5}
    run = simulate(model, stop_time=3.0, start_values=values, tolerance=1e-10)
    t = run.time
    np.testing.assert_allclose(run["body.block.x"], 1.5 * np.exp(-t) * np.sin(2 * t), atol=1e-8)
    z = 0.5 * np.exp(-t) * (np.cos(2 * t) + np.sin(2 * t) / 2)
    np.testing.assert_allclose(run["body.block.z"], z, atol=1e-8)
    assert run.energy is not None
    assert run.energy.relative < 1e-7
    pull = 10 * run["body.block.x"] + 4 * run["body.block.vx"]
    np.testing.assert_allclose(run["load.foot.force_x"], pull, atol=1e-12)
    lost = 4 * (run["body.block.vx"] ** 2 + run["body.block.vz"] ** 2)
    np.testing.assert_allclose(run["load.foot.power"], -lost, atol=1e-12)
    linear = linearize(model)
    assert linear.mechanical is not None
    np.testing.assert_allclose(linear.mechanical.K, np.diag([10.0, 10.0, 0.0]), atol=1e-12)
    np.testing.assert_allclose(linear.mechanical.C, np.diag([4.0, 4.0, 0.0]), atol=1e-12)


@pytest.mark.parametrize("length", [0.0, "none"])
def test_a_spring_without_length_has_its_stiffness_in_all_directions(length: str) -> None:
    model = flying(spring=TensionSpring(ENDS, stiffness=50.0, length=length))
    linear = linearize(model, at=equilibrium(model))
    assert linear.mechanical is not None
    np.testing.assert_allclose(linear.mechanical.K, np.diag([50.0, 50.0, 0.0]), atol=1e-12)


@pytest.mark.parametrize("load", [
    TensionSpring(ENDS, stiffness=50.0, length=0.3),
    TensionSpring(ENDS, length=0.0, law="40*l + ld"),
    TensionDamper(ENDS, damping=4.0),
    TensionStop(ENDS, 1e3, lower=0.2),
])  # fmt: skip
def test_what_has_no_derivative_is_refused(load: Load) -> None:
    model = flying(tie=load)
    with pytest.raises(RunError, match="two points of load tie coincide at t = 0 s"):
        linearize(model)
    with pytest.raises(RunError, match="two points of load tie coincide"):
        sensitivity(model, of=["der(body.block.vx)"], by=["body.block.vx"])


def test_what_passes_through_is_drawn(tmp_path: Path) -> None:
    spring, damper = TensionSpring(ENDS, stiffness=50.0, length=0.0), TensionDamper(ENDS, 1.0)
    model = sliding(spring=spring, damper=damper, foot=Bushing(ENDS, 1.0))
    run = simulate(model, stop_time=0.1, start_values={"joint.rail.u": 3.0})
    assert draw_model(model, tmp_path / "block.png").stat().st_size
    assert animate(model, run, tmp_path / "block.html").stat().st_size
