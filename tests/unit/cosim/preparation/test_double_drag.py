"""Loads on one body in two components that may count twice are told."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.cosim import load_system, prepare

MODEL = """\
name: buoy
bodies: {float: {mass: 150e3, inertia: 1e6}}
joints: {sea: {type: floating, child: float, initial: {z: -1.2}}}
"""
SYSTEM = """\
name: buoy
components:
  buoy: {{model: buoy.model.yaml}}
  first: {{kind: morison, bodies: &bodies {{float: {{center_of_gravity: [0, -1.2]}}}},
      members: &legs {{leg: {{ends: [[0, -9], [0, 2]], diameter: 1, drag: 1, body: float,
      added_mass: 0, inertia: 0}}}}}}
  second: {{kind: morison, bodies: *bodies, members: *legs}}
connections: [buoy.float <-> first.float, {second}]
simulation: {{stop_time: 1, step_size: 0.1}}
"""


def warnings(folder: Path, second: str) -> list[str]:
    (folder / "buoy.model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "system.yaml").write_text(SYSTEM.format(second=second), encoding="utf-8")
    system = load_system(folder / "system.yaml")
    return list(prepare(system, build_directory=folder / "build").warnings)


def test_drag_in_two_components_is_told(tmp_path: Path) -> None:
    found = warnings(tmp_path, "buoy.body.float.z -> second.float.z")
    assert [w for w in found if "first.float and second.float both have drag" in w]
    alone = warnings(tmp_path, "buoy.body.float.vz -> second.float.vz")
    assert not any("both have drag" in w for w in alone)
