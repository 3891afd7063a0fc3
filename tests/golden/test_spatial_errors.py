"""Wrong models in space, and word for word what is said about each: spatial_errors.txt.

Each is a good model with one thing changed. `pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.golden import check_messages, refused

from m4e_fmi.model import load_model

GOLDEN = Path(__file__).with_name("spatial_errors.txt")
GOOD = """\
name: crane
dimensions: 3
gravity: [0, 0, -9.81]
parameters: {m: {value: 2, unit: kg}, l: {value: 3, unit: m}}
bodies:
  tower: {mass: m, inertia: [1, 2, 2.5]}
  arm: {mass: 1, inertia: [1, 1, 1, 0.1, 0, 0]}
  load: {mass: 1, inertia: [1, 1, 1]}
  hull: {mass: 5, inertia: [1, 1, 1]}
  slide: {mass: 5, inertia: [1, 1, 1]}
joints:
  swing: {type: revolute, child: tower, axis: [0, 0, 1], initial: {q: 1}}
  lift: {type: universal, child: arm, parent: tower, axis: [0, 1, 0], second_axis: [1, 0, 0]}
  hook: {type: spherical, child: load, parent: arm, joint_to_child: [0, 0, -1], initial: {phi: 0}}
  sea: {type: floating, child: hull, initial: {x: 1, psi: 0.2}}
  deck: {type: planar, child: slide, parent: hull, axis: [0, 0, 1], direction: [1, 0, 0]}
points:
  tip: {body: arm, at: [1, 0, 0]}
  mark: {body: ground, at: [1, 2, 3]}
loads:
  rope: {type: tension_spring, points: [tip, mark], stiffness: 10, length: 1}
  wind: {type: body_force, body: hull, force: [1, 0, 0], moment: [0, 0, 1]}
  turn: {type: torsion_spring, bodies: [hull, slide], stiffness: 1}
  motor: {type: joint_effort, joint: swing, effort: 1}
