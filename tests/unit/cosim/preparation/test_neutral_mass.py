"""A body whose mass is that of the water it displaces: `mass: neutral`, in a model by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cli import main
from m4e_fmi.errors import InputError
from m4e_fmi.model import Body, Joint, Model, load_model
from m4e_fmi.multibody import Equations, model_program
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


def test_equations_keep_it_as_a_symbol(buoy: Path) -> None:
    equations = Equations(load_model(buoy))
    assert str(equations.mass_matrix[0, 0]) == "A_1_1 + neutral_mass_float"


def test_its_fmu_says_that_a_value_is_missing(
    buoy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["build", str(buoy), "--build-folder", str(buoy.parent)]) == 0
    assert f"note: {MASS} has no value" in capsys.readouterr().err


def test_from_python() -> None:
    model = Model("buoy", {"float": Body("neutral", 1e6)}, {"sea": Joint("floating", "float")})
    with pytest.raises(InputError, match=r"bodies.float.mass: .* has no value"):
        simulate(model, stop_time=1.0)
    assert simulate(model, stop_time=0.1, start_values={MASS: 5.0})["body.float.z"][-1] < 0
