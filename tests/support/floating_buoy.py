"""A buoy held by springs, with a take-off and drag, in waves: a system of programs only."""

from __future__ import annotations

from pathlib import Path

MODEL = """\
name: buoy
gravity: 9.81
parameters: {k: {value: 20e3, unit: N/m}}
bodies: {float: {mass: 143.2e3, inertia: 0.92e6, added_mass: true}}
joints: {sea: {type: floating, child: float, initial: {z: -1.2}}}
points:
  west: {body: ground, at: [-100, -1.2]}
  east: {body: ground, at: [100, -1.2]}
  middle: {body: float, at: [0, 0]}
  pto: {body: float, at: [0, -1.8]}
loads:
  line_1: {type: tension_spring, points: [west, middle], stiffness: k, length: 90}
  line_2: {type: tension_spring, points: [east, middle], stiffness: k, length: 90}
"""
SYSTEM = """\
name: held_buoy
components:
  buoy: {{model: buoy.model.yaml}}
  hydro:
    kind: hydrodynamics
    water: {{density: 1025, depth: 50, gravity: 9.81}}
    bodies:
      float:
        shape: {{cylinder: {{radius: 4, draft: 3}}}}
        center_of_gravity: [0, -1.2]
        panels: 120
        drag: {{surge: 12.0e3, heave: 25.0e3, pitch: 1.0e6}}
    frequencies: {{maximum: 3.0, count: 20}}
    waves: {waves}
  generator:
    {{kind: linear_pto, point: pto, anchor: [0, -50], point_at: [0, -3], damping: 1.2e+5,
     stiffness: 2.0e+4}}
connections:
  - buoy.float        <-> hydro.float
  - hydro.added_mass   -> buoy.added_mass
  - buoy.pto          <-> generator.pto
simulation: {{stop_time: 60, step_size: 0.05}}
"""
STILL = "{spectrum: still}"


def held_buoy(folder: Path, waves: str = STILL) -> Path:
    """The system's file in `folder`, in these waves (YAML)."""
    (folder / "buoy.model.yaml").write_text(MODEL, encoding="utf-8")
    path = folder / "system.yaml"
    path.write_text(SYSTEM.format(waves=waves), encoding="utf-8")
    return path
