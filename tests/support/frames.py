"""A floating frame of three columns and three pontoons, all of them members, held by springs."""

from __future__ import annotations

import math
from pathlib import Path

RHO, G = 1025.0, 9.81
COLUMN, PONTOON, DRAFT, RADIUS, LEVEL, HEIGHT = 2.0, 1.2, 10.0, 8.0, -9.0, -6.0
"""Diameters, draft, distance of columns from the middle, level of pontoons and of the centre of
gravity [m]."""
PLACES = [
    (RADIUS * math.cos(a), RADIUS * math.sin(a)) for a in (math.radians(k) for k in (0, 120, 240))
]
SIDE = math.dist(*PLACES[:2])
MASS = RHO * math.pi / 4 * 3 * (COLUMN**2 * DRAFT + PONTOON**2 * SIDE)
MODEL = """\
name: frame
dimensions: 3
gravity: {gravity}
bodies: {{frame: {{mass: {mass}, inertia: [1.2e7, 1.2e7, 1.5e7], added_mass: true}}}}
joints: {{sea: {{type: floating, child: frame, initial: {{z: {height}{initial}}}}}}}
points:
  east: {{body: frame, at: [8, 0, 0]}}
  west: {{body: frame, at: [-4, 6.928, 0]}}
  south: {{body: frame, at: [-4, -6.928, 0]}}
  far_east: {{body: ground, at: [108, 0, {height}]}}
  far_west: {{body: ground, at: [-54, 93.53, {height}]}}
  far_south: {{body: ground, at: [-54, -93.53, {height}]}}
loads:
  line_1: {{type: tension_spring, points: [east, far_east], stiffness: 6e3, length: 96}}
  line_2: {{type: tension_spring, points: [west, far_west], stiffness: 6e3, length: 96}}
  line_3: {{type: tension_spring, points: [south, far_south], stiffness: 6e3, length: 96}}
  damper_1: {{type: tension_damper, points: [east, far_east], damping: 25e3}}
  damper_2: {{type: tension_damper, points: [west, far_west], damping: 25e3}}
  damper_3: {{type: tension_damper, points: [south, far_south], damping: 25e3}}
"""
SYSTEM = """\
name: frame
components:
  frame: {{model: frame.model.yaml}}
  water:
    kind: morison
    dimensions: 3
    water: {{density: {density}, depth: 60, gravity: {gravity}}}
    waves: {waves}
    bodies: {{frame: {{center_of_gravity: [0, 0, {height}]}}}}
    members:
{members}
connections: [frame.frame <-> water.frame, water.added_mass -> frame.added_mass]
simulation: {{stop_time: 5, step_size: 0.02}}
"""


def frame_members(drag: float, more: str = "") -> str:
    """Lines of the members; `more` are keys of each."""
    lines = []
    keys = f"drag: {drag}, body: frame{more}"
    for k, (x, y) in enumerate(PLACES):
        lines.append(
            f"      column_{k}: {{ends: [[{x}, {y}, {-DRAFT}], [{x}, {y}, 6]], "
            f"diameter: {COLUMN}, {keys}}}"
        )
        other = PLACES[(k + 1) % 3]
        lines.append(
            f"      pontoon_{k}: {{ends: [[{x}, {y}, {LEVEL}], [{other[0]}, {other[1]}, {LEVEL}]], "
            f"diameter: {PONTOON}, {keys}}}"
        )
    return "\n".join(lines)


def floating_frame(
    folder: Path,
    waves: str = "{spectrum: still}",
    *,
    drag: float = 0.8,
    initial: str = "",
    more: str = "",
) -> Path:
    """The system's file in `folder`."""
    known = {"density": RHO, "gravity": G, "height": HEIGHT, "mass": MASS, "initial": initial}
    (folder / "frame.model.yaml").write_text(MODEL.format(**known), encoding="utf-8")
    path = folder / "system.yaml"
    text = SYSTEM.format(**known, waves=waves, members=frame_members(drag, more))
    path.write_text(text, encoding="utf-8")
    return path
