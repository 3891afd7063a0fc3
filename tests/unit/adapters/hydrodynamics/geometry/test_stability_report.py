"""The report on stability: numbers of a barge, and what is said where there is no curve."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Box, Sphere
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, sphere_panels
from m4e_adapters.hydrodynamics.stability_report import shell_inertia, solid_inertia
from m4e_fmi.cli import main

BARGE = """
name: yard
components:
  water:
    kind: hydrodynamics
    bodies:
      barge:
        shape: {box: {length: 24, width: 12, draft: 2, freeboard: 1.5}}
        center_of_gravity: [0, 1]
      spar: {shape: {cylinder: {radius: 3, draft: 9, center_x: -40}}, center_of_gravity: [-40, -5]}
    waves: {spectrum: still}
simulation: {stop_time: 1, step_size: 0.1}
"""


def test_a_barge(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(BARGE, encoding="utf-8")
    assert main(["info", str(path), "--stability"]) == 0
    said = capsys.readouterr().out
    rows = [line.split() for line in said.splitlines()]
    assert ["displaced", "volume", "576", "m3"] in rows
    gm = next(row for row in rows if row[-1] == "m" and "(GM)" in row)
    assert [float(x) for x in gm[-3:-1]] == pytest.approx([12**2 / 24 - 2, 24**2 / 24 - 2])
    at_10 = next(row for row in rows if row[:1] == ["10"])
    phi = math.radians(10)
    exact = math.sin(phi) * (4 + 0.5 * 6 * math.tan(phi) ** 2)
    assert float(at_10[1]) == pytest.approx(exact, rel=1e-4)
    assert said.count("righting arms GZ") == 1  # the spar has no freeboard
    assert "give a box or a cylinder a freeboard" in said
    moments = [row for row in rows if row[-1:] == ["kg.m2"]]
    mass, height = 1025 * 576, 3.5
    about = mass * (1 + 2 - height / 2) ** 2  # G is that much above the middle
    exact = [mass * (12**2 + height**2) / 12 + about, mass * (24**2 + height**2) / 12 + about,
             mass * (24**2 + 12**2) / 12]  # fmt: skip
    assert moments[0][:2] == ["homogeneous", "solid"]
    assert [float(x) for x in moments[0][-4:-1]] == pytest.approx(exact, rel=1e-5)
    assert "shell of one thickness, below the water" in said  # of the spar


def test_inertia_of_balls_and_of_a_shell_aside() -> None:
    """2/5 and 2/3 m R², with Steiner's part; a box aside has products, −∫ x y dm."""
    ball = sphere_panels(Sphere(radius=2, center_z=-6), 4000).triangles
    for found, share in ((solid_inertia, 0.4), (shell_inertia, 2 / 3)):
        about = np.diag([9.0, 9.0, 0.0])
        exact = share * 4 * np.eye(3) + about
        np.testing.assert_allclose(found(ball, (0, 0, -3)), exact, rtol=5e-3, atol=1e-9)
    box = box_panels(Box(length=6, width=4, draft=2), 100).triangles
    tensor = solid_inertia(box, (1.0, 2.0, -1.0))
    exact = np.array([[20 / 12 + 4, -2, 0], [-2, 40 / 12 + 1, 0], [0, 0, 52 / 12 + 5]])
    np.testing.assert_allclose(tensor, exact, atol=1e-12)
