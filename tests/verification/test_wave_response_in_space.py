"""Responses to oblique waves in space: forces as in a program's own sea, and a turned barge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.response_in_time import compared_in_time

from m4e_fmi.analysis import OperatingPoint, equilibrium
from m4e_fmi.analysis.points import Evaluation, operating_point
from m4e_fmi.analysis.response import InWaves, sea_response, wave_response
from m4e_fmi.cosim import load_system, system_in_waves, system_program

MODEL = """\
name: barge
dimensions: 3
gravity: 9.81
bodies: {hull: {mass: neutral, inertia: [5e6, 2e7, 2.2e7], added_mass: true}}
joints: {sea: {type: floating, child: hull, initial: {z: -0.5, psi: PSI}}}
"""
SYSTEM = """\
name: barge
components:
  barge: {model: barge.model.yaml}
  water:
    kind: hydrodynamics
    dimensions: 3
    heading: HEADING
    bodies:
      hull:
        shape: {box: {length: 24, width: 12, draft: 2}}
        center_of_gravity: [0, 0, -0.5]
        panels: 100
        drag: {roll: 3e7, heave: 1e5}
    frequencies: {maximum: 1.6, count: 12}
    waves: WAVES
connections: [barge.hull <-> water.hull, water.added_mass -> barge.added_mass]
simulation: {stop_time: 10, step_size: 0.05}
"""
HEADING, DIRECTION = 20.0, 65.0
SEA = (
    "{spectrum: jonswap, significant_height: 1, peak_period: 11, direction: 65, components: 40, "
    "ramp_time: 0}"
)
NAMES = [f"barge.body.hull.{name}" for name in ("x", "y", "z", "phi", "theta", "psi")]


def barge(folder: Path, heading: float, waves: str) -> Path:
    psi = f"{np.radians(heading)!r}".removeprefix("np.float64(").removesuffix(")")
    (folder / "barge.model.yaml").write_text(MODEL.replace("PSI", psi), encoding="utf-8")
    path = folder / "system.yaml"
    text = SYSTEM.replace("HEADING", f"{heading:g}").replace("WAVES", waves)
    path.write_text(text, encoding="utf-8")
    return path


def in_waves(folder: Path, heading: float, sea: str = SEA) -> tuple[InWaves, OperatingPoint]:
    waves = system_in_waves(load_system(barge(folder, heading, sea)), highest=1.5)
    return waves, equilibrium(waves.program)


@pytest.mark.parametrize("spreading", ["", ", spreading: {exponent: 4}"])
def test_forces_are_those_of_the_programs_own_sea(tmp_path: Path, spreading: str) -> None:
    """Long-crested, and with components in directions of their own."""
    waves, point = in_waves(tmp_path, HEADING, SEA.replace("}", f"{spreading}}}"))
    sea = waves.own_sea(point)
    assert sea.direction == pytest.approx(np.radians(DIRECTION), abs=0.1 if spreading else 1e-12)
    assert len(np.unique(sea.directions)) == (40 if spreading else 1)
    assert sea.significant_height == pytest.approx(1.0, rel=1e-9)
    program = system_program(load_system(tmp_path / "system.yaml"))
    own = operating_point(program, time=4.0)
    phases = np.array([own[f"water.wave.phase[{k + 1}]"] for k in range(40)])
    turn = sea.amplitudes * np.exp(-1j * (4.0 * sea.omega + phases))
    expected = np.real(turn @ waves.per_amplitude(sea.omega, sea.directions, point))
    found = dict(zip([v.name for v in program.outputs], Evaluation(program).at(own), strict=True))
    assert found["water.wave.elevation"] == pytest.approx(expected[0], rel=1e-12)
    c, s = np.cos(np.radians(HEADING)), np.sin(np.radians(HEADING))
    surge, sway, heave, roll, pitch, yaw = expected[1:]
    for name, value in (
        ("force_x", c * surge - s * sway), ("force_y", s * surge + c * sway), ("force_z", heave),
        ("moment_x", c * roll - s * pitch), ("moment_y", s * roll + c * pitch), ("moment_z", yaw),
    ):  # fmt: skip
        scale = np.abs(expected[1:4]).max() if name.startswith("f") else np.abs(expected[4:]).max()
        assert found[f"water.hull.excitation_{name}"] == pytest.approx(value, abs=1e-9 * scale)


@pytest.mark.verifies(
    "RAOs of a free barge in oblique waves, in a world turned by 20° about Z",
    analytic="symmetry: the same barge, not turned",
    tolerance="1e-6 of the largest motion of its unit",
)
def test_a_turned_barge_has_the_turned_response(tmp_path: Path) -> None:
    found = []
    for heading in (0.0, HEADING):
        folder = tmp_path / f"{heading:g}"
        folder.mkdir()
        waves, point = in_waves(folder, heading)
        direction = np.radians(DIRECTION - HEADING + heading)
        response = wave_response(
            waves, point, periods=[6.0, 9.0, 14.0], directions=[direction], outputs=NAMES
        )
        c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
        x, y, z, phi, theta, psi = response.values[0].T
        # roll and pitch are angles about the axes of the hull, the yaw is about Z
        found.append(np.array([c * x + s * y, c * y - s * x, z, phi, theta, psi]))
    straight, turned = found
    for rows in (slice(0, 3), slice(3, 6)):
        scale = np.abs(straight[rows]).max()
        assert np.abs(turned[rows] - straight[rows]).max() < 1e-6 * scale


@pytest.mark.verifies(
    "a free barge in oblique waves of 0.5 m with roll drag, by harmonic balance",
    independent="simulation of 40 periods, DOP853",
    tolerance="1 %",
)
def test_oblique_waves_of_a_height(tmp_path: Path) -> None:
    waves, point = in_waves(tmp_path, 0.0)
    response = wave_response(
        waves, point, periods=[7.0], directions=[np.radians(45.0)], outputs=NAMES, height=0.5
    )
    differences = {
        c.output: c.difference for c in compared_in_time(waves, response) if c.what == "amplitude"
    }
    for name in NAMES[2:5]:
        assert abs(differences[name]) < 0.01, differences


def test_a_beam_sea_settles(tmp_path: Path) -> None:
    """What symmetry leaves at rounding does not disturb the iteration."""
    waves, point = in_waves(tmp_path, HEADING)
    sea = waves.jonswap(1.5, 9.0, 3.3, np.radians(HEADING + 90.0))
    found = sea_response(waves, point, sea, outputs=NAMES)
    assert found.deviation(NAMES[3]) > 0.01
    assert found.deviation(NAMES[4]) < 1e-6 * found.deviation(NAMES[3])
