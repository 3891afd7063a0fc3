"""`m4e-fmi decay`: tables, results, pictures; mistakes are in tests/corpus/decay.yaml."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

Said = Callable[..., str]
TIME = np.arange(0.0, 40.0, 0.1)
RATIO, OMEGA = 0.05, 2.0 * math.pi / 5.0
DAMPED = OMEGA * math.sqrt(1 - RATIO**2)
MOTION = np.exp(-RATIO * OMEGA * TIME) * (
    np.cos(DAMPED * TIME) + RATIO * OMEGA / DAMPED * np.sin(DAMPED * TIME)
)
MODEL = """
name: buoy
bodies: {float: {mass: 2000, inertia: 1}}
joints: {rail: {type: prismatic, child: float, direction: [0, 1], initial: {q: 0.5}}}
loads:
  spring: {type: joint_effort, joint: rail, effort: -8000*joint.rail.q}
  water: {type: joint_effort, joint: rail, effort: -900*abs(joint.rail.u)*joint.rail.u}
gravity: 0
"""


def table(folder: Path, header: str, factor: float = 1.0) -> Path:
    path = folder / "tank.csv"
    lines = [f"{t:.6f},{factor * x:.12g}" for t, x in zip(TIME, MOTION, strict=True)]
    path.write_text("\n".join([header, *lines]), encoding="utf-8")
    return path


def test_a_table(tmp_path: Path, said: Said) -> None:
    path, picture = table(tmp_path, "time [s],heave [mm]", 1e3), tmp_path / "p.png"
    text = said("decay", path, "--mass", "3e5", "--output-file", picture)
    assert "tank.csv, heave [m]: free decay from 2.6 to 39.9 s, from the first peak after" in text
    assert picture.is_file()
    found = json.loads(said("decay", path, "--mass", "3e5", "--json", "--no-plot"))
    values = {name: one["value"] for name, one in found["values"].items()}
    # the rows have 12 digits
    assert values["period"] == pytest.approx(5.0, rel=1e-6)
    assert values["damping_ratio"] == pytest.approx(RATIO, abs=1e-6)
    assert values["linear_coefficient"] == pytest.approx(2 * RATIO * OMEGA * 3e5, rel=1e-5)
    assert found["motion"] == "heave"
    assert found["values"]["rest"]["unit"] == "m"
    path = table(tmp_path, "time,heave")
    assert "says no unit: taken as m" in said("decay", path, "--no-plot")


def test_degrees_are_converted(tmp_path: Path, said: Said) -> None:
    path = table(tmp_path, "t,angles of pitch [deg]", 10.0)
    found = json.loads(said("decay", path, "--json", "--no-plot"))
    assert found["release"] == pytest.approx(math.radians(10.0), rel=1e-3)
    assert found["values"]["quadratic"]["unit"] == "1/rad"


def test_the_coefficient_of_a_simulated_model(tmp_path: Path, said: Said) -> None:
    """Quadratic damping of a simulated model comes back as its coefficient."""
    model, file = tmp_path / "buoy.model.yaml", tmp_path / "buoy.nc"
    model.write_text(MODEL, encoding="utf-8")
    run = ["--stop-time", "30", "--output-interval", "0.05", "--no-plot", "--output-file", file]
    said("simulate", model, *run)
    given = ["--variable", "buoy.body.float.z", "--mass", "2000", "--no-plot"]
    found = json.loads(said("decay", file, *given, "--json"))
    drag = found["values"]["quadratic_coefficient"]["value"]
    assert drag == pytest.approx(900.0, rel=1e-4)
