"""Drag against moving water: by hand, in plane and space."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.hulls import checked_program, in_waves
from support.programs import Evaluated

from m4e_adapters.hydrodynamics.seas.water.kinematics import Components, flow

HEIGHT, PERIOD, PHASE, DEPTH = 3.0, 7.0, 0.4, 40.0
OMEGA = 2 * math.pi / PERIOD
WAVE = {"spectrum": "regular", "height": HEIGHT, "period": PERIOD, "phase": PHASE, "ramp_time": 0}
CURRENT = {"speed": 1.3, "direction": 180.0, "profile": 0.2}
DRAG = {"surge": 2e4, "heave": 5e4, "linear": {"surge": 3e3, "pitch": 7e3}}
CENTER = (31.0, 0.0, -0.7)
BARGE: dict[str, Any] = {
    "shape": {"box": {"length": 20, "width": 8, "draft": 3, "center_x": 30}},
    "center_of_gravity": [CENTER[0], CENTER[2]],
    "panels": 48,
    "drag": DRAG,
}
PLANE: dict[str, Any] = {
    "water": {"depth": DEPTH},
    "bodies": {"barge": BARGE},
    "waves": WAVE,
    "current": CURRENT,
}
SPACE: dict[str, Any] = {
    **PLANE,
    "dimensions": 3,
    "heading": 30.0,
    "bodies": {
        "barge": {**BARGE, "center_of_gravity": list(CENTER), "drag": {**DRAG, "sway": 9e4}}
    },
    "waves": {**WAVE, "direction": 20.0},
    "current": {**CURRENT, "direction": 100.0},
}
LOADS = {"froude_krylov": "none", "diffraction": "none", "radiation": "none"}
TURN, BETA = math.radians(30.0), math.radians(20.0)
SPEED = 1.3 * ((DEPTH + CENTER[2]) / DEPTH) ** 0.2


def outputs(section: dict[str, Any], t: float, **inputs: float) -> dict[str, float]:
    """At a time, with inputs of the barge."""
    given = {f"barge.{name}": value for name, value in inputs.items()}
    return Evaluated(checked_program(section)).outputs(given, t=t)


def of_wave(direction: float, t: float) -> np.ndarray:
    """Velocity (3,) [m/s] of the wave at the centre of gravity, by the kinematics in numbers."""
    values = (OMEGA, HEIGHT / 2, PHASE, direction)
    wave = Components(*(np.array([value]) for value in values), depth=DEPTH)
    return flow(wave, t, np.array(CENTER), stretching="linear").velocity


def test_drag_in_the_plane() -> None:
    found = outputs(PLANE, 2.3, vx=0.4, vz=-0.3, omega=0.1)
    u, _, w = of_wave(0.0, 2.3)
    x, z = 0.4 - (u - SPEED), -0.3 - w
    assert found["barge.drag_force_x"] == pytest.approx(-2e4 * abs(x) * x - 3e3 * x, rel=1e-12)
    assert found["barge.drag_force_z"] == pytest.approx(-5e4 * abs(z) * z, rel=1e-12)
    assert found["barge.drag_moment_y"] == pytest.approx(-7e3 * 0.1, rel=1e-12)


def test_drag_in_space_is_that_of_the_hulls_surge_and_sway() -> None:
    found = outputs(SPACE, 1.1, vx=0.4, vy=-0.2)
    to = math.radians(100.0)
    water = of_wave(BETA, 1.1)[:2] + SPEED * np.array([math.cos(to), math.sin(to)])
    axes = np.array([[math.cos(TURN), math.sin(TURN)], [-math.sin(TURN), math.cos(TURN)]])
    surge, sway = axes @ (np.array([0.4, -0.2]) - water)
    force = [-2e4 * abs(surge) * surge - 3e3 * surge, -9e4 * abs(sway) * sway]
    shown = [found["barge.drag_force_x"], found["barge.drag_force_y"]]
    assert shown == pytest.approx(axes.T @ force, rel=1e-12)


def test_water_at_rest_is_the_default_without_a_current() -> None:
    still = {name: value for name, value in PLANE.items() if name != "current"}
    moving = {**still, "bodies": {"barge": {**BARGE, "drag": {**DRAG, "water": "moving"}}}}
    for section, x in ((still, 0.4), (moving, 0.4 - of_wave(0.0, 2.3)[0])):
        found = outputs(section, 2.3, vx=0.4)["barge.drag_force_x"]
        assert found == pytest.approx(-2e4 * abs(x) * x - 3e3 * x, rel=1e-12)


@pytest.mark.parametrize(("section", "direction"), [(PLANE, 0.0), (SPACE, BETA)])
def test_responses_get_the_water_as_inputs(section: dict[str, Any], direction: float) -> None:
    """The inputs of a wave give the drag that the wave of the file gives."""
    section = {**section, "loads": LOADS, "frequencies": {"count": 12}}
    made, waves = in_waves(section)
    heading = {"heading": TURN}
    harmonics = waves.per_amplitude(np.array([OMEGA]), np.array([direction]), heading)[0]
    for t in (0.0, 1.9):
        now = np.real(harmonics * HEIGHT / 2 * np.exp(-1j * (OMEGA * t + PHASE)))
        inputs = dict(zip(waves.inputs, now.tolist(), strict=True))
        found = Evaluated(made).outputs({**inputs, "barge.vx": 0.3})
        expected = outputs(section, t, vx=0.3)
        for name in ("barge.drag_force_x", "barge.drag_force_z"):
            assert found[name] == pytest.approx(expected[name], rel=1e-9), name
