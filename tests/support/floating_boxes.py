"""A system of two hulls in waves and a mooring line, without potential flow: quick to build."""

from __future__ import annotations

from pathlib import Path

MODEL = """\
name: boxes
dimensions: 3
gravity: 9.81
bodies:
  barge: {mass: 24000, inertia: [6.0e4, 1.0e5, 1.2e5]}
  cube: {mass: 4000, inertia: [4.0e3, 4.0e3, 4.0e3]}
  mast: {mass: 10, inertia: [30, 30, 1]}
joints:
  sea_1: {type: floating, child: barge}
  sea_2: {type: floating, child: cube, initial: {x: 12}}
  foot: {type: revolute, parent: barge, child: mast, axis: [0, 1, 0], parent_to_joint: [0, 0, 1],
    joint_to_child: [0, 0, 2]}
points: {bow: {body: barge, at: [-3, 0, -0.5]}}
loads: {stiff: {type: joint_effort, joint: foot, effort: -2.0e3*joint.foot.q - 200*joint.foot.u}}
"""
CUBE = """\
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""
SYSTEM = """\
name: boxes_at_sea
description: Two hulls <in> waves
components:
  boxes: {model: boxes.model.yaml}
  hulls:
    kind: hull_pressure
    dimensions: 3
    water: &water {density: 1000, depth: 20, gravity: 9.81}
    bodies:
      barge: {shape: {box: {length: 6, width: 4, draft: 1, freeboard: 1}},
        center_of_gravity: [0, 0, 0]}
      cube: {shape: {mesh: cube.obj, mesh_origin: [12, 0, 0]}, center_of_gravity: [12, 0, 0]}
    waves: &sea {spectrum: jonswap, significant_height: 0.4, peak_period: 4, direction: 40, seed: 3,
      components: 30, ramp_time: 3, spreading: {exponent: 4}}
  sea: {kind: sea, dimensions: 3, water: *water, waves: *sea, points: {buoy: [7, -3, 0]}}
  mooring:
    kind: mooring
    dimensions: 3
    water: *water
    line_types: {chain: {diameter: 0.03, mass_per_length: 8, axial_stiffness: 1.0e+6,
      axial_damping_ratio: 1, drag_coefficient: 1.3, added_mass_coefficient: 1}}
    anchors: {west: [-40, 0, -20]}
    fairleads: [bow]
    lines: {line: {type: chain, from: west, to: bow, unstretched_length: 44, segments: 12}}
connections:
  - boxes.body.barge <-> hulls.barge
  - boxes.body.cube <-> hulls.cube
  - boxes.point.bow <-> mooring.bow
simulation: {stop_time: 6, step_size: 0.05, algorithm: gauss_seidel}
"""


def floating_boxes(folder: Path) -> Path:
    """The system file of two hulls at sea, written with its model and mesh to a folder."""
    files = {"boxes.model.yaml": MODEL, "cube.obj": CUBE, "system.yaml": SYSTEM}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="ascii")
    return folder / "system.yaml"
