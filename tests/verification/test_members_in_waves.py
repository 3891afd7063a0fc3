"""Responses to waves of systems with members, beside simulations up to the moving surface."""

from __future__ import annotations

import importlib
import math
from pathlib import Path

import numpy as np
import pytest
from support.frames import floating_frame
from support.response_in_time import compared_in_time, started_at

from m4e_adapters.morison import MorisonConfig, members_in_waves
from m4e_fmi.analysis import equilibrium, linearize
from m4e_fmi.analysis.response import (
    InWaves,
    sea_response,
    wave_response,
)
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.cosim import load_system, system_in_waves, system_program
from m4e_fmi.simulate import simulate

BODY, WATER = "frame.body.frame", "water.frame"
OUTPUTS = [
    *(f"{BODY}.{name}" for name in ("x", "y", "z", "theta", "phi")),
    *(f"{WATER}.{name}" for name in ("force_x", "force_y", "force_z", "buoyancy_force_z")),
    *(f"{WATER}.inertia_force_{axis}" for axis in "xz"),
    "water.column_0.force_x", "water.column_0.force_z", "water.pontoon_0.force_z",
]  # fmt: skip


@pytest.mark.verifies(
    "small regular waves on a floating frame of members: RAO beside a simulation",
    independent="simulation with the instantaneous surface and pose",
    tolerance="0.005",
)
@pytest.mark.parametrize(("period", "height"), [(6.0, 0.002), (14.0, 0.002)])
def test_small_waves_are_those_of_a_simulation(
    tmp_path: Path, period: float, height: float
) -> None:
    """From the state of the linear response on, which is steady but for terms of second order."""
    text = f"{{spectrum: regular, height: {height}, period: {period}, direction: 30, ramp_time: 0}}"
    plates = ", end_drag: 3, end_added_mass: 0.6" if period == 6.0 else ""
    system = load_system(floating_frame(tmp_path, text, more=plates))
    waves = system_in_waves(system, highest=2.0)
    point = equilibrium(waves.program)
    response = wave_response(waves, point, periods=[period], outputs=OUTPUTS)
    local = LocalEquations(waves.program, point, inputs=waves.inputs, outputs=OUTPUTS)
    amplitude = height / 2
    start = started_at(local, np.real(amplitude * response.states[0, 0]))
    result = simulate(
        system_program(system).with_start(start),
        stop_time=2 * period,
        output_interval=period / 64,
        tolerance=1e-9,
    )
    time = np.asarray(result.time)
    last = time > period * (1 + 1e-6)
    first = np.exp(2j * np.pi / period * time[last])
    for name in OUTPUTS:
        found = 2 * np.mean(np.asarray(result[name])[last] * first) / amplitude
        assert abs(response.of(name)[0] - found) < 0.005 * abs(found), name


SLIDER = """\
name: slider
gravity: 0
bodies: {leg: {mass: 20e3, inertia: 1e6, added_mass: true}}
joints: {rail: {type: prismatic, child: leg, direction: [1, 0], parent_to_joint: [0, -6]}}
points: {end: {body: leg, at: [0, 0]}, wall: {body: ground, at: [60, -6]}}
loads: {spring: {type: tension_spring, points: [end, wall], stiffness: 300e3, length: 60}}
"""
SEA = """\
name: slider
components:
  slider: {model: slider.model.yaml}
  water:
    kind: morison
    water: {density: 1025, depth: 40, gravity: 9.81}
    waves: {spectrum: jonswap, significant_height: 1.5, peak_period: 8, components: 25, seed: 3,
      ramp_time: 0}
    bodies: {leg: {center_of_gravity: [0, -6]}}
    members: {axis: {ends: [[0, -14], [0, 8]], diameter: 1.4, drag: 2, body: leg, segments: 6}}
connections: [slider.leg <-> water.leg, water.added_mass -> slider.added_mass]
simulation: {stop_time: 5, step_size: 0.02}
"""


