"""A body in space on three mooring lines: the same motion in a world that is turned about Z."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.results.results_file import Results

TURN = math.radians(37)
DRIFT, SWAY = 1.0, -0.5  # m/s, along the barge and to port

MODEL = """\
name: barge
description: A barge of 150 t that floats on three springs
dimensions: 3
gravity: 9.81
bodies:
  hull: {{mass: 150.0e3, inertia: [2.0e6, 2.5e6, 3.0e6, 1.0e5, 0, 0]}}
joints:
  sea:
    type: floating
    child: hull
    initial: {{psi: {yaw}, vx: {vx}, vy: {vy}, omega_z: 0.02}}
points:
  bow: {{body: hull, at: [6, 0, 0]}}
  port: {{body: hull, at: [-3, 5, 0]}}
  starboard: {{body: hull, at: [-3, -5, 0]}}
loads:
  lift_1: {{type: point_force, point: bow, force: [0, 0, 497e3 - 3e5*point.bow.z]}}
  lift_2: {{type: point_force, point: port, force: [0, 0, 497e3 - 3e5*point.port.z]}}
  lift_3: {{type: point_force, point: starboard, force: [0, 0, 497e3 - 3e5*point.starboard.z]}}
  drag: {{type: body_drag, body: hull, coefficient: 2.0e4, moment_coefficient: 1.0e7}}
"""
SYSTEM = """\
name: barge
components:
  barge: {{model: barge.model.yaml}}
  mooring:
    kind: mooring
    dimensions: 3
    water: {{density: 1025, depth: 50, gravity: 9.81}}
    line_types:
      chain: {{diameter: 0.09, mass_per_length: 50, axial_stiffness: 2.0e+8,
              axial_damping_ratio: 1.0, drag_coefficient: 1.3, added_mass_coefficient: 1.0}}
    anchors: {{{anchors}}}
    fairleads: [f1, f2, f3]
    lines:
      l1: {{type: chain, from: a1, to: f1, unstretched_length: 165, segments: 10}}
      l2: {{type: chain, from: a2, to: f2, unstretched_length: 165, segments: 10}}
      l3: {{type: chain, from: a3, to: f3, unstretched_length: 165, segments: 10}}
connections:
  - barge.point.bow <-> mooring.f1
  - barge.point.port <-> mooring.f2
  - barge.point.starboard <-> mooring.f3
simulation: {{stop_time: 8, step_size: 0.1, algorithm: corrector}}
"""


def turned(turn: float, x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(turn), math.sin(turn)
    return c * x - s * y, s * x + c * y


def files(folder: Path, turn: float) -> Path:
    """The barge and its lines in a world turned by `turn` [rad] about Z."""
    folder.mkdir()
    vx, vy = turned(turn, DRIFT, SWAY)
    (folder / "barge.model.yaml").write_text(MODEL.format(yaw=turn, vx=vx, vy=vy), "utf-8")
    places = []
    for number in range(3):
        angle = 2 * math.pi * number / 3
        x, y = turned(turn, 160 * math.cos(angle), 160 * math.sin(angle))
        places.append(f"a{number + 1}: [{x!r}, {y!r}, -50]")
    path = folder / "system.yaml"
    path.write_text(SYSTEM.format(anchors=", ".join(places)), "utf-8")
    return path


def results(folder: Path, turn: float) -> Results:
    prepared = prepare(load_system(files(folder, turn)), build_directory=folder)
    outcome = run(prepared, results=folder / "r.nc", certify=False)
    for bond in outcome.energy:
        # of the energy that a line and the barge exchange; its sign changes with the motion
        assert abs(bond.given - bond.received) < 0.02 * max(abs(bond.given), 2e4)
    return outcome.results()


@pytest.mark.verifies(
    "a body in space on MoorDyn's lines, in a world turned by 37° about Z",
    analytic="symmetry: the same system, not turned",
    tolerance="1e-6",
)
def test_a_turned_world_has_the_turned_motion(tmp_path: Path) -> None:
    straight, other = results(tmp_path / "straight", 0.0), results(tmp_path / "turned", TURN)
    for names in (("x", "y", "z"), ("vx", "vy", "vz"), ("omega_x", "omega", "omega_z")):
        before, after = (
            np.array([found[f"barge.body.hull.{name}"].values for name in names])
            for found in (straight, other)
        )
        x, y = turned(TURN, before[0], before[1])
        assert np.abs(np.array([x, y, before[2]]) - after).max() < 1e-6 * max(
            1, np.abs(before).max()
        )
    yaw = other["barge.body.hull.psi"].values - straight["barge.body.hull.psi"].values
    assert np.abs(yaw - TURN).max() < 1e-6
    assert np.ptp(straight["barge.body.hull.y"].values) > 0.5
