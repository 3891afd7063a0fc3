"""One sea for hull, gauge and controller: a damper against the water's velocity at a float."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Jonswap
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.water.kinematics import flow
from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.results.results_file import Results

MODEL = """\
name: float
dimensions: {dimensions}
gravity: 9.81
bodies: {{float: {{mass: neutral, inertia: {inertia}, added_mass: true}}}}
joints: {{sea: {{type: floating, child: float, initial: {{z: -2}}}}}}
points: {{deck: {{body: float, at: [{zeros}, 0]}}}}
loads: {{damper: {{type: body_force, body: float, force: [{zeros}, -2e6*body.float.vz]}}}}
"""
SYSTEM = """\
name: shared
components:
  buoy: {{model: float.model.yaml}}
  hydro:
    kind: hydrodynamics
    dimensions: {dimensions}
    water: &water {{depth: 60}}
    waves: &sea {{spectrum: jonswap, significant_height: 1.5, peak_period: 7, seed: 5,
      components: 20, direction: {direction}, ramp_time: 0}}
    bodies:
      float: {{shape: {{sphere: {{radius: 5}}}}, center_of_gravity: [{zeros}, -2], panels: 100}}
    frequencies: {{count: 12}}
  gauge:
    kind: sea
    dimensions: {dimensions}
    water: *water
    waves: *sea
    moving_points: {{float: [{zeros}, -2]}}
connections:
  - buoy.body.float <-> hydro.float
  - hydro.added_mass -> buoy.added_mass
  - hydro.float.neutral_mass -> buoy.body.float.neutral_mass
{places}
  - gauge.float.velocity_z * {gain} -> buoy.point.deck.force_z, units ignored
simulation: {{stop_time: 10, step_size: 0.05, algorithm: corrector}}
"""


def results_of(folder: Path, text: str) -> Results:
    (folder / "system.yaml").write_text(text)
    prepared = prepare(load_system(folder / "system.yaml"), build_directory=folder)
    assert [line for line in prepared.warnings if "differ" in line] == []
    return run(prepared, results=folder / "r.nc", certify=False).results()


@pytest.mark.verifies(
    "a controller that is led by the water at a moving float", tolerance="1e-9",
    independent="kinematics of the same sea at the float's places of the results",
)  # fmt: skip
@pytest.mark.parametrize(("dimensions", "direction"), [(2, 180), (3, 40)])
def test_a_controller_is_led_by_the_sea_of_the_hull(
    tmp_path: Path, dimensions: int, direction: float
) -> None:
    """Damping against the water's velocity, not the earth's: the float goes with the water."""
    axes = "xz" if dimensions == 2 else "xyz"
    zeros = "0" if dimensions == 2 else "0, 0"
    given = {
        "dimensions": dimensions,
        "direction": direction,
        "zeros": zeros,
        "inertia": "3e6" if dimensions == 2 else "[3e6, 3e6, 3e6]",
        "places": "\n".join(f"  - buoy.body.float.{a} -> gauge.float.{a}" for a in axes),
    }
    (tmp_path / "float.model.yaml").write_text(MODEL.format(**given))
    results = results_of(tmp_path, SYSTEM.format(**given, gain=2e6))

    def series(name: str) -> np.ndarray:
        return np.asarray(results[name].values)

    section = Jonswap(
        spectrum="jonswap", significant_height=1.5, peak_period=7, seed=5, components=20,
        direction=direction, ramp_time=0,
    )  # fmt: skip
    waves = components_of(wave_systems(section, depth=60.0, gravity=9.81), {})
    place = np.zeros((len(results.time), 3))
    for axis in axes:
        place[:, "xyz".index(axis)] = series(f"buoy.body.float.{axis}")
    water = flow(waves, results.time, place)
    assert np.ptp(place[:, 0]) > 0.1
    assert np.array_equal(series("gauge.wave.elevation"), series("hydro.wave.elevation"))
    np.testing.assert_allclose(series("gauge.float.elevation"), water.elevation, atol=1e-9)
    np.testing.assert_allclose(series("gauge.float.velocity_z"), water.velocity[:, 2], atol=1e-9)
    held = results_of(tmp_path, SYSTEM.format(**given, gain=1e-9))
    slip = series("buoy.body.float.vz") - water.velocity[:, 2]
    held_slip = (
        np.asarray(held["buoy.body.float.vz"].values) - held["gauge.float.velocity_z"].values
    )
    assert np.std(slip) < 0.5 * np.std(held_slip)
