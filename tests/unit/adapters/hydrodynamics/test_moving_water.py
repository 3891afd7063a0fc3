"""Drag against moving water: current and waves, plane and space, inputs of waves, energy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.build import check_config, program_in_waves
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.doubts import flow_doubts
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components, flow
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python

HEIGHT, PERIOD, PHASE, DEPTH = 3.0, 7.0, 0.4, 40.0
WAVE = {"spectrum": "regular", "height": HEIGHT, "period": PERIOD, "phase": PHASE, "ramp_time": 0}
CURRENT = {"speed": 1.3, "direction": 180.0, "profile": 0.2}
DRAG = {"surge": 2e4, "heave": 5e4, "linear": {"surge": 3e3, "pitch": 7e3}}
BOX = {"box": {"length": 20, "width": 8, "draft": 3, "center_x": 30}}
CENTER = (31.0, 0.0, -0.7)
PLANE: dict[str, Any] = {
    "water": {"depth": DEPTH},
    "bodies": {
        "barge": {
            "shape": BOX,
            "center_of_gravity": [CENTER[0], CENTER[2]],
            "panels": 48,
            "drag": DRAG,
        }
    },
    "waves": WAVE,
    "current": CURRENT,
}
SPACE = {
    **PLANE,
    "dimensions": 3,
    "heading": 30.0,
    "bodies": {
        "barge": {
            **PLANE["bodies"]["barge"],
            "center_of_gravity": list(CENTER),
            "drag": {**DRAG, "sway": 9e4},
        }
    },
    "waves": {**WAVE, "direction": 20.0},
    "current": {**CURRENT, "direction": 100.0},
}


def program(config: dict[str, Any]) -> Program:
    return check_config(HydrodynamicsConfig.model_validate(config), folder=Path())


def outputs(found: Program, t: float, **inputs: float) -> dict[str, float]:
    form = load_python(found)
    p = [v.start for v in found.parameters]
    u = [inputs.get(v.name.replace(".", "_"), v.start) for v in found.inputs]
    x = [0.0] * len(found.states)
    names = [v.name for v in found.outputs]
    return dict(zip(names, form.outputs(t, x, u, p, form.constants(p)), strict=True))


def of_wave(direction: float, t: float) -> np.ndarray:
    """Velocity (3,) [m/s] of the wave at the centre of gravity, by the kinematics in numbers."""
    wave = Components(
        omega=np.array([2 * math.pi / PERIOD]),
        amplitude=np.array([HEIGHT / 2]),
        phase=np.array([PHASE]),
        direction=np.array([direction]),
        depth=DEPTH,
    )
    return flow(wave, t, np.array(CENTER), stretching="linear").velocity


SPEED = 1.3 * ((DEPTH + CENTER[2]) / DEPTH) ** 0.2


def test_in_the_plane() -> None:
    found = outputs(program(PLANE), 2.3, barge_vx=0.4, barge_vz=-0.3, barge_omega=0.1)
    u, _, w = of_wave(0.0, 2.3)
    x, z = 0.4 - (u - SPEED), -0.3 - w
    assert found["barge.drag_force_x"] == pytest.approx(-2e4 * abs(x) * x - 3e3 * x, rel=1e-12)
    assert found["barge.drag_force_z"] == pytest.approx(-5e4 * abs(z) * z, rel=1e-12)
    assert found["barge.drag_moment_y"] == pytest.approx(-7e3 * 0.1, rel=1e-12)


def test_in_space_surge_and_sway_are_those_of_the_hull() -> None:
    found = outputs(program(SPACE), 1.1, barge_vx=0.4, barge_vy=-0.2)
    beta, turn = math.radians(100.0), math.radians(30.0)
    water = of_wave(math.radians(20.0), 1.1)
    water[:2] += SPEED * np.array([math.cos(beta), math.sin(beta)])
    axes = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    surge, sway = axes @ (np.array([0.4, -0.2]) - water[:2])
    force = [-2e4 * abs(surge) * surge - 3e3 * surge, -9e4 * abs(sway) * sway]
    expected = axes.T @ force
    shown = [found["barge.drag_force_x"], found["barge.drag_force_y"]]
    assert shown == pytest.approx(expected, rel=1e-12)


def test_water_at_rest_is_the_default_without_a_current() -> None:
    still = {name: value for name, value in PLANE.items() if name != "current"}
    found = outputs(program(still), 2.3, barge_vx=0.4)
    assert found["barge.drag_force_x"] == pytest.approx(-2e4 * 0.16 - 3e3 * 0.4, rel=1e-12)
    body = {**PLANE["bodies"]["barge"], "drag": {**DRAG, "water": "moving"}}
    found = outputs(program({**still, "bodies": {"barge": body}}), 2.3, barge_vx=0.4)
    x = 0.4 - of_wave(0.0, 2.3)[0]
    assert found["barge.drag_force_x"] == pytest.approx(-2e4 * abs(x) * x - 3e3 * x, rel=1e-12)


def test_drag_takes_energy_relative_to_the_water() -> None:
    """F·(v − u) < 0 at any time and motion; F·v > 0 where the water is faster."""
    made = program(PLANE)
    for t in np.linspace(0.0, PERIOD, 9):
        u, _, w = of_wave(0.0, float(t))
        for vx, vz in ((0.0, 0.0), (1.5, -1.0), (-3.0, 0.2)):
            found = outputs(made, float(t), barge_vx=vx, barge_vz=vz)
            force = found["barge.drag_force_x"], found["barge.drag_force_z"]
            assert force[0] * (vx - u + SPEED) + force[1] * (vz - w) < 0.0
    calm = program({**PLANE, "waves": {"spectrum": "still"}})
    for vx in (-0.9 * SPEED, -1.1 * SPEED):
        carried = outputs(calm, 0.0, barge_vx=vx)["barge.drag_force_x"] * vx > 0.0
        assert carried == (abs(vx) < SPEED)


@pytest.mark.parametrize(("config", "direction"), [(PLANE, 0.0), (SPACE, 20.0)])
def test_responses_get_the_velocity_of_the_water_as_inputs(
    config: dict[str, Any], direction: float
) -> None:
    """The inputs of a wave give the drag that the wave of the file gives."""
    loads = {"froude_krylov": "none", "diffraction": "none", "radiation": "none"}
    given = HydrodynamicsConfig.model_validate({**config, "loads": loads})
    made, waves = program_in_waves(
        given, name="hydro", folder=Path(), highest=1.0, progress=lambda _: None
    )
    omega, beta = np.array([2 * math.pi / PERIOD]), np.array([math.radians(direction)])
    harmonics = waves.per_amplitude(omega, beta, {"heading": math.radians(30.0)})[0]
    assert len(harmonics) == len(waves.inputs)
    t = 1.9
    now = np.real(harmonics * HEIGHT / 2 * np.exp(-1j * (omega[0] * t + PHASE)))
    inputs = {name.replace(".", "_"): value for name, value in zip(waves.inputs, now, strict=True)}
    found = outputs(made, 0.0, barge_vx=0.3, **inputs)
    expected = outputs(program({**config, "loads": loads}), t, barge_vx=0.3)
    for name in ("barge.drag_force_x", "barge.drag_force_z"):
        assert found[name] == pytest.approx(expected[name], rel=1e-9)


def refused(text: str) -> str:
    with pytest.raises(InputError) as caught:
        Document.parse(text).validate(HydrodynamicsConfig)
    return str(caught.value)


BODY = "bodies: {b: {shape: {box: {length: 8, width: 5, draft: 2}}, center_of_gravity: [0, 0]"


def test_currents_without_effect_are_refused_or_told() -> None:
    current = "current: {speed: 1}\n"
    assert "'current' has no effect" in refused(f"{BODY}, drag: {{water: still}}}}}}\n{current}")
    assert "'current' has no effect" in refused(f"{BODY}}}}}\n{current}loads: {{drag: none}}\n")
    assert "leaves the X-Z plane" in refused(f"{BODY}}}}}\ncurrent: {{speed: 1, direction: 90}}\n")
    assert "'sway' is of space" in refused(f"{BODY}, drag: {{linear: {{sway: 1}}}}}}}}\n")
    told = [*flow_doubts(HydrodynamicsConfig.model_validate(PLANE))]
    assert len(told) == 1
    assert "no Doppler shift" in told[0]
    bare = {**PLANE, "bodies": {"barge": {**PLANE["bodies"]["barge"], "drag": {"heave": 1.0}}}}
    told = [*flow_doubts(HydrodynamicsConfig.model_validate(bare))]
    assert any("acts on nothing" in text for text in told)
