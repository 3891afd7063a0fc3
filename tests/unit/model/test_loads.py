"""Loads and tables: the same from YAML and Python, and everything that can be wrong with them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.flap_file import TEXT, WAVE
from support.programs import Evaluated

from m4e_fmi.cli import main
from m4e_fmi.cosim import Component, ModelFile, Simulation, System, fmu_files
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document
from m4e_fmi.model import (
    Body,
    BodyDrag,
    BodyForce,
    Joint,
    JointEffort,
    JointFriction,
    JointStop,
    Model,
    Parameter,
    Point,
    PointDrag,
    PointForce,
    Table,
    TensionDamper,
    TensionSpring,
    TensionStop,
    TorsionDamper,
    TorsionSpring,
    load_model,
)
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program


def flap() -> Model:
    ends, bodies = ("tip", "wall"), ("hull", "flap")
    return Model(
        name="flap",
        parameters={"k": Parameter(100, "N/m"), "c": Parameter(5, "kg/m")},
        tables={
            "gust": Table((0.0, 1.0, 2.5), (0.0, 0.4, 0.0), "kN", "Wind"),
            "wave": Table((0.0, 2.0, 5.5), (1.5, -1.5, 0.0)),
        },
        bodies={"hull": Body(5, 1), "flap": Body(2, 1)},
        joints={
            "sea": Joint("floating", "hull"),
            "hinge": Joint(
                "revolute", "flap", "hull", joint_to_child=(0, -1), coordinate="relative"
            ),
        },
        points={"tip": Point("flap", (0, -1)), "wall": Point("ground", (9, 0))},
        loads={
            "rope": TensionSpring(ends, length=3, law="k*l + 2*ld"),
            "valve": TensionDamper(ends, law="3*abs(ld)*ld"),
            "slack": TensionStop(ends, "k", upper=8),
            "coil": TorsionSpring(bodies, law="sin(theta)"),
            "oil": TorsionDamper(bodies, law="tanh(thetad)"),
            "blow": PointForce("tip", ("gust", 0), "body"),
            "lift": BodyForce("hull", (0, "-k*body.hull.z"), "wave"),
            "sail": PointDrag("tip", "c", ("point.tip.vx/2", 0)),
            "keel": BodyDrag("hull", "c", 2),
            "motor": JointEffort("hinge", "-3*joint.hinge.u"),
            "rub": JointFriction("hinge", 2, 0.01),
            "end": JointStop("hinge", 90, "-pi/2", "pi/2", 3),
        },
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "wave.csv").write_text(WAVE)
    return tmp_path


def test_yaml_and_python_give_the_same(folder: Path) -> None:
    path = folder / "flap.model.yaml"
    path.write_text(TEXT)
    assert load_model(path) == flap()
    assert model_program(path) == model_program(flap())


def test_quantities_may_be_expressions_of_sympy() -> None:
    import sympy

    k, extension, z = sympy.symbols("k l body.hull.z")
    model = flap()
    rope = TensionSpring(("tip", "wall"), length=3, law=k * extension + extension**3)
    lift = BodyForce("hull", (0, -k * z), "wave")
    text = TensionSpring(("tip", "wall"), length=3, law="k*l + l**3")
    made, written = (
        model_program(_with(model, rope=spring, lift=force))
        for spring, force in ((rope, lift), (text, model.loads["lift"]))
    )
    values = {v.name: 0.1 * k for k, v in enumerate(made.states)}
    assert Evaluated(made).rates(values) == pytest.approx(Evaluated(written).rates(values))


def _with(model: Model, **loads: Any) -> Model:
    fields = {name: getattr(model, name) for name in model.__dataclass_fields__}
    return Model(**{**fields, "loads": {**model.loads, **loads}})


def problems(text: str, folder: Path) -> list[Problem]:
    with pytest.raises(InputError) as caught:
        model_of(Document.parse(text, folder / "flap.model.yaml"))
    return caught.value.problems


CHECKS = {
    "body of an expression": (
        ("body.hull.z", "body.hul.z"),
        "-k*body",
        "unknown body 'hul' in 'body.hul.z'",
        "did you mean 'hull'?",
    ),
    "variable of an expression": (
        ("body.hull.z", "body.hull.az"),
        "-k*body",
        "a load cannot depend on 'body.hull.az'",
        "nor on any other acceleration or reaction",
    ),
    "coordinate of a floating joint": (
        ("joint.hinge.u", "joint.sea.u"),
        "effort: -3",
        "'sea' is a floating joint and has no u",
        "use the motion of its body: body.hull.x, theta, vx, …",
    ),
    "a name with dots that means nothing": (
        ("joint.hinge.u", "hinge.u"),
        "effort: -3",
        "'hinge.u' is not declared",
        "did you mean 'joint.hinge.u'?",
    ),
    "variable of a law elsewhere": (
        ("stiffness: k, upper", "stiffness: k*theta, upper"),
        "stiffness: k*theta",
        "'theta' is not declared",
        "known names: c, gust, k, pi, t, wave",
    ),
    "parameter with the name of a variable": (
        ("  k: {value", "  l: {value: 1, unit: m}\n  k: {value"),
        "law: k*l",
        "'l' is what the law depends on, and also a parameter or table",
        "rename the parameter or table",
    ),
    "neither law nor damping": (
        (", law: tanh(thetad)", ""),
        "oil:",
        "expected one of 'damping' and 'law', got 0",
        "add 'damping: …' here",
    ),
    "grammar of a law": (
        ("law: sin(theta)", "law: sin(theta"),
        "law: sin",
        "something is missing at the end (column 9 of 'sin(theta')",
        "allowed: numbers without a unit, names, + - * / **, functions",
    ),
    "joint of a load": (
        ("joint_stop, joint: hinge", "joint_stop, joint: hing"),
        "joint: hing,",
        "unknown joint 'hing'",
        "did you mean 'hinge'?",
    ),
    "times and values": (
        ("values: [0, 0.4, 0]", "values: [0, 0.4]"),
        "gust:",
        "3 times, but 2 values",
        "give one value for each time",
    ),
    "one row": (
        ("times: [0, 1, 2.5], values: [0, 0.4, 0]", "times: [0], values: [0]"),
        "gust:",
        "expected 2 to 10000 rows, got 1",
        "a value that does not change is a parameter",
    ),
    "value that is not finite": (
        ("0.4", ".nan"),
        "gust:",
        "row 2 of values: expected a finite number, got nan",
        "",
    ),
    "unit of a table": (
        ("unit: kN,", "unit: kn2x,"),
        "unit: kn2x",
        "unit 'kn2x': 'kn2x' is not a unit",
        "write it like N.s/m or kg.m2",
    ),
    "name of a table": (
        ("gust: {times: [0, 1, 2.5]", "c: {times: [0, 1, 2.5]"),
        "c: {times",
        "'c' is also a parameter",
        "rename one of the two",
    ),
    "neither numbers nor a file": (
        ("file: wave.csv, columns: [time, height]", "unit: N"),
        "wave:",
        "expected numbers or a file",
        "give 'times' and 'values', or the 'file' of a table",
    ),
    "file": (
        ("file: wave.csv", "file: wav.csv"),
        "file: wav",
        "wav.csv: no such file",
        "did you mean 'wave.csv'?",
    ),
    "column": (
        ("columns: [time, height]", "columns: [time, hight]"),
        "columns:",
        "wave.csv, line 1: no column 'hight'",
        "did you mean 'height'?",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("change", "place", "message", "remedy"), CHECKS.values(), ids=CHECKS)
def test_checks(
    change: tuple[str, str], place: str, message: str, remedy: str, folder: Path
) -> None:
    old, new = change
    assert TEXT.count(old) == 1
    found = problems(TEXT.replace(old, new), folder)
    if old.startswith("gust:"):  # what used the name is reported, too
        found = found[:1]
    (problem,) = found
    assert (problem.message, problem.remedy) == (message, remedy)
    assert problem.source[problem.column - 1 :].startswith(place)


@pytest.mark.parametrize(
    ("content", "message", "remedy"),
    [
        ("", "wave.csv: has no two columns", "separate them by commas, names first"),
        (
            "time\n1\n2\n",
            "wave.csv, line 1: has no two columns",
            "separate them by commas, names first",
        ),
        (
            "time,height\n0,1\n1,x\n",
            "wave.csv, line 3: expected a finite number in column 'height', got 'x'",
            "",
        ),
        (
            "time,height\n0,1\n1\n",
            "wave.csv, line 3: expected a finite number in column 'height', got nothing",
            "",
        ),
        ("time,height\n0,1\n", "expected 2 to 10000 rows, got 1", None),
        (
            "time,height\n0,1\n1,inf\n",
            "wave.csv, line 3: expected a finite number in column 'height', got 'inf'",
            "",
        ),
        (b"\xff\xfe\x00\x01", "wave.csv: cannot be read: ", None),
    ],
)
def test_files_of_tables(
    content: str | bytes, message: str, remedy: str | None, folder: Path
) -> None:
    data = content.encode() if isinstance(content, str) else content
    (folder / "wave.csv").write_bytes(data)
    (problem,) = problems(TEXT, folder)
    assert problem.message.startswith(message)
    if remedy is not None:
        assert problem.remedy == remedy
    assert "wave" in problem.source


def test_a_folder_is_no_table(folder: Path) -> None:
    (folder / "wave.csv").unlink()
    (folder / "wave.csv").mkdir()
    (problem,) = problems(TEXT, folder)
    assert problem.message == "wave.csv: no such file"


def test_the_first_two_columns_are_the_default(folder: Path) -> None:
    text = TEXT.replace(", columns: [time, height]", "")
    (folder / "flap.model.yaml").write_text(text)
    model = load_model(folder / "flap.model.yaml")
    assert model.tables["wave"] == Table((0.0, 2.0, 5.5), (7.0, 8.0, 9.0))


def test_python_models_get_the_checks_of_files() -> None:
    wrong: Any = "bodi"
    loads = {
        "rope": TensionSpring(("tip", "wall"), 3.0),
        "blow": PointForce("tip", (0, 0), wrong),
        "coil": TorsionSpring(("hull", "flap")),
    }
    model = flap()
    fields = {name: getattr(model, name) for name in model.__dataclass_fields__}
    with pytest.raises(InputError) as caught:
        Model(**{**fields, "loads": loads})
    assert [problem.message for problem in caught.value.problems] == [
        "loads.rope: missing key 'length'",
        "loads.blow.axes: unknown axes 'bodi'",
        "loads.coil: expected one of 'stiffness' and 'law', got 0",
    ]


DRIVEN = """\
name: driven
parameters:
  k: {value: -2, unit: kN/m}
