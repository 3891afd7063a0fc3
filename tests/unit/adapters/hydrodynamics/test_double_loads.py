"""Loads on one body that a hull's pressure and linear hydrodynamics would both make."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.input_checks.inputs import checked_inputs

MODEL = """\
name: buoy
bodies: {float: {mass: 150e3, inertia: 1e6, added_mass: true}}
joints: {sea: {type: floating, child: float, initial: {z: -1.2}}}
"""
SYSTEM = """\
name: buoy
components:
  buoy: {{model: buoy.model.yaml}}
  hull:
    kind: hull_pressure
    bodies:
      float: {{shape: {shape}, center_of_gravity: [0, -1.2]}}
    waves: {waves}
  water:
    kind: hydrodynamics
    bodies:
      float: {{shape: {shape}, center_of_gravity: [0, -1.2], panels: 100{drift}}}
    loads: {{{loads}}}
    waves: {waves}
connections: [buoy.body.float.z -> hull.float.z, buoy.body.float.z -> water.float.z]
simulation: {{stop_time: 1, step_size: 0.1}}
"""
SHAPE = "{cylinder: {radius: 4, draft: 3, freeboard: 2}}"
ONE = "{spectrum: regular, height: 1, period: 7, ramp_time: 0}"
TWO = f"[{ONE}, {{spectrum: regular, height: 0.5, period: 9, ramp_time: 0}}]"
COMPONENTS = "{spectrum: components, components: [{amplitude: 0.5, period: 7}], ramp_time: 0}"
OFF = "hydrostatics: none, froude_krylov: none"


def told(folder: Path, *, waves: str, loads: str, drift: str = "") -> list[str]:
    (folder / "buoy.model.yaml").write_text(MODEL, encoding="utf-8")
    rows = "omega,direction,surge\n" + "".join(f"{w},0,{9e3 * w}\n" for w in (0.5, 0.8, 1.1, 1.5))
    (folder / "drift.csv").write_text(rows, encoding="utf-8")
    text = SYSTEM.format(shape=SHAPE, waves=waves, loads=loads, drift=drift)
    (folder / "system.yaml").write_text(text, encoding="utf-8")
    problems, _ = checked_inputs(load_system(folder / "system.yaml"))
    return [problem.message for problem in problems]


@pytest.mark.parametrize("waves", [ONE, TWO, COMPONENTS], ids=["one", "two", "components"])
def test_froude_krylov_counts_once(tmp_path: Path, waves: str) -> None:
    """However the waves are given, whatever parameters they have."""
    (message,) = told(tmp_path, waves=waves, loads="hydrostatics: none")
    assert "froude_krylov of buoy.body.float count twice, in hull.float and water.float" in message
    assert told(tmp_path, waves=waves, loads=OFF) == []


def test_drift_counts_once(tmp_path: Path) -> None:
    (message,) = told(tmp_path, waves=ONE, loads=OFF, drift=", drift: {file: drift.csv}")
    assert "second-order drift of buoy.body.float counts twice" in message
