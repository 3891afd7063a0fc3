"""Members on moving bodies: energy in still water, currents, decay."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, system_program
from m4e_fmi.program import Program
from m4e_fmi.simulate import simulate

RHO, D, L = 1025.0, 0.6, 10.0
AREA = math.pi / 4 * D**2

MODEL = """\
name: pendulum
{dimensions}
gravity: 0
bodies: {{rod: {{mass: 4000, inertia: {inertia}, added_mass: true}}}}
joints: {{hold: {joint}}}
{loads}
"""
SYSTEM = """\
name: pendulum
components:
  pendulum: {{model: pendulum.model.yaml}}
  water:
    kind: morison
    dimensions: {dimensions}
    water: {{density: 1025, depth: 60}}
    {current}
    bodies: {{rod: {{center_of_gravity: {center}}}}}
    members:
      rod_axis: {{ends: {ends}, diameter: 0.6, drag: {drag}, added_mass: 1.2, body: rod,
        buoyancy: false{ends_of_it}}}
connections:
  - pendulum.rod <-> water.rod
  - water.added_mass -> pendulum.added_mass
simulation: {{stop_time: 5, step_size: 0.01}}
"""


def system(folder: Path, texts: dict[str, str], **more: str) -> Program:
    """The composed program of a body with one member."""
    given = {"loads": "", "current": "", "ends_of_it": "", **texts, **more}
    model = {**given, "dimensions": f"dimensions: {given['dimensions']}"}
    (folder / "pendulum.model.yaml").write_text(MODEL.format(**model), "utf-8")
    (folder / "system.yaml").write_text(SYSTEM.format(**given), "utf-8")
    return system_program(load_system(folder / "system.yaml"), build_directory=folder / "build")


FREE = {"joint": "{type: floating, child: rod, initial: {z: -20}}"}
PLANE = {
    "dimensions": "2",
    "inertia": "3e4",
    "center": "[0, -20]",
    "ends": "[[1, -25], [-2, -15]]",
    **FREE,
}
SPACE = {
    "dimensions": "3",
    "inertia": "[3e4, 2e4, 1e4]",
    "center": "[0, 0, -20]",
    "ends": "[[1, -2, -25], [-2, 1, -15]]",
    **FREE,
}
MOVING = {"vx": 1.0, "vy": 0.6, "vz": -0.5, "omega": 0.8, "omega_x": 0.5, "omega_z": -0.3}
"""Start velocities of the rod [m/s, rad/s]."""


def run(program: Program, **velocities: float) -> Any:
    """A run of 12 s with these start velocities of the rod."""
    start = {f"pendulum.body.rod.{name}": value for name, value in velocities.items()}
    known = {v.name for v in program.states}
    start = {name: value for name, value in start.items() if name in known}
    return simulate(program.with_start(start), stop_time=12.0, output_interval=0.5, tolerance=1e-10)


@pytest.mark.verifies(
    "a rod that turns in still water without drag keeps its energy, added mass included",
    analytic="conservation",
    tolerance="1e-7",
)
@pytest.mark.parametrize("ends", ["", ", end_added_mass: 9"], ids=["bare", "plates"])
@pytest.mark.parametrize("texts", [PLANE, SPACE], ids=["plane", "space"])
def test_still_water_keeps_the_energy_of_a_turning_body(
    tmp_path: Path, texts: dict[str, str], ends: str
) -> None:
    """Body and water keep ½ vᵀ(M + A)v through turns of several radians.

    Plates at the ends have 520 kg each, along the axis.
    """
    result = run(system(tmp_path, texts, drag="0", ends_of_it=ends), **MOVING)
    energy = np.asarray(result["pendulum.energy.total"])
    assert np.ptp(energy) < 1e-7 * energy[0]
    forces = np.asarray(result["water.rod.inertia_force_x"])
    assert np.ptp(forces) > 500.0  # N: of what turns


def test_a_current_only_shifts_the_motion(tmp_path: Path) -> None:
    """A rod that moves with a uniform current, and turns, moves as in still water."""
    (tmp_path / "still").mkdir()
    (tmp_path / "flowing").mkdir()
    at_rest = run(system(tmp_path / "still", SPACE, drag="1.1"), **MOVING)
    carried = {**MOVING, "vx": MOVING["vx"] + 0.7}
    current = "current: {speed: 0.7}"
    in_flow = run(system(tmp_path / "flowing", SPACE, drag="1.1", current=current), **carried)
    for name, shift in (("x", 0.7 * np.asarray(at_rest.time)), ("y", 0.0), ("omega", 0.0)):
        one, two = (np.asarray(r[f"pendulum.body.rod.{name}"]) for r in (at_rest, in_flow))
        assert two - one == pytest.approx(np.zeros(len(one)) + shift, abs=1e-6)


@pytest.mark.verifies(
    "decay of a rod across its axis, and about a hinge at its end beyond half a turn, by drag",
    analytic="v = v₀/(1 + v₀ c t/M), with added mass",
    tolerance="1e-6",
)
@pytest.mark.parametrize("moves", ["along", "about"])
def test_decay_by_drag(tmp_path: Path, moves: str) -> None:
    upright = {**PLANE, "ends": "[[0, -25], [0, -15]]", "drag": "0.2"}
    quadratic = 0.5 * RHO * D * 0.2
    if moves == "along":
        program = system(tmp_path, upright)
        result, name = run(program, vx=2.0), "vx"
        mass, drag, start = 4000 + 1.2 * RHO * AREA * L, quadratic * L, 2.0
    else:
        hinge = (
            "{type: revolute, child: rod, parent_to_joint: [0, -15], joint_to_child: [0, -5], "
            "initial: {u: 2.0}}"
        )
        program = system(tmp_path, upright, joint=hinge)
        result, name = run(program), "omega"
        mass = 3e4 + 4000 * 25 + 1.2 * RHO * AREA * L**3 / 3
        drag, start = quadratic * L**4 / 4, 2.0
        assert np.asarray(result["pendulum.body.rod.theta"])[-1] > math.pi
    found = np.asarray(result[f"pendulum.body.rod.{name}"])
    expected = start / (1.0 + start * drag / mass * np.asarray(result.time))
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.verifies(
    "heave plates: decay along the axis by the drag of the ends, with their added mass",
    analytic="v = v₀/(1 + v₀ c t/M), 8/3 ρ r³ of a thin disc",
    tolerance="1e-6",
)
def test_decay_of_heave_plates(tmp_path: Path) -> None:
    """A thin disc has 4/3 ρ r³ on each side: 2/π of the hemisphere over it."""
    upright = {**PLANE, "ends": "[[0, -25], [0, -15]]"}
    ends = f", end_drag: 4, end_added_mass: {2 / math.pi!r}"
    result = run(system(tmp_path, upright, drag="0.2", ends_of_it=ends), vz=1.5)
    mass = 4000 + 8 / 3 * RHO * (D / 2) ** 3
    drag = 2 * 0.5 * RHO * AREA * 4
    found = np.asarray(result["pendulum.body.rod.vz"])
    expected = 1.5 / (1.0 + 1.5 * drag / mass * np.asarray(result.time))
    assert found == pytest.approx(expected, rel=1e-6)
