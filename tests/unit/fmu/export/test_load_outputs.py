"""Forces of loads, and their power: as outputs of programs, of FMUs, of coupled runs."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from m4e_fmi.cosim import load_system, run
from m4e_fmi.fmu import read_description
from m4e_fmi.model import (
    Body,
    BodyDrag,
    BodyForce,
    Joint,
    JointEffort,
    JointFriction,
    JointStop,
    Model,
    Point,
    PointForce,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.report import run_summary, simulation_summary
from m4e_fmi.simulate import simulate

ROUNDING = 1e-12

MODEL = """\
name: slider
bodies: {block: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: block, direction: [1, 0], initial: {q: 0.5}}}
points:
  wall: {body: ground, at: [-1, 0]}
  hook: {body: block, at: [0, 0]}
loads:
  spring: {type: tension_spring, points: [wall, hook], stiffness: 50, length: 1}
  pto: {type: tension_damper, points: [wall, hook], damping: 4, description: Generator}
"""


def two_bodies() -> Model:
    """A carriage on a rail and an arm on it, which move; one load of most kinds."""
    return Model(
        name="pair",
        bodies={"car": Body(2.0, 1.0), "arm": Body(1.0, 0.3)},
        joints={
            "rail": Joint("prismatic", "car", direction=(1.0, 0.0), initial={"u": 0.4}),
            "pin": Joint("revolute", "arm", "car", joint_to_child=(0.0, -0.5), initial={"q": 1.0}),
        },
        points={"tip": Point("arm", (0.0, -0.5)), "wall": Point("ground", (-2.0, 0.5))},
        loads={
            "spring": TensionSpring(("wall", "tip"), stiffness=50.0, length=1.5),
            "damper": TensionDamper(("wall", "tip"), damping=4.0),
            "coil": TorsionSpring(("car", "arm"), stiffness=5.0, angle=0.2),
            "oil": TorsionDamper(("car", "arm"), damping=0.7),
            "push": PointForce("tip", ("sin(3*t)", 2.0), "body"),
            "lift": BodyForce("arm", (0.3, "t"), 0.6),
            "sea": BodyDrag("arm", 0.8, 0.2, (1.0, 0.0)),
            "motor": JointEffort("pin", "cos(t)"),
            "rub": JointFriction("rail", 0.5, 0.1),
            "stop": JointStop("pin", 100.0, upper=0.9, damping=2.0),
        },
    )


def test_every_load_tells_its_force_and_what_it_depends_on() -> None:
    result = simulate(two_bodies(), stop_time=3.0, tolerance=1e-9)

    def same(name: str, value: np.ndarray) -> None:
        np.testing.assert_allclose(result[f"load.{name}"], value, atol=ROUNDING, err_msg=name)

    t, theta, omega = result.time, result["body.arm.theta"], result["body.arm.omega"]
    way = np.array([result["point.tip.x"] + 2.0, result["point.tip.z"] - 0.5])
    speed = np.array([result["point.tip.vx"], result["point.tip.vz"]])
    distance = np.hypot(*way)
    rate = (way * speed).sum(axis=0) / distance
    same("spring.distance", distance)
    same("spring.extension", distance - 1.5)
    same("spring.tension", 50 * (distance - 1.5))
    same("damper.distance_rate", rate)
    same("damper.tension", 4 * rate)
    same("damper.power", -4 * rate**2)
    same("coil.twist", theta - 0.2)
    same("coil.moment", 5 * (theta - 0.2))
    same("oil.moment", 0.7 * omega)
    same("oil.power", -0.7 * omega**2)
    x, z = np.sin(3 * t), 2.0
    same("push.force_x", np.cos(theta) * x + np.sin(theta) * z)
    same("push.force_z", np.cos(theta) * z - np.sin(theta) * x)
    same(
        "push.power",
        (result["load.push.force_x"] * speed[0] + result["load.push.force_z"] * speed[1]),
    )
    same("lift.moment", np.full(len(t), 0.6))
    wind = np.array([result["body.arm.vx"] - 1.0, result["body.arm.vz"]])
    same("sea.force_x", -0.8 * np.hypot(*wind) * wind[0])
    same("sea.moment", -0.2 * np.abs(omega) * omega)
    same("motor.effort", np.cos(t))
    same("motor.power", np.cos(t) * omega)
    same("rub.effort", -0.5 * np.tanh(result["joint.rail.u"] / 0.1))
    depth = np.maximum(0, theta - 0.9)
    more = np.minimum(np.maximum(2 * omega, -100 * depth), 100 * depth)
    same("stop.effort", -(100 * depth + more))
    same("stop.gap", 0.9 - theta)
    assert depth.any()


def test_they_are_in_coupled_results_and_summaries(tmp_path: Path) -> None:
    """The mean power of a damper inside a model is in the results and in what is printed."""
    path, file = tmp_path / "slider.model.yaml", tmp_path / "s.system.yaml"
    path.write_text(MODEL, encoding="utf-8")
    file.write_text(
        "name: s\ncomponents:\n  buoy: {model: slider.model.yaml}\n"
        "connections: []\nsimulation: {stop_time: 2.0, step_size: 0.01}\n",
        encoding="utf-8",
    )
    alone = simulate(path, stop_time=2.0)
    outcome = run(load_system(file), results=tmp_path / "s.nc", build_directory=tmp_path / "build")
    loaded = outcome.results()
    for name in ("load.pto.power", "load.spring.tension", "load.spring.extension"):
        # the same method at the same tolerance, 1e-8, restarted at each step
        np.testing.assert_allclose(loaded[f"buoy.{name}"].values, alone[name], atol=1e-5)
    mean = alone["load.pto.work"][-1] / 2.0
    told = run_summary(outcome)
    assert re.search(rf"buoy\.load\.pto\.power .* {mean:.2f}", told)
    assert "from rows" not in told
    summary = simulation_summary(alone)
    assert f"{mean: .6g} W" in summary
    variable = read_description(tmp_path / "build" / "s" / "buoy.fmu").variables["load.pto.power"]
    assert (variable.causality, variable.unit) == ("output", "W")
    assert variable.description == "Generator: power by which the load changes the total energy"
    fewer = load_system(file).changed(output_interval=0.5)
    outcome = run(fewer, results=tmp_path / "s.nc", build_directory=tmp_path / "build")
    assert "from rows every 0.5 s" in run_summary(outcome)
