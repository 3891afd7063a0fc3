"""Air gaps of points on bodies: places and elevations by hand, in plane and space, and in waves."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.build import check_config, program_in_waves
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python

WAVE = {"spectrum": "regular", "height": 3.0, "period": 7.0, "phase": 0.4, "ramp_time": 0}
PLANE = {
    "bodies": {
        "barge": {
            "shape": {"box": {"length": 20, "width": 8, "draft": 3, "center_x": 30}},
            "center_of_gravity": [31, 0.5],
            "panels": 48,
        }
    },
    "points": {"deck": {"body": "barge", "at": [40, 2.5]}},
    "waves": WAVE,
}
SPACE = {
    **PLANE,
    "dimensions": 3,
    "heading": 30.0,
    "bodies": {"barge": {**PLANE["bodies"]["barge"], "center_of_gravity": [31, 0, 0.5]}},
    "points": {"deck": {"body": "barge", "at": [40, 4, 2.5]}},
    "waves": {**WAVE, "direction": 20.0},
}
K = float(wavenumber(np.array(2 * math.pi / 7.0), depth=math.inf, gravity=9.81))


def outputs(program: Program, t: float, **inputs: float) -> dict[str, float]:
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c = form.constants(p)
    u = [inputs.get(v.name.replace(".", "_"), v.start) for v in program.inputs]
    x = [0.0] * len(program.states)
    names = [v.name for v in program.outputs]
    return dict(zip(names, form.outputs(t, x, u, p, c), strict=True))


def elevation(x: float, t: float) -> float:
    """Of the wave, `x` [m] along its way."""
    return 1.5 * math.cos(2 * math.pi / 7.0 * t + 0.4 - K * x)


def test_in_the_plane() -> None:
    program = check_config(HydrodynamicsConfig.model_validate(PLANE), folder=Path())
    found = outputs(program, 2.3, barge_x=31.7, barge_z=0.9, barge_theta=0.2)
    assert found["deck.elevation"] == pytest.approx(elevation(40.0, 2.3), abs=1e-12)
    height = 0.9 - 9.0 * math.sin(0.2) + 2.0 * math.cos(0.2)  # theta puts +X down
    assert found["deck.air_gap"] == pytest.approx(height - found["deck.elevation"], abs=1e-12)
    assert found["wave.elevation"] == pytest.approx(elevation(0.0, 2.3), abs=1e-12)


def test_in_space_with_a_heading() -> None:
    """R = R_z(ψ) R_y(θ) R_x(φ) of the arm; the place turns with the hull about its centre."""
    program = check_config(HydrodynamicsConfig.model_validate(SPACE), folder=Path())
    phi, theta = 0.1, -0.15
    found = outputs(program, 1.1, barge_z=0.7, barge_phi=phi, barge_theta=theta)
    turn = math.radians(30.0)
    x = 31.0 + 9.0 * math.cos(turn) - 4.0 * math.sin(turn)
    y = 9.0 * math.sin(turn) + 4.0 * math.cos(turn)
    beta = math.radians(20.0)
    expected = elevation(x * math.cos(beta) + y * math.sin(beta), 1.1)
    assert found["deck.elevation"] == pytest.approx(expected, abs=1e-12)
    rolled = 4.0 * math.sin(phi) + 2.0 * math.cos(phi)
    height = 0.7 - 9.0 * math.sin(theta) + rolled * math.cos(theta)
    assert found["deck.air_gap"] == pytest.approx(height - expected, abs=1e-12)


def test_still_water() -> None:
    config = HydrodynamicsConfig.model_validate({**PLANE, "waves": {"spectrum": "still"}})
    found = outputs(check_config(config, folder=Path()), 5.0)
    assert found["deck.elevation"] == 0.0
    assert found["deck.air_gap"] == pytest.approx(2.5)


@pytest.mark.parametrize("sections", [PLANE, SPACE])
def test_per_amplitude_of_a_wave(sections: dict) -> None:
    """Inputs in waves, times their amplitude, are the elevation of that wave at the point."""
    config = HydrodynamicsConfig.model_validate(sections)
    program, forces = in_waves(config)
    assert forces.inputs[-1] == "deck.elevation_input"
    values = {v.name: v.start for v in program.parameters}
    beta = math.radians(sections["waves"].get("direction", 0.0))
    omega = np.array([2 * math.pi / 7.0])
    found = forces.per_amplitude(omega, np.array([beta]), values)
    sea = check_config(config, folder=Path())
    for t in (0.0, 1.7):
        wave = 1.5 * np.exp(-1j * (omega[0] * t + 0.4))
        assert (found[0, -1] * wave).real == pytest.approx(
            outputs(sea, t)["deck.elevation"], abs=1e-12
        )
    shifted = outputs(program, 0.0, deck_elevation_input=0.25, barge_z=0.5)
    assert shifted["deck.air_gap"] == pytest.approx(2.5 - 0.25)


def in_waves(config: HydrodynamicsConfig) -> tuple[Program, HullWaves]:
    """The program with waves as inputs, of coarse panels and few frequencies."""
    coarse = config.model_copy(
        update={"frequencies": config.frequencies.model_copy(update={"count": 12})}
    )
    return program_in_waves(
        coarse, name="hydro", folder=Path(), highest=0.0, progress=lambda _: None
    )


@pytest.mark.parametrize(
    ("point", "said"),
    [
        ("{deck: {body: barg, at: [40, 2]}}", "there is no body 'barg'"),
        ("{deck: {body: barge, at: [40, 0, 2]}}", r"expected \[x, z\]"),
        ("{barge: {body: barge, at: [40, 2]}}", "has another meaning here"),
        ("{wave: {body: barge, at: [40, 2]}}", "has another meaning here"),
    ],
)
def test_refusals(point: str, said: str) -> None:
    shape = "{box: {length: 20, width: 8, draft: 3}}"
    text = f"bodies: {{barge: {{shape: {shape}, center_of_gravity: [0, 0]}}}}\npoints: {point}\n"
    with pytest.raises(InputError, match=said):
        Document.parse(text).validate(HydrodynamicsConfig)
