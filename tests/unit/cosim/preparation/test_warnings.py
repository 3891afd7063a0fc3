"""What a system may count twice, and runs too short for their sea, are told before the run."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim import load_system, prepare
from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmus.water.doubles import double_buoyancy

MODEL = """\
name: buoy
dimensions: 3
bodies: {float: {mass: 150e3, inertia: [1e6, 1e6, 1e6]}}
joints: {sea: {type: floating, child: float, initial: {z: -1.2}}}
"""
HULL = """\
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
LEGS = """\
name: buoy
components:
  buoy: {{model: buoy.model.yaml}}
  first: {{kind: morison, dimensions: 3, bodies: &bodies {{float: {{center_of_gravity:
      [0, 0, -1.2]}}}}, members: &legs {{leg: {{ends: [[0, 0, -9], [0, 0, 2]], diameter: 1,
      drag: 1, body: float, added_mass: 0, inertia: 0}}}}}}
  second: {{kind: morison, dimensions: 3, bodies: *bodies, members: *legs}}
connections: [buoy.float <-> first.float, buoy.body.float.{signal} -> second.float.{signal}]
simulation: {{stop_time: 1, step_size: 0.1}}
"""
SEA = """\
name: sea
components:
  sea:
    kind: sea
    water: {{density: 1025, depth: 40, gravity: 9.81}}
    waves: {{spectrum: jonswap, significant_height: 2, peak_period: 8, ramp_time: 16}}
    points: {{gauge: [25, 0]}}
    start: {{{start}}}
simulation: {{stop_time: {stop}, step_size: 0.1}}
"""


def written(folder: Path, text: str, **given: object) -> Path:
    (folder / "buoy.model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "system.yaml").write_text(text.format(**given), encoding="utf-8")
    return folder / "system.yaml"


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
def test_buoyancy_of_members_within_a_hull(
    given: dict[str, str], is_told: bool, tmp_path: Path
) -> None:
    given = {"keys": "", "hydrostatics": "linear", **given}
    system = load_system(written(tmp_path, HULL, **given))
    found = list(double_buoyancy(system, connect(system, expected_descriptions(system))))
    told = "inner of legs.float: in part or in full within hull.deck"
    assert [line.startswith(told) for line in found] == [True] * is_told


@pytest.mark.parametrize(("signal", "is_told"), [("z", True), ("vz", False)])
def test_drag_in_two_components(tmp_path: Path, signal: str, is_told: bool) -> None:
    path = written(tmp_path, LEGS, signal=signal)
    found = prepare(path, build_directory=tmp_path / "build").warnings
    assert any("first.float and second.float both have drag" in line for line in found) is is_told


@pytest.mark.parametrize(
    ("stop", "start", "told"),
    [(12, "", "16 s"), (16, "", "16 s"), (16.5, "", ""), (12, "wave.ramp_time: 5", "")],
)
def test_a_run_within_the_ramp_of_its_sea(
    tmp_path: Path, stop: float, start: str, told: str
) -> None:
    path = written(tmp_path, SEA, stop=stop, start=start)
    warnings = prepare(path, build_directory=tmp_path).warnings
    ramps = [line for line in warnings if "ends within the ramp" in line]
    assert len(ramps) == bool(told)
    assert all(f"the run of {stop:g} s" in line and told in line for line in ramps)
