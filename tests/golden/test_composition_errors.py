"""Systems that are not one program, word for word: composition_errors.txt.

Each is a good system with one thing changed. `pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.golden import check_messages, refused

from m4e_fmi.cosim import load_system, system_program
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program

GOLDEN = Path(__file__).with_name("composition_errors.txt")
CART = """\
name: cart
gravity: 0
parameters: {m: {value: 2, unit: kg, tunable: true}}
bodies: {cart: {mass: m, inertia: 1}}
joints: {rail: {type: prismatic, child: cart, direction: [1, 0], initial: {q: 0.2}}}
points: {tip: {body: cart, at: [0, 0]}}
"""
GOOD = """\
name: carts
components:
  a: {model: cart.model.yaml}
  b: {model: cart.model.yaml}
  total: {kind: sum, inputs: [one], unit: kN}
connections:
  - a.body.cart.x * -10 -> b.body.cart.force_x, units ignored
  - b.body.cart.x * -10 -> a.body.cart.force_x, units ignored
inputs: {push: [a.joint.rail.effort, b.joint.rail.effort]}
simulation: {stop_time: 1, step_size: 0.01}
"""
FIRST, SECOND = "- a.body.cart.x * -10 -> b", "- b.body.cart.x * -10 -> a"
MOORING = """{
    kind: mooring, water: {density: 0, depth: 50},
    line_types: {t: {diameter: 0.1, mass_per_length: 1, axial_stiffness: 1e5, axial_damping: 100,
      drag_coefficient: 0, added_mass_coefficient: 0}},
    anchors: {top: [0, 0]}, fairleads: [tip],
    lines: {l: {type: t, from: top, to: tip, unstretched_length: 2, segments: 2}}}
connections:
  - a.tip <-> line.tip
"""
CASES = {
    "a singular loop of one body": {SECOND: "- a.body.cart.ax * 2 -> a"},
    "a singular loop of two bodies": {
        FIRST: "- a.body.cart.ax * 4 -> b",
        SECOND: "- b.body.cart.ax -> a",
    },
    "a loop that is not linear": {
        SECOND: "- a.body.cart.ax * 0.1 + 2 -> a.m, units ignored\n  - b.body.cart.x -> a"
    },
    "a component with steps of its own": {
        "b: {model: cart.model.yaml}": "b: {model: cart.model.yaml, step_size: 0.1}"
    },
    "a delayed connection": {
        "b.body.cart.force_x, units ignored": "b.body.cart.force_x, units ignored, delayed"
    },
    "an FMU": {"b: {model: cart.model.yaml}": "b: {fmu: cart.fmu}"},
    "MoorDyn": {"connections:\n": f"  line: {MOORING}"},
    "all that is no equation, at once": {
        "b: {model: cart.model.yaml}": "b: {fmu: cart.fmu}",
        "a: {model: cart.model.yaml}": "a: {model: cart.model.yaml, step_size: 0.1}",
        "connections:\n": f"  line: {MOORING}",
    },
    "an own input of two units": {"b.joint.rail.effort]": "total.one]"},
    "an own input of two start values": {
        "b: {model: cart.model.yaml}": "b: {model: cart.model.yaml, start: {joint.rail.effort: 3}}"
    },
}


def test_messages(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    model = tmp_path / "cart.model.yaml"
    model.write_text(CART, "utf-8")
    build_fmu(model_program(load_model(model)), tmp_path / "cart.fmu")

    def message(changes: dict[str, str]) -> str:
        path = tmp_path / "system.yaml"
        return refused(path, GOOD, changes, lambda p: system_program(load_system(p)))

    check_messages(GOLDEN, CASES, message, request)


def test_the_system_itself_is_right(tmp_path: Path) -> None:
    (tmp_path / "cart.model.yaml").write_text(CART, "utf-8")
    (tmp_path / "system.yaml").write_text(GOOD, "utf-8")
    assert len(system_program(load_system(tmp_path / "system.yaml")).states) == 4


def test_what_is_no_equation_can_be_left_open(tmp_path: Path) -> None:
    (tmp_path / "cart.model.yaml").write_text(CART, "utf-8")
    text = GOOD.replace("connections:\n", f"  line: {MOORING}")
    (tmp_path / "system.yaml").write_text(text, "utf-8")
    program = system_program(load_system(tmp_path / "system.yaml"), keep_open=["line"])
    assert "a.point.tip.force_x" in [v.name for v in program.inputs]
