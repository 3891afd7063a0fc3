"""Models: the same from YAML and Python, and everything that can be wrong with one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document
from m4e_fmi.model import (
    Body,
    BodyForce,
    Joint,
    Model,
    Parameter,
    Point,
    PointForce,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
    load_model,
)
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program
from m4e_fmi.program.python_form import python_source

TEXT = """\
name: crane
description: A trolley with a beam
gravity: 9.81

parameters:
  m: {value: 2, unit: t, description: Mass of the beam}
  L: {value: 3.5, unit: m}

bodies:
  trolley: {mass: 0.5*m, inertia: 1, added_mass: true}
  beam: {mass: m, inertia: m*L**2/12, description: Hangs below}

joints:
  rail: {type: prismatic, child: trolley, direction: [1, 0], initial: {q: 2*L, u: -0.5}}
  hinge: {type: revolute, parent: trolley, child: beam, joint_to_child: [0, -L/2]}

points:
  tip: {body: beam, at: [0, -L/2], description: Lower end}
  wall: {body: ground, at: [10, 0]}

loads:
  rope: {type: tension_spring, points: [wall, tip], stiffness: 100*m, length: L}
  brake: {type: tension_damper, points: [wall, tip], damping: 5}
  stiff: {type: torsion_spring, bodies: [ground, beam], stiffness: 40, angle: pi/8}
  slow: {type: torsion_damper, bodies: [trolley, beam], damping: 3}
  push: {type: point_force, point: tip, force: [3*cos(1.5*t), 0]}
  lift: {type: body_force, body: beam, force: [0, 2], moment: -t}
