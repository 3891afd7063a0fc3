"""Models: the same from YAML and Python, and everything that can be wrong with one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from m4e_fmi.document import Document
from m4e_fmi.errors import InputError, Problem
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
        examples = Path(__file__).parents[2] / "examples"
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


ELEMENT_CHECKS = {
    "gravity": (
        ("gravity: 9.81", "gravity: gg"),
        "gravity: gg",
        "'gg' is not declared",
        "known names: L, m, pi",
    ),
    "unit": (
        ("value: 3.5, unit: m", "value: 3.5, unit: mtr"),
        "unit: mtr",
        "unit 'mtr': 'mtr' is not a unit known here",
        "write it like N.s/m or kg.m2",
    ),
    "parameter value": (
        ("value: 3.5", "value: .inf"),
        "value: .inf",
        "expected a finite number, got inf",
        "",
    ),
    "undeclared name": (
        ("mass: 0.5*m", "mass: 0.5*mm"),
        "mass: 0.5*mm",
        "'mm' is not declared",
        "did you mean 'm'?",
    ),
    "grammar": (
        ("inertia: m*L**2/12", "inertia: m*L^2/12"),
        "inertia: m*L^2",
        "'^' has no meaning here; write ** for a power (column 4 of 'm*L^2/12')",
        "allowed: numbers, names, + - * / **, functions",
    ),
    "function": (
        ("stiffness: 100*m", "stiffness: cube(m)"),
        "stiffness: cube",
        "cube is not a function here; known: abs, acos, asin, atan, atan2, cos, exp, log, max, "
        "min, sign, sin, sqrt, tan, tanh (column 1 of 'cube(m)')",
        "allowed: numbers, names, + - * / **, functions",
    ),
    "infinite number": (
        ("inertia: 1,", "inertia: .inf,"),
        "inertia: .inf",
        "expected a finite number, got inf",
        "allowed: numbers, names, + - * / **, functions",
    ),
    "time in a mass": (
        ("mass: 0.5*m", "mass: m*t"),
        "mass: m*t",
        "'t' is not declared",
        "known names: L, m, pi",
    ),
    "geometry": (
        ("at: [0, -L/2]", "at: [0, -LL/2]"),
        "-LL/2]",
        "'LL' is not declared",
        "did you mean 'L'?",
    ),
    "body of a point": (
        ("body: ground, at", "body: bean, at"),
        "body: bean",
        "unknown body 'bean'",
        "did you mean 'beam'?",
    ),
    "child of a joint": (
        ("child: trolley", "child: troley"),
        "child: troley",
        "unknown body 'troley'",
        "did you mean 'trolley'?",
    ),
    "ground as a child": (
        ("child: trolley", "child: ground"),
        "child: ground",
        "unknown body 'ground'",
        "known bodies: beam, trolley",
    ),
    "parent of a joint": (
        ("parent: trolley", "parent: grund"),
        "parent: grund",
        "unknown body 'grund'",
        "did you mean 'ground'?",
    ),
    "floating to a body": (
        ("type: revolute, parent: trolley, child: beam, joint_to_child: [0, -L/2]",
         "type: floating, parent: trolley, child: beam"),
        "parent: trolley",
        "a floating joint is always to the ground",
        "leave 'parent' out",
    ),
    "floating with an arm": (
        ("type: revolute, parent: trolley, child: beam", "type: floating, child: beam"),
        "joint_to_child",
        "a floating joint has no joint_to_child",
        "give the start position under 'initial': x, z",
    ),
    "prismatic without a direction": (
        (", direction: [1, 0]", ""),
        "rail:",
        "a prismatic joint, and no other, has a direction",
        "add 'direction: [x, z]'",
    ),
    "revolute with a direction": (
        ("type: revolute,", "type: revolute, direction: [1, 0],"),
        "direction: [1, 0], parent",
        "a prismatic joint, and no other, has a direction",
        "leave it out",
    ),
    "coordinate": (
        ("type: revolute,", "type: revolute, coordinate: relativ,"),
        "relativ",
        "unknown coordinate 'relativ'",
        "did you mean 'relative'?",
    ),
    "coordinate of a prismatic joint": (
        ("type: prismatic,", "type: prismatic, coordinate: relative,"),
        "coordinate: relative",
        "only a revolute joint has a coordinate to choose",
        "leave it out",
    ),
    "start value of a fixed joint": (
        ("type: revolute, parent: trolley,", "type: fixed, initial: {q: 1}, parent: trolley,"),
        "q: 1",
        "a fixed joint has no initial 'q'",
        "leave it out",
    ),
    "direction": (
        ("direction: [1, 0]", "direction: [1, LL]"),
        "LL]",
        "'LL' is not declared",
        "did you mean 'L'?",
    ),
    "key of initial": (
        ("u: -0.5", "v: -0.5"),
        "v: -0.5",
        "a prismatic joint has no initial 'v'",
        "known: q, u",
    ),
    "value of initial": (
        ("u: -0.5", "u: -0.5*x"),
        "u: -0.5*x",
        "'x' is not declared",
        "known names: L, m, pi",
    ),
    "body of a load": (
        ("body_force, body: beam", "body_force, body: bem"),
        "body: bem",
        "unknown body 'bem'",
        "did you mean 'beam'?",
    ),
    "a force on the ground": (
        ("body_force, body: beam", "body_force, body: ground"),
        "body: ground, force",
        "unknown body 'ground'",
        "known bodies: beam, trolley",
    ),
    "point of a load": (
        ("point: tip", "point: top"),
        "point: top",
        "unknown point 'top'",
        "did you mean 'tip'?",
    ),
    "end of a spring": (
        ("tension_spring, points: [wall, tip]", "tension_spring, points: [wall, beam]"),
        "beam], stiffness",
        "unknown point 'beam'",
        "known points: tip, wall",
    ),
    "end of a torsion damper": (
        ("bodies: [trolley, beam]", "bodies: [trolley, tip]"),
        "tip], damping",
        "unknown body 'tip'",
        "known bodies: beam, ground, trolley",
    ),
    "both ends the same": (
        ("tension_damper, points: [wall, tip]", "tension_damper, points: [tip, tip]"),
        "points: [tip, tip]",
        "both ends are 'tip'",
        "name two points",
    ),
    "quantity of a load": (
        ("length: L", "length: T"),
        "length: T",
        "'T' is not declared",
        "known names: L, m, pi, t",
    ),
    "name": (
        ("  lift:", "  2lift:"),
        "2lift",
        "'2lift' cannot be a name",
        "use letters, digits and _, a letter first",
    ),
    "name with a line end": (
        ("  lift:", '  "lift\\n":'),
        '"lift',
        "'lift\\n' cannot be a name",
        "use letters, digits and _, a letter first",
    ),
    "a body called ground": (
        ("  trolley: {mass", "  ground: {mass: 1, inertia: 1}\n  trolley: {mass"),
        "ground: {mass",
        "'ground' is the name of the world",
        "rename this body",
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "place", "message", "remedy"), ELEMENT_CHECKS.values(), ids=ELEMENT_CHECKS
)
def test_checks_of_elements(change: tuple[str, str], place: str, message: str, remedy: str) -> None:
    (problem,) = problems(changed(change))
    assert (problem.message, problem.remedy) == (message, remedy)
    assert problem.source[problem.column - 1 :].startswith(place)
    assert problem.file == "crane.model.yaml"


@pytest.mark.parametrize("name", ["t", "pi", "sin", "time", "Theta_1", "SD_2", "XDD_10", "A_1_2"])
def test_parameters_cannot_take_a_name_with_a_meaning(name: str) -> None:
    (problem,) = problems(
        changed(("  L: {value", f"  {name}: {{value: 1, unit: m}}\n  L: {{value"))
    )
    assert problem.message == f"{name!r} already has a meaning in expressions"
    assert problem.remedy == "rename this parameter"
    assert problem.source.startswith(f"  {name}:")


WHOLE_CHECKS = {
    "nothing moves": (
        [
            (
                "type: prismatic, child: trolley, direction: [1, 0], initial: {q: 2*L, u: -0.5}",
                "type: fixed, child: trolley",
            ),
            ("type: revolute, parent", "type: fixed, parent"),
        ],
        "joints:",
        "nothing can move: every joint is fixed",
        "give at least one joint another type",
    ),
    "child twice": (
        [("\npoints:", "  second: {type: revolute, child: beam}\n\npoints:")],
        "child: beam}",
        "body 'beam' is the child of 'hinge' already",
        "closed loops: cut one joint and put a stiff spring and damper in its place",
    ),
    "no joint": (
        [("\njoints:", "  loose: {mass: 1, inertia: 1}\n\njoints:")],
        "loose:",
        "body 'loose' has no joint",
        "add a joint with this child (type: floating, if it is free)",
    ),
    "mass": (
        [("mass: 0.5*m", "mass: m - 2000")],
        "mass: m - 2000",
        "must be positive, got 0",
        "give a positive mass",
    ),
    "inertia": (
        [("inertia: 1,", "inertia: -1,")],
        "inertia: -1",
        "must be positive, got -1",
        "give a positive inertia",
    ),
    "mass that cannot be computed": (
        [("mass: 0.5*m", "mass: sqrt(-m)")],
        "mass: sqrt",
        "cannot be computed: math domain error",
        "",
    ),
    "complex power": (
        [("mass: 0.5*m", "mass: (-m)**0.5")],
        "mass: (-m)",
        "cannot be computed: math domain error",
        "",
    ),
    "start value that cannot be computed": (
        [("q: 2*L", "q: 1/(L - 3.5)")],
        "q: 1/(L",
        "cannot be computed: float division by zero",
        "",
    ),
    "length that is not finite": (
        [("length: L", "length: 1e200*1e200")],
        "length: 1e200",
        "must be finite, got inf",
        "",
    ),
    "direction that cannot be computed": (
        [("direction: [1, 0]", "direction: [1/(L - 3.5), 0]")],
        "1/(L - 3.5)",
        "cannot be computed: float division by zero",
        "",
    ),
    "direction without a length": (
        [("direction: [1, 0]", "direction: [L - 3.5, 0]")],
        "direction: [L",
        "the direction has no length",
        "give a vector such as [1, 0]",
    ),
}


@pytest.mark.parametrize(
    ("changes", "place", "message", "remedy"), WHOLE_CHECKS.values(), ids=WHOLE_CHECKS
)
def test_checks_of_the_whole(
    changes: list[tuple[str, str]], place: str, message: str, remedy: str
) -> None:
    (problem,) = problems(changed(*changes))
    assert (problem.message, problem.remedy) == (message, remedy)
    assert problem.source[problem.column - 1 :].startswith(place)


def test_a_ring_of_bodies_hangs_on_nothing() -> None:
    found = problems(
        "name: ring\n"
        "bodies:\n  a: {mass: 1, inertia: 1}\n  b: {mass: 1, inertia: 1}\n"
        "joints:\n  j: {type: revolute, parent: b, child: a}\n"
        "  k: {type: revolute, parent: a, child: b}\n"
    )
    assert [(p.line, p.message) for p in found] == [
        (3, "body 'a' is not connected to the ground"),
        (4, "body 'b' is not connected to the ground"),
    ]
    assert found[0].remedy == "one body of this chain must have a joint with parent: ground"


def test_a_model_needs_a_body() -> None:
    (problem,) = problems("name: nothing\n")
    assert problem.message == "a model needs at least one body"
    assert problem.remedy == "add one under 'bodies'"


def test_all_problems_of_a_file_at_once() -> None:
    """Unknown keys, wrong types, missing names and wrong references, in order of place."""
    text = changed(
        ("name: crane\n", ""),
        ("unit: m}", "unit: mtr}"),
        ("mass: m,", "mas: m,"),
        ("type: revolute", "type: revolut"),
        ("points: [wall, tip], stiffness: 100*m", "points: [wall, top], stiffness: true"),
        ("moment: -t", "moment: -tt"),
    )
    assert [p.message for p in problems(text)] == [
        "missing key 'name'",
        "unit 'mtr': 'mtr' is not a unit known here",
        "missing key 'mass'",
        "unknown key 'mas'",
        "unknown type 'revolut'",
        "expected a number or an expression, got True",
        "'tt' is not declared",
    ]


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
                "joints.hinge.joint_to_child: expected two entries, got (1.0,)",
            ),
            (
                lambda: Joint("floating", "beam", parent_to_joint=3.0),  # pyright: ignore[reportArgumentType]
                "joints.hinge.parent_to_joint: expected two entries, got 3.0",
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
