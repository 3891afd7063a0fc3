"""Start values of models in space: attitudes by angles; wrong ones are in tests/corpus."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.analysis import linearize
from m4e_fmi.model import Model, load_model
from m4e_fmi.simulate import simulate

MODEL = """
name: ship
dimensions: 3
gravity: 0
bodies:
  ship: {mass: 1, inertia: [1, 1, 1]}
joints:
  free: {type: floating, child: ship, initial: {phi: 0.1, psi: 0.3}}
"""


@pytest.fixture
def model(tmp_path: Path) -> Model:
    path = tmp_path / "ship.model.yaml"
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