"""


def crane() -> Model:
    return Model(
        name="crane",
        description="A trolley with a beam",
        gravity=9.81,
        parameters={"m": Parameter(2.0, "t", "Mass of the beam"), "L": Parameter(3.5, "m")},
        bodies={
            "trolley": Body("0.5*m", 1.0, added_mass=True),
            "beam": Body("m", "m*L**2/12", "Hangs below"),
        },
        joints={
            "rail": Joint(
                "prismatic", "trolley", direction=(1.0, 0.0), initial={"q": "2*L", "u": -0.5}
            ),
            "hinge": Joint("revolute", "beam", "trolley", joint_to_child=(0.0, "-L/2")),
        },
        points={
            "tip": Point("beam", (0.0, "-L/2"), "Lower end"),
            "wall": Point("ground", (10.0, 0.0)),
        },
        loads={
            "rope": TensionSpring(("wall", "tip"), "100*m", "L"),
            "brake": TensionDamper(("wall", "tip"), 5.0),
            "stiff": TorsionSpring(("ground", "beam"), 40.0, "pi/8"),
            "slow": TorsionDamper(("trolley", "beam"), 3.0),
            "push": PointForce("tip", ("3*cos(1.5*t)", 0.0)),
            "lift": BodyForce("beam", (0.0, 2.0), "-t"),
        },
    )


class TestYamlAndPython:
    def test_they_give_the_same_model(self) -> None:
        assert model_of(Document.parse(TEXT)) == crane()

    def test_they_give_the_same_program(self, tmp_path: Path) -> None:
        path = tmp_path / "crane.model.yaml"
        path.write_text(TEXT)
        programs = [model_program(path), model_program(str(path)), model_program(crane())]
        sources = {python_source(program) for program in programs}
        assert len(sources) == 1
        for group in ("parameters", "inputs", "states", "outputs"):
            assert len({getattr(program, group) for program in programs}) == 1

    def test_parameters_and_start_values_are_in_si(self) -> None:
        program = model_program(crane())
        mass, length = program.parameters[:2]
        assert (mass.start, mass.unit, mass.display_unit) == (2000.0, "kg", "t")
        assert (length.start, length.unit, length.display_unit) == (3.5, "m", None)
        assert {v.name: v.start for v in program.states} == {
            "joint.rail.q": 7.0,
            "joint.rail.u": -0.5,
            "joint.hinge.q": 0.0,
            "joint.hinge.u": 0.0,
        }

    def test_variables_of_the_program(self) -> None:
        """Names of DESIGN section 3; fixed points have no motion to report."""
        program = model_program(crane())
        inputs = {v.name: v.unit for v in program.inputs}
        assert inputs == {
            "body.trolley.force_x": "N",
            "body.trolley.force_z": "N",
            "body.trolley.moment_y": "N.m",
            "body.beam.force_x": "N",
            "body.beam.force_z": "N",
            "body.beam.moment_y": "N.m",
            "point.tip.force_x": "N",
            "point.tip.force_z": "N",
            "joint.rail.effort": "N",
            "joint.hinge.effort": "N.m",
        }
        outputs = {v.name: (v.unit, v.derivative_of) for v in program.outputs}
        assert outputs["body.beam.theta"] == ("rad", None)
        assert outputs["body.beam.alpha"] == ("rad/s2", "body.beam.omega")
        assert outputs["point.tip.vx"] == ("m/s", "point.tip.x")
        assert outputs["point.tip.az"] == ("m/s2", "point.tip.vz")
        assert {name for name in outputs if name.startswith("energy")} == {
            "energy.kinetic",
            "energy.potential",
            "energy.total",
        }
        assert not any("wall" in name for name in (*inputs, *outputs))
        units = [v.unit for v in program.parameters if v.name.startswith("added_mass[3,")]
        assert units == ["kg.m", "kg.m", "kg.m2"]

    def test_a_model_without_its_gravity_has_the_standard_one(self) -> None:
        text = TEXT.replace("gravity: 9.81\n", "")
        assert model_of(Document.parse(text)).gravity == 9.80665

    def test_the_examples_load(self) -> None:
        examples = Path(__file__).parents[3] / "examples"
        paths = sorted(examples.glob("*/*.model.yaml"))
        assert paths
        for path in paths:
            assert model_program(load_model(path)).states


def problems(text: str) -> list[Problem]:
    with pytest.raises(InputError) as caught:
        model_of(Document.parse(text, "crane.model.yaml"))
    return caught.value.problems


def changed(*pairs: tuple[str, str]) -> str:
    text = TEXT
    for old, new in pairs:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the example"
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize("name", ["t", "pi", "sin", "time", "Theta_1", "SD_2", "XDD_10", "A_1_2"])
def test_parameters_cannot_take_a_name_with_a_meaning(name: str) -> None:
    (problem,) = problems(
        changed(("  L: {value", f"  {name}: {{value: 1, unit: m}}\n  L: {{value"))
    )
    assert problem.message == f"{name!r} already has a meaning in expressions"
    assert problem.remedy == "rename this parameter"
    assert problem.source.startswith(f"  {name}:")


def test_an_element_that_is_wrong_is_still_declared() -> None:
    """A mistake in one body is not also reported where other elements refer to that body."""
    (problem,) = problems(changed(("mass: m,", "mass: [m],")))
    assert problem.message == "expected a number or an expression, got ['m']"


class TestPythonModel:
    """Checks that in a file are made by its form."""

    @staticmethod
    def found(**changes: Any) -> list[str]:
        model = crane()
        fields = {name: getattr(model, name) for name in model.__dataclass_fields__}
        with pytest.raises(InputError) as caught:
            Model(**{**fields, **changes})
        return [problem.message for problem in caught.value.problems]

    def test_all_problems_are_listed(self) -> None:
        model = crane()
        bodies = {**model.bodies, "beam": Body("mm", 1.0)}
        loads = {"push": PointForce("top", (1.0, 0.0)), "lift": BodyForce("bem")}
        with pytest.raises(InputError) as caught:
            Model(name="crane", bodies=bodies, joints=model.joints, loads=loads)
        text = str(caught.value)
        for line in (
            "crane: bodies.beam.mass: 'mm' is not declared",
            "crane: joints.hinge.joint_to_child.1: 'L' is not declared",
            "crane: loads.push.point: unknown point 'top'",
            "crane: loads.lift.body: unknown body 'bem'\n      did you mean 'beam'?",
            "6 problems",
        ):
            assert line in text

    @pytest.mark.parametrize(
        ("joint", "message"),
        [
            (
                lambda: Joint("weld", "beam"),  # pyright: ignore[reportArgumentType]
                "joints.hinge.type: unknown type 'weld'",
            ),
            (
                lambda: Joint("revolute", "beam", joint_to_child=(1.0,)),  # pyright: ignore[reportArgumentType]
                "joints.hinge.joint_to_child: joint_to_child: expected [x, z], got 1 entry",
            ),
            (
                lambda: Joint("floating", "beam", parent_to_joint=3.0),  # pyright: ignore[reportArgumentType]
                "joints.hinge.parent_to_joint: parent_to_joint: expected [x, z], got 3.0",
            ),
        ],
    )
    def test_joints(self, joint: Callable[[], Joint], message: str) -> None:
        assert message in self.found(joints={**crane().joints, "hinge": joint()})

    def test_ends(self) -> None:
        loads = {"rope": TensionSpring(("tip",), 1.0, 1.0)}  # pyright: ignore[reportArgumentType]
        assert self.found(loads=loads) == ["loads.rope.points: expected two points, got 1"]

    def test_parameter_values(self) -> None:
        wrong: Any = "3"
        parameters = {**crane().parameters, "L": Parameter(wrong, "m")}
        assert self.found(parameters=parameters) == [
            "parameters.L.value: expected a finite number, got '3'"
        ]

    def test_numbers_of_numpy_are_numbers(self) -> None:
        import numpy as np

        body = Body(np.int64(3), np.float64(2.0))  # pyright: ignore[reportArgumentType]
        joint = Joint("floating", "a", joint_to_child=[0, 0])  # pyright: ignore[reportArgumentType]
        model = Model(name="a", bodies={"a": body}, joints={"j": joint})
        assert len(model_program(model).states) == 6
