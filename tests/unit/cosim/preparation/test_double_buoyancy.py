"""Members that reach into a hull on the same body, where both have buoyancy."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.input_checks.inputs import expected_descriptions
from m4e_fmi.cosim.preparation.double_buoyancy import double_buoyancy

MODEL = """\
name: buoy
dimensions: 3
bodies: {float: {mass: 150e3, inertia: [1e6, 1e6, 1e6]}}
joints: {sea: {type: floating, child: float, initial: {z: -1.2}}}
"""
SYSTEM = """\
name: buoy
components:
  buoy: {{model: buoy.model.yaml}}
  hull:
    kind: hydrodynamics
    dimensions: 3
    bodies:
      deck: {{shape: {{cylinder: {{radius: 4, draft: 3}}}}, center_of_gravity: [0, 0, -1.2]}}
    loads: {{hydrostatics: {hydrostatics}}}
  legs:
    kind: morison
    dimensions: 3
    bodies: {{float: {{center_of_gravity: [0, 0, -1.2]}}}}
    members:
      inner: {{ends: [[1, 0, -9], [1, 0, {top}]], diameter: 1, drag: 1, body: float{keys}}}
      outer: {{ends: [[6, 0, -9], [6, 0, 2]], diameter: 1, drag: 1, body: float}}
connections: [buoy.float <-> hull.deck, buoy.float <-> legs.float]
simulation: {{stop_time: 1, step_size: 0.1}}
"""


@pytest.mark.parametrize(
    ("given", "is_told"),
    [
        ({"top": "-1.5"}, True),
        ({"top": "-3.1"}, False),
        ({"top": "-1.5", "keys": ", buoyancy: false"}, False),
        ({"top": "-1.5", "keys": ", added_mass: 0, inertia: 0"}, False),
        ({"top": "-1.5", "hydrostatics": "none"}, False),
    ],
)
def test_members_within_a_hull_are_told(
    given: dict[str, str], is_told: bool, tmp_path: Path
) -> None:
    text = SYSTEM.format(**{"keys": "", "hydrostatics": "linear", **given})
    (tmp_path / "buoy.model.yaml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "system.yaml").write_text(text, encoding="utf-8")
    system = load_system(tmp_path / "system.yaml")
    found = list(double_buoyancy(system, connect(system, expected_descriptions(system))))
    assert len(found) == is_told
    if is_told:
        assert found[0].startswith("inner of legs.float: in part or in full within hull.deck")