"""
CASES = {
    "planar vector of a point": ("at: [1, 0, 0]", "at: [1, 0]"),
    "planar vector of a joint": ("joint_to_child: [0, 0, -1]", "joint_to_child: [0, -1]"),
    "planar axis": ("axis: [0, 0, 1], initial", "axis: [0, 1], initial"),
    "planar force": ("force: [1, 0, 0]", "force: [1, 0]"),
    "four entries": ("at: [1, 0, 0]", "at: [1, 0, 0, 0]"),
    "no vector": ("at: [1, 0, 0]", "at: 1"),
    "planar gravity": ("gravity: [0, 0, -9.81]", "gravity: [0, -9.81]"),
    "planar zero vector": ("joint_to_child: [0, 0, -1]", "joint_to_child: [0, 0]"),
    "planar zero gravity": ("gravity: [0, 0, -9.81]", "gravity: [0, 0]"),
    "no gravity": ("gravity: [0, 0, -9.81]", "gravity:"),
    "a truth value as gravity": ("gravity: [0, 0, -9.81]", "gravity: true"),
    "dimensions in quotes": ("dimensions: 3", 'dimensions: "3"'),
    "an absolute angle": ("initial: {q: 1}", "coordinate: absolute, initial: {q: 1}"),
    "a thin rod": ("inertia: [1, 2, 2.5]", "inertia: [0, 2, 2]"),
    "the speed of a joint with several": ("swing, effort: 1", "swing, effort: -joint.lift.u"),
    "scalar inertia": ("inertia: [1, 2, 2.5]", "inertia: 2"),
    "two moments of inertia": ("inertia: [1, 2, 2.5]", "inertia: [1, 2]"),
    "negative moment of inertia": ("inertia: [1, 2, 2.5]", "inertia: [1, -2, 2.5]"),
    "no body has these moments": ("inertia: [1, 2, 2.5]", "inertia: [1, 2, 3.5]"),
    "products too large": ("inertia: [1, 1, 1, 0.1, 0, 0]", "inertia: [1, 1, 1, 1.5, 0, 0]"),
    "a unit in an inertia": ("inertia: [1, 2, 2.5]", "inertia: [1, 2, m]"),
    "a word in an inertia": ("inertia: [1, 2, 2.5]", "inertia: [1, 2, big]"),
    "no axis": ("axis: [0, 0, 1], initial", "initial"),
    "axis without length": ("axis: [0, 0, 1], initial", "axis: [0, 0, 0], initial"),
    "no second axis": (", second_axis: [1, 0, 0]", ""),
    "the same axis twice": ("second_axis: [1, 0, 0]", "second_axis: [0, -3, 0]"),
    "second axis of a hinge": (
        "axis: [0, 0, 1], initial",
        "axis: [0, 0, 1], second_axis: [1, 0, 0], initial",
    ),
    "axis of a ball joint": ("spherical, child: load", "spherical, axis: [0, 0, 1], child: load"),
    "direction of a hinge": (
        "axis: [0, 0, 1], initial",
        "axis: [0, 0, 1], direction: [1, 0, 0], initial",
    ),
    "no direction": (", direction: [1, 0, 0]", ""),
    "direction along the axis": ("direction: [1, 0, 0]", "direction: [0, 0, 1]"),
    "direction at an angle": ("direction: [1, 0, 0]", "direction: [1, 0, 0.1]"),
    "coordinate to choose": (
        "axis: [0, 0, 1], initial",
        "axis: [0, 0, 1], coordinate: relative, initial",
    ),
    "type of another program": ("type: spherical", "type: ball"),
    "misspelled type": ("type: spherical", "type: sperical"),
    "start of a ball joint": ("initial: {phi: 0}", "initial: {q: 0}"),
    "quaternion as a start": ("initial: {phi: 0}", "initial: {e0: 1}"),
    "start of a hinge": ("initial: {q: 1}", "initial: {phi: 1}"),
    "floating to a body": (
        "type: floating, child: hull",
        "type: floating, parent: arm, child: hull",
    ),
    "floating with geometry": ("child: hull,", "child: hull, joint_to_child: [0, 0, 1],"),
    "effort on a ball joint": ("joint: swing", "joint: hook"),
    "effort on two axes": ("joint: swing", "joint: lift"),
    "effort along no coordinate": ("joint: swing", "joint: lift, along: q3"),
    "effort along a joint's only": ("joint: swing", "joint: swing, along: q1"),
    "rest angle": ("[hull, slide], stiffness: 1", "[hull, slide], stiffness: 1, angle: 0.2"),
    "scalar moment": ("moment: [0, 0, 1]", "moment: 1"),
    "moment with two entries": ("moment: [0, 0, 1]", "moment: [0, 1]"),
    "motion of a ball joint": ("effort: 1", "effort: joint.hook.q"),
    "variable that is not": ("effort: 1", "effort: body.hull.e0"),
    "acceleration in a load": ("effort: 1", "effort: body.hull.alpha_x"),
    "unit of a coordinate": ("initial: {q: 1}", "initial: {q: l}"),
    "dimensions": ("dimensions: 3", "dimensions: 4"),
    "dimensions as a word": ("dimensions: 3", "dimensions: spatial"),
    "a spatial model without dimensions": ("dimensions: 3\n", ""),
    "several at once": ("inertia: [1, 2, 2.5]}\n  arm: {mass: 1", "inertia: 2}\n  arm: {mass: -1"),
}


def test_messages(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    def message(change: tuple[str, str]) -> str:
        return refused(tmp_path / "crane.model.yaml", GOOD, dict([change]), load_model)

    check_messages(GOLDEN, CASES, message, request)


def test_the_model_itself_is_right(tmp_path: Path) -> None:
    path = tmp_path / "crane.model.yaml"
    path.write_text(GOOD, "utf-8")
    assert load_model(path).warnings == ()