def slider(folder: Path) -> tuple[InWaves, Path]:
    (folder / "slider.model.yaml").write_text(SLIDER, "utf-8")
    (folder / "system.yaml").write_text(SEA, "utf-8")
    return system_in_waves(load_system(folder / "system.yaml"), highest=2.0), folder / "system.yaml"


@pytest.mark.verifies(
    "a column with drag in a sea: standard deviations by statistical linearisation",
    independent="simulation of 2000 s",
    tolerance="0.03",
)
def test_a_sea_is_that_of_a_simulation(tmp_path: Path) -> None:
    waves, path = slider(tmp_path)
    point = equilibrium(waves.program)
    names = ["slider.joint.rail.q", "water.leg.force_x", "water.wave.elevation"]
    response = sea_response(waves, point, waves.own_sea(point), outputs=names)
    program = system_program(load_system(path))
    result = simulate(program, stop_time=2300, output_interval=0.25, tolerance=1e-5)
    late = np.asarray(result.time) > 300
    for name in names:
        found = float(np.std(np.asarray(result[name])[late]))
        assert response.deviation(name) == pytest.approx(found, rel=0.03), name
    drag = sea_response(waves, point, waves.own_sea(point), outputs=["water.leg.drag_force_x"])
    assert drag.deviation("water.leg.drag_force_x") > 500.0  # N: the drag counts


def test_principal_components_of_the_sea_are_as_all_inputs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Velocities at points of a column move together: samples differ, statistics do not."""
    waves, _ = slider(tmp_path)
    point = equilibrium(waves.program)
    names = ["slider.joint.rail.q", "water.leg.drag_force_x"]
    sea = waves.own_sea(point)
    module = importlib.import_module("m4e_fmi.analysis.response.sea_response")
    few = []
    for many in (0, 1000):
        monkeypatch.setattr(module, "MANY", many)
        response = sea_response(waves, point, sea, outputs=names)
        few.append([response.deviation(name) for name in names])
    assert few[0] == pytest.approx(few[1], rel=5e-3)
    assert few[0] != few[1]


def test_the_inertia_force_on_a_pile_is_exact(tmp_path: Path) -> None:
    """ρ π D²/4 C_M ω²/k per m of amplitude, and its moment about the bed, in finite depth."""
    config = MorisonConfig.model_validate(
        {
            "water": {"depth": 25, "density": 1000, "gravity": 9.81},
            "members": {
                "pile": {"ends": [[3, -25], [3, 5]], "diameter": 1, "drag": 1, "segments": 12}
            },
            "reference_point": [3, -25],
        }
    )
    _, forces = members_in_waves(config, name="pile", folder=tmp_path)
    omega = np.array([0.9])
    (found,) = forces.per_amplitude(omega, np.zeros(1), {})
    given = dict(zip(forces.inputs, found, strict=True))
    k = 0.1
    for _ in range(50):
        k = 0.9**2 / (9.81 * math.tanh(25 * k))
    area, phase = math.pi / 4, np.exp(1j * k * 3)
    force = -1j * 1000 * area * 2 * 0.81 / k * phase
    assert given["pile.wave_force_x"] == pytest.approx(force, rel=1e-5)
    kh = 25 * k
    arm = (kh * math.sinh(kh) - math.cosh(kh) + 1) / (k * math.sinh(kh))
    assert given["pile.wave_moment_y"] == pytest.approx(force * arm, rel=1e-5)


def test_linear_equations_and_the_check_take_members(tmp_path: Path) -> None:
    waves, path = slider(tmp_path)
    linear = linearize(system_program(load_system(path)))
    assert np.isfinite(linear.A).all()
    point = equilibrium(waves.program)
    steady = wave_response(waves, point, periods=[7], outputs=["slider.joint.rail.q"], height=1.0)
    rows = compared_in_time(waves, steady)
    (row,) = [r for r in rows if r.what == "amplitude"]
    assert abs(row.difference) < 0.005
