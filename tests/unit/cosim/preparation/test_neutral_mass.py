"""A body whose mass is that of the water it displaces: `mass: neutral`, in a model by itself."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, trajectory_sensitivity
from m4e_fmi.cli import main
from m4e_fmi.errors import InputError
from m4e_fmi.model import Body, Joint, Model, load_model
from m4e_fmi.multibody import Equations, model_program
from m4e_fmi.report import draw_model
from m4e_fmi.runtime.engine import Engine
from m4e_fmi.simulate import simulate

TEXT = """\
name: buoy
gravity: 9.81
bodies: {float: {mass: neutral, inertia: 1e6, added_mass: true}}
joints: {sea: {type: floating, child: float, initial: {z: -1.0, vx: 2}}}
loads: {spring: {type: body_force, body: float, force: [-100e3*body.float.x, 0]}}
"""
MASS = "body.float.neutral_mass"


@pytest.fixture
def buoy(tmp_path: Path) -> Path:
    path = tmp_path / "buoy.model.yaml"
    path.write_text(TEXT)
    return path


def test_the_mass_is_a_parameter_without_a_value(buoy: Path) -> None:
    program = model_program(buoy)
    (mass,) = (v for v in program.parameters if v.name == MASS)
    assert (mass.unit, mass.start, mass.minimum) == ("kg", 0.0, 0.0)
    engine = Engine(program)
    assert np.isnan(engine.rates(0.0, [v.start for v in program.states])).any()


def test_with_a_value_it_moves_as_one_of_that_mass(buoy: Path) -> None:
    """To the bit."""
    known = buoy.with_name("known.model.yaml")
    known.write_text(
        TEXT.replace("mass: neutral", "mass: m") + "parameters: {m: {value: 98765.4, unit: kg}}"
    )
    wanted = simulate(known, stop_time=2.0)
    found = simulate(buoy, stop_time=2.0, start_values={MASS: "98.7654 t"})
    assert np.array_equal(found["body.float.x"].values, wanted["body.float.x"].values)


def test_without_a_value_it_is_refused_in_place(
    buoy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    uses = (
        lambda: simulate(buoy, stop_time=1.0),
        lambda: equilibrium(buoy),
        lambda: linearize(buoy),
        lambda: trajectory_sensitivity(buoy, of=["body.float.x"], by=[MASS], stop_time=1.0),
    )
    for use in uses:
        with pytest.raises(InputError) as caught:
            use()
        (problem,) = caught.value.problems
        assert (problem.file, problem.line) == (str(buoy), 3)
        assert f"{MASS} has no value" in problem.message
        assert f"--start-value {MASS} '120 t'" in problem.remedy
    with pytest.raises(InputError, match=f"buoy: {MASS} has no value"):
        simulate(model_program(buoy), stop_time=1.0)
    assert main(["simulate", str(buoy), "--stop-time", "1", "--no-plot"]) == 2
    assert "buoy.model.yaml:3:" in capsys.readouterr().err


def test_equations_keep_it_as_a_symbol(buoy: Path) -> None:
    equations = Equations(load_model(buoy))
    assert str(equations.mass_matrix[0, 0]) == "A_1_1 + neutral_mass_float"
    scope: dict = {}
    exec(equations.code(), scope)  # our own text
    assert np.isnan(scope["equations"](0.0, [0.0] * 3, [0.0] * 3)[0]).any()
    M, _ = scope["equations"](0.0, [0.0] * 3, [0.0] * 3, (5.0, *[0.0] * 9))
    assert M[0, 0] == 5.0


def test_it_is_drawn_without_a_value(buoy: Path) -> None:
    assert draw_model(load_model(buoy), buoy.with_name("buoy.png")).is_file()


def test_its_fmu_says_that_a_value_is_missing(
    buoy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["build", str(buoy), "--build-folder", str(buoy.parent)]) == 0
    assert f"note: {MASS} has no value" in capsys.readouterr().out
    with ZipFile(buoy.with_name("buoy.fmu")) as archive:
        page = archive.read("documentation/index.html").decode()
        assert "documentation/buoy_ref.csv" not in archive.namelist()
    assert f"no reference series, because {MASS} has no value" in page


@pytest.mark.parametrize(
    ("old", "new", "message", "remedy"),
    [
        ("inertia: 1e6", "inertia: 4*neutral", "not known in expressions", "declare a parameter"),
        ("mass: neutral", "mass: 0.9*neutral", "not known in expressions", "declare a parameter"),
        ("inertia: 1e6", "inertia: neutral", "not known in expressions", "declare a parameter"),
        ("inertia: 1e6", f"inertia: 4*{MASS}", "is not known here", "only loads"),
        ("mass: neutral", "mass: Neutral", "'Neutral' is not known", "write 'mass: neutral'"),
    ],
)
def test_nothing_else_is_neutral(buoy: Path, old: str, new: str, message: str, remedy: str) -> None:
    buoy.write_text(TEXT.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_model(buoy)
    (problem,) = caught.value.problems
    assert problem.line == 3
    assert message in problem.message
    assert remedy in problem.remedy


@pytest.mark.parametrize("name", ["neutral", "neutral_mass_float"])
def test_its_names_are_taken(buoy: Path, name: str) -> None:
    """Of a model without such a body they are free."""
    more = f"parameters: {{{name}: {{value: 3, unit: kg}}}}"
    buoy.write_text(TEXT + more)
    with pytest.raises(InputError, match="already has a meaning"):
        load_model(buoy)
    buoy.write_text(TEXT.replace("mass: neutral", f"mass: {name}*2") + more)
    assert load_model(buoy).lacking == {}


def test_from_python() -> None:
    model = Model("buoy", {"float": Body("neutral", 1e6)}, {"sea": Joint("floating", "float")})
    with pytest.raises(InputError, match=r"bodies.float.mass: .* has no value"):
        simulate(model, stop_time=1.0)
    assert simulate(model, stop_time=0.1, start_values={MASS: 5.0})["body.float.z"][-1] < 0