bodies:
  a: {mass: 1, inertia: 1}
joints:
  j: {type: floating, child: a}
points:
  p: {body: a, at: [0, 0]}
  g: {body: ground, at: [1, 0]}
loads:
  b: {type: bushing, points: [p, g], stiffness: k, damping: 3}
  d: {type: tension_damper, points: [p, g], damping: -4}
  s: {type: torsion_spring, bodies: [ground, a], stiffness: 5}
"""


@pytest.mark.parametrize(("gravity", "count"), [("9.81", 0), ("-9.81", 1), ("[0, 0, -9.81]", 0)])
def test_gravity_that_lifts_is_warned_of(tmp_path: Path, gravity: str, count: int) -> None:
    """A number acts along −Z; in space a vector has its direction."""
    space = ("dimensions: 3\n", "[1, 1, 1]") if "[" in gravity else ("", "1")
    text = (
        f"name: up\n{space[0]}gravity: {gravity}\nbodies: {{a: {{mass: 1, inertia: {space[1]}}}}}\n"
    )
    path = tmp_path / "up.model.yaml"
    path.write_text(text + "joints: {j: {type: floating, child: a}}\n", encoding="utf-8")
    found = load_model(path).warnings
    assert len(found) == count
    for warning in found:
        assert warning.line == 2
        assert warning.message == "negative gravity, -9.81 m/s2: it lifts all bodies"
        assert warning.remedy == "give 9.81: what is positive acts along -Z"


def test_negative_stiffness_and_damping_are_warned_of(tmp_path: Path) -> None:
    path = tmp_path / "driven.model.yaml"
    path.write_text(DRIVEN)
    model = load_model(path)
    stiffness, damping = model.warnings
    assert (stiffness.file, stiffness.line, stiffness.column) == (str(path), 12, 38)
    assert stiffness.message == (
        "negative stiffness, -2000: the load pushes away from where it rests"
    )
    assert (damping.line, damping.column) == (13, 45)
    assert damping.message == "negative damping, -4: the load drives the motion"
    # in Python by name, and of a changed model anew
    loads = {"b": replace(model.loads["b"], damping=-3.0)}
    changed = replace(model, loads=loads, parameters={"k": Parameter(1.0, "N/m")})
    (found,) = changed.warnings
    assert str(found).startswith("driven: loads.b.damping: negative damping, -3")
    assert replace(changed, loads={}).warnings == ()


def test_the_build_of_a_system_tells_warnings_of_a_model_each_time(tmp_path: Path) -> None:
    (tmp_path / "driven.model.yaml").write_text(DRIVEN)
    parts = (Component("body", ModelFile(tmp_path / "driven.model.yaml")),)
    system = System("s", parts, (), Simulation(1.0, 0.1), folder=tmp_path)
    for _ in range(2):
        told: list[str] = []
        fmu_files(system, tmp_path / "build", native=False, tell=told.append)
        warned = [text for text in told if text.startswith("body: warning: ")]
        assert len(warned) == 2
        assert "driven.model.yaml:12:38: negative stiffness, -2000" in warned[0]


def test_commands_warn_of_a_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "driven.model.yaml"
    path.write_text(DRIVEN)
    assert main(["info", str(path)]) == 0
    assert "driven.model.yaml:13:45: negative damping, -4" in capsys.readouterr().err


def test_a_parameter_that_is_a_drag_coefficient_has_a_minimum() -> None:
    model = replace(
        flap(),
        loads={"drag": PointDrag("tip", "c")},
        parameters={**flap().parameters, "c": Parameter(3.0, "kg/m")},
    )
    (c,) = [p for p in model_program(model).parameters if p.name == "c"]
    assert c.minimum == 0.0


def test_a_force_in_space_needs_no_moment(tmp_path: Path) -> None:
    path = tmp_path / "push.model.yaml"
    path.write_text(
        "name: push\ndimensions: 3\ngravity: 0\nbodies: {a: {mass: 2, inertia: [1, 1, 1]}}\n"
        "joints: {f: {type: floating, child: a}}\n"
        "loads: {push: {type: body_force, body: a, force: [4, 0, 6]}}\n"
    )
    rates = Evaluated(model_program(load_model(path))).rates({})
    found = [rates[f"body.a.{name}"] for name in ("vx", "vy", "vz", "omega_x", "omega", "omega_z")]
    assert found == [2.0, 0.0, 3.0, 0.0, 0.0, 0.0]
