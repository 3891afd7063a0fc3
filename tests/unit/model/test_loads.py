"""Loads and tables: the same from YAML and Python, warnings; mistakes are in tests/corpus."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.flap_file import TEXT, WAVE

from m4e_fmi.cosim import Component, ModelFile, Simulation, System, fmu_files
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
from m4e_fmi.multibody import model_program
from m4e_fmi.program.python_form import python_source


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
    model = load_model(path)
    assert model == flap()
    assert model.gravity == 9.80665  # where the file gives none
    programs = [model_program(given) for given in (path, str(path), flap())]
    assert programs[0] == programs[1] == programs[2]
    assert python_source(programs[0]) == python_source(programs[2])


def test_the_first_two_columns_are_the_default(folder: Path) -> None:
    text = TEXT.replace(", columns: [time, height]", "")
    (folder / "flap.model.yaml").write_text(text)
    model = load_model(folder / "flap.model.yaml")
    assert model.tables["wave"] == Table((0.0, 2.0, 5.5), (7.0, 8.0, 9.0))


def test_a_parameter_that_is_a_drag_coefficient_has_a_minimum() -> None:
    model = replace(
        flap(),
        loads={"drag": PointDrag("tip", "c")},
        parameters={**flap().parameters, "c": Parameter(3.0, "kg/m")},
    )
    (c,) = [p for p in model_program(model).parameters if p.name == "c"]
    assert c.minimum == 0.0


GOOD = """\
name: a
bodies: {a: {mass: 1, inertia: 1}}
joints: {j: {type: floating, child: a}}
"""
DRIVEN = f"""{GOOD}
parameters: {{k: {{value: -2, unit: kN/m}}}}
points: {{p: {{body: a, at: [0, 0]}}, g: {{body: ground, at: [1, 0]}}}}
loads:
  b: {{type: bushing, points: [p, g], stiffness: k, damping: 3}}
  d: {{type: tension_damper, points: [p, g], damping: -4}}
"""


def test_a_changed_model_is_warned_of_anew(tmp_path: Path) -> None:
    (tmp_path / "a.model.yaml").write_text(DRIVEN)
    model = load_model(tmp_path / "a.model.yaml")
    loads = {"b": replace(model.loads["b"], damping=-3.0)}  # pyrefly: ignore[unexpected-keyword]
    (found,) = replace(model, loads=loads, parameters={"k": Parameter(1.0, "N/m")}).warnings
    assert str(found).startswith("a: loads.b.damping: negative damping, -3")


def test_the_build_of_a_system_tells_warnings_of_a_model_each_time(tmp_path: Path) -> None:
    (tmp_path / "a.model.yaml").write_text(DRIVEN)
    parts = (Component("body", ModelFile(tmp_path / "a.model.yaml")),)
    system = System("s", parts, (), Simulation(1.0, 0.1), folder=tmp_path)
    for _ in range(2):
        told: list[str] = []
        fmu_files(system, tmp_path / "build", native=False, tell=told.append)
        assert sum(text.startswith("body: warning: ") for text in told) == 2
