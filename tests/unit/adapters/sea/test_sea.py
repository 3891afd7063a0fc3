"""The sea at points: the equations of `kinematics`, the bits of the hydrodynamics."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.calm_water import calm
from support.hulls import silent
from support.programs import Evaluated

from m4e_adapters.hydrodynamics import hydrodynamics_program
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.water.kinematics import flow
from m4e_adapters.sea import SeaConfig, sea_in_waves, sea_program
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program

SEA = """\
dimensions: 3
stretching: {stretching}
water: {{depth: {depth}}}
waves:
  - {{spectrum: jonswap, significant_height: 5, peak_period: 8, components: 30, ramp_time: 0,
      direction: 20, spreading: {{exponent: 8}}}}
  - {{spectrum: regular, height: 2, period: 13, direction: -40, ramp_time: 0}}
points: {{origin: [0, 0, 0], below: [30, -12, -2.5]}}
moving_points: {{above: [5, 3, 0.8]}}
"""


def config(text: str) -> SeaConfig:
    return Document.parse(text).validate(SeaConfig)


def program(text: str, folder: Path = Path()) -> Program:
    return sea_program(config(text), name="sea", folder=folder, progress=silent)


def outputs(found: Program, time: float, given: dict[str, float] | None = None) -> dict[str, float]:
    return Evaluated(found).outputs(given or {}, t=time)


@pytest.mark.parametrize("stretching", ["wheeler", "linear"])
@pytest.mark.parametrize("depth", ["30", "deep"])
def test_outputs_are_those_of_the_equations(stretching: str, depth: str) -> None:
    """A fixed point in the water, and one that moves from below the surface to above it."""
    text = SEA.format(stretching=stretching, depth=depth)
    found, given = program(text), config(text)
    systems = wave_systems(given.waves, depth=given.water.depth, gravity=9.81)
    waves = components_of(systems, {})
    heights = []
    for time in (0.0, 3.3, 8.1, 17.0):
        moved = np.array([5.0 + time, 3.0 - 0.2 * time, -3.0 + 0.3 * time])
        inputs = {f"above.{axis}": x for axis, x in zip("xyz", moved.tolist(), strict=True)}
        values = outputs(found, time, inputs)
        for name, place in {"below": np.array([30.0, -12.0, -2.5]), "above": moved}.items():
            water = flow(waves, time, place, stretching=given.stretching)
            height = float(water.elevation)
            heights.append(height - place[2])
            assert values[f"{name}.elevation"] == pytest.approx(height, abs=1e-12)
            assert values[f"{name}.submergence"] == pytest.approx(height - place[2], abs=1e-12)
            expected = {"velocity": water.velocity, "acceleration": water.acceleration}
            for what, vector in expected.items():
                shown = [values[f"{name}.{what}_{axis}"] for axis in "xyz"]
                np.testing.assert_allclose(shown, vector, atol=1e-12)
            pressure = 1025.0 * 9.81 * float(water.head)
            assert values[f"{name}.dynamic_pressure"] == pytest.approx(pressure, abs=1e-8)
    assert min(heights) < 0 < max(heights)


@pytest.mark.parametrize(
    "waves",
    [
        "{spectrum: jonswap, significant_height: 2, peak_period: 7, amplitudes: random, seed: 4, "
        "components: 60}",
        "[{spectrum: regular, height: 1, period: 9}, {spectrum: bretschneider, "
        "significant_height: 1, peak_period: 7, components: 20}]",
        "{spectrum: record, file: r.csv}",
        "{spectrum: still}",
    ],
)
def test_the_same_section_is_the_same_sea_as_in_hydrodynamics_to_the_bit(
    waves: str, tmp_path: Path
) -> None:
    rows = "".join(f"{0.5 * k},{math.sin(0.5 * k)}\n" for k in range(200))
    (tmp_path / "r.csv").write_text(f"time,elevation\n{rows}")
    text = f"water: {{depth: 40}}\nwaves: {waves}\npoints: {{origin: [0, 0]}}\n"
    known = replace(calm(("b",)), depth=40.0)
    hydro = hydrodynamics_program(known, waves=config(text).waves, folder=tmp_path)
    times = np.linspace(0.0, 100.0, 11).tolist()
    one, other = (Evaluated(found) for found in (program(text, tmp_path), hydro))
    found = [one.outputs({}, t=time) for time in times]
    elevations = [values["wave.elevation"] for values in found]
    assert [values["origin.elevation"] for values in found] == elevations
    assert [other.outputs({}, t=time)["wave.elevation"] for time in times] == elevations
    assert (np.std(elevations) > 0.1) == ("still" not in waves)


def test_still_water_is_at_rest() -> None:
    values = outputs(program("points: {p: [3, -1]}\n"), 2.0)
    assert values.pop("p.submergence") == 1.0
    assert set(values.values()) == {0.0}
    short = "{spectrum: regular, height: 0.05, period: 0.8, ramp_time: 0}"  # of deep water
    found = program(f"water: {{depth: 400}}\nwaves: {short}\npoints: {{bed: [0, -400]}}\n")
    values = outputs(found, 0.3)
    assert values["bed.velocity_x"] == values["bed.dynamic_pressure"] == 0.0


def test_the_ramp_multiplies_all() -> None:
    text = (
        "waves: {{spectrum: regular, height: 1, period: 6, ramp_time: {}}}\npoints: {{p: [3, 0]}}\n"
    )
    full, half = (outputs(program(text.format(ramp)), 2.0)["p.elevation"] for ramp in (0, 4))
    assert half == pytest.approx(0.5 * full, rel=1e-12) != 0.0


@pytest.mark.parametrize("depth", [30.0, math.inf])
def test_small_waves_are_those_of_the_response_to_waves(depth: float) -> None:
    """The inputs that stand for waves, against the program in a wave of 1 µm."""
    shown = "deep" if math.isinf(depth) else f"{depth:g}"
    text = (
        f"dimensions: 3\nwater: {{depth: {shown}}}\nwaves: {{spectrum: regular, height: 2e-6, "
        "period: 7, direction: 35, ramp_time: 0}\npoints: {a: [12, -5, -3]}\n"
        "moving_points: {b: [4, 1, -0.5]}\n"
    )
    whole = program(text)
    _, waves = sea_in_waves(config(text), name="sea", folder=Path(), progress=silent)
    omega = np.array([2 * math.pi / 7])
    (per,) = waves.per_amplitude(omega, np.array([math.radians(35.0)]), {})
    assert len(per) == len(waves.inputs)
    for time in (0.0, 1.1, 4.0):
        values = outputs(whole, time)
        for name, factor in zip(waves.inputs, per.tolist(), strict=True):
            output = "wave.elevation" if name == waves.inputs[0] else name.replace(".wave_", ".")
            expected = (factor * np.exp(-1j * omega[0] * time)).real
            assert values[output] / 1e-6 == pytest.approx(expected, rel=1e-4, abs=1e-4), name


def test_a_current_adds_its_velocity_at_the_height_of_the_point() -> None:
    still = SEA.format(stretching="wheeler", depth=40)
    moving = still + "current: {speed: 1.4, direction: 60, profile: 0.2}\n"
    flowing = program(moving)
    without, with_it = outputs(program(still), 7.0), outputs(flowing, 7.0)
    beta, speed = math.radians(60), 1.4 * ((40 - 2.5) / 40) ** 0.2
    added = {"below.velocity_x": speed * math.cos(beta), "below.velocity_y": speed * math.sin(beta)}
    for name, value in without.items():
        if not name.startswith(("origin.velocity", "above.velocity")):
            assert with_it[name] == pytest.approx(value + added.get(name, 0.0), abs=1e-12), name
    assert with_it["above.velocity_x"] - without["above.velocity_x"] == pytest.approx(0.7)
    in_waves, _ = sea_in_waves(config(moving), name="sea", folder=Path(), progress=silent)
    assert outputs(in_waves, 0.0)["below.velocity_x"] == pytest.approx(speed * math.cos(beta))
