"""Start values of models in space: attitudes by angles, and numbers that become wrong by them."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.analysis import linearize
from m4e_fmi.errors import InputError
from m4e_fmi.model import Model, load_model
from m4e_fmi.simulate import simulate

MODEL = """
name: arm
dimensions: 3
gravity: 0
parameters:
  tilt: {value: 1, unit: "1"}
  reach: {value: 1, unit: m}
  Izz: {value: 0.1, unit: kg.m2}
  Ixy: {value: 0, unit: kg.m2}
bodies:
  a: {mass: 2, inertia: [0.1, 0.1, Izz, Ixy, 0, 0]}
  ship: {mass: 1, inertia: [1, 1, 1]}
joints:
  j: {type: revolute, child: a, axis: [0, tilt, 0], joint_to_child: [reach, 0, 0]}
  free: {type: floating, child: ship, initial: {phi: 0.1, psi: 0.3}}
"""


@pytest.fixture
def model(tmp_path: Path) -> Model:
    path = tmp_path / "arm.model.yaml"
    path.write_text(MODEL)
    return load_model(path)


def test_attitudes_start_at_angles(model: Model) -> None:
    """In SI or with a unit; those that are not given stay as the file has them."""
    given = {"body.ship.theta": "20 deg", "body.ship.psi": -0.7}
    result = simulate(model, stop_time=0.1, start_values=given)
    angles = [result[f"body.ship.{angle}"][0] for angle in ("phi", "theta", "psi")]
    assert angles == pytest.approx([0.1, 0.3490658503988659, -0.7], abs=1e-15)
    point = linearize(model, at={"body.ship.theta": "20 deg"}).point
    names = [f"body.ship.e{k}" for k in range(4)]
    there = simulate(model, stop_time=0.1, start_values={n: point[n] for n in names})
    assert there["body.ship.theta"][0] == pytest.approx(0.3490658503988659, abs=1e-15)


def test_attitudes_given_twice_or_as_nothing(model: Model) -> None:
    with pytest.raises(InputError, match=r"an attitude is given twice: body\.ship\.e1 is given"):
        simulate(model, stop_time=1, start_values={"body.ship.theta": 1, "body.ship.e1": 0.2})
    nothing = dict.fromkeys((f"body.ship.e{k}" for k in range(4)), 0.0)
    with pytest.raises(InputError, match=r"body\.ship\.e0 to e3 are all 0") as error:
        simulate(model, stop_time=1, start_values=nothing)
    assert "give body.ship.phi" in error.value.problems[0].remedy
    with pytest.raises(InputError, match=r"has no parameter, input or state 'body\.a\.theta'"):
        simulate(model, stop_time=1, start_values={"body.a.theta": 1})


@pytest.mark.parametrize(
    ("given", "line", "message"),
    [
        ({"tilt": 0}, 14, r"the axis has no length \(with tilt = 0\)"),
        ({"Izz": 0.3}, 11, "no body has these moments of inertia"),
        ({"Ixy": 0.2}, 11, "principal moments of inertia must be positive"),
        ({"reach": 1e120}, 14, "is out of all scale"),
    ],
)
def test_numbers_that_become_wrong(
    model: Model, given: dict[str, float], line: int, message: str
) -> None:
    with pytest.raises(InputError, match=message) as error:
        simulate(model, stop_time=1, start_values=given)
    assert error.value.problems[0].line == line
    with pytest.raises(InputError, match=message):
        linearize(model, at=given)
