"""Decays and responses from coefficients by others: RM3 of WAMIT, a sphere of BEMIO, a flap.

Sources and licences: tests/data/README.md. RM3 with all six motions: `tests/verify`.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np
import pytest
from scipy.optimize import brentq
from support.coefficient_files import FLAP, SPHERE, check_heave_only, rm3_system

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, coefficients_from_config
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_fmi.analysis import equilibrium
from m4e_fmi.analysis.response import wave_response
from m4e_fmi.cosim import load_system, system_in_waves, system_program
from m4e_fmi.files.document import Document
from m4e_fmi.simulate import simulate

DAMPER = 1.5e5  # N.s/m
MODEL = """\
name: sphere
gravity: 9.81
bodies: {ball: {mass: neutral, inertia: 1.69e6, added_mass: true}}
joints:
  rail: {type: prismatic, child: ball, direction: [0, 1], parent_to_joint: [0, -2], initial: {q: 0}}
points: {bed: {body: ground, at: [0, -50]}, middle: {body: ball, at: [0, 0]}}
loads: {pto: {type: tension_damper, points: [bed, middle], damping: 0}}
"""
SYSTEM = f"""\
name: sphere
components:
  body: {{model: sphere.model.yaml}}
  water:
    kind: hydrodynamics
    coefficients: {SPHERE}
    water: {{density: 1000, depth: 200, gravity: 9.81}}
    bodies: {{ball: {{}}}}
connections:
  - body.ball <-> water.ball
  - water.added_mass -> body.added_mass
simulation: {{stop_time: 30, step_size: 0.05}}
"""


def sphere_system(folder: Path, *, start: float, damper: float) -> Path:
    text = MODEL.replace("q: 0", f"q: {start!r}").replace("damping: 0", f"damping: {damper!r}")
    (folder / "sphere.model.yaml").write_text(text, "utf-8")
    path = folder / "system.yaml"
    path.write_text(SYSTEM, "utf-8")
    return path


def of_file(text: str) -> Coefficients:
    config = Document.parse(text).validate(HydrodynamicsConfig)
    return coefficients_from_config(config, folder=Path(), progress=lambda _: None)


@pytest.mark.verifies(
    "RM3 from WAMIT files, float released 1 m, heave of both bodies: RMS, of the release",
    published="WEC-Sim",
    tolerance="5e-4",
)
def test_decay_of_two_bodies(tmp_path: Path) -> None:
    """The files have rows of heave only: then no other motion has any cause."""
    system = load_system(rm3_system(tmp_path, modes=(3, 9)))
    found = simulate(system_program(system), stop_time=100.0, output_interval=0.1, tolerance=1e-9)
    check_heave_only(found)


@pytest.mark.verifies(
    "sphere from a BEMIO file, decay from 1 m: RMS at crossings and extremes, of the release",
    analytic="exact solution of linear potential theory",
    tolerance="3e-3",
)
def test_decay_of_a_sphere(tmp_path: Path) -> None:
    system = load_system(sphere_system(tmp_path, start=1.0, damper=0.0))
    found = simulate(system_program(system), stop_time=14.0, output_interval=0.01, tolerance=1e-9)
    exact = dict.fromkeys((1.139, 3.390, 5.578, 7.748, 9.923, 12.096), 0.0) | {
        2.210: -0.8671, 4.418: 0.63498, 6.595: -0.4649, 8.770: 0.34666, 13.119: 0.19170,
    }  # fmt: skip
    heave = np.interp(list(exact), found.time, found["body.body.ball.z"]) + 2.0
    assert np.sqrt(np.mean((heave - list(exact.values())) ** 2)) < 3e-3


@pytest.mark.verifies(
    "sphere from a BEMIO file, ten periods, with and without take-off: heave, of its amplitude",
    analytic="X/(K − ω²(m + A) − iω(B + c)) of the file's values",
    tolerance="5e-3",
)
@pytest.mark.parametrize("damper", [0.0, DAMPER])
def test_response_of_a_sphere(tmp_path: Path, damper: float) -> None:
    waves = system_in_waves(
        load_system(sphere_system(tmp_path, start=0.0, damper=damper)), highest=3.0
    )
    c = of_file(f"{{coefficients: {SPHERE}, bodies: {{ball: {{}}}}}}")
    rows = np.arange(9, 50, 4)[:10]
    omega, place = c.omega[rows], c.heave
    inertia = c.buoyancy[place] / c.gravity + c.added_mass[rows, place, place]
    loss = c.radiation_damping[rows, place, place] + damper
    stiffness = c.hydrostatic_stiffness[place, place]
    theory = c.excitation[rows, place] / (stiffness - omega**2 * inertia - 1j * omega * loss)
    found = wave_response(
        waves, equilibrium(waves.program), periods=(2.0 * np.pi / omega).tolist(),
        outputs=["body.body.ball.z"],
    )  # fmt: skip
    values = found.values[0, :, 0]
    assert (np.abs(values - theory) / np.abs(theory)).max() < 5e-3


@pytest.mark.verifies(
    "natural period of a hinged flap from a Capytaine file, moved to its hinge",
    analytic="lever arms, by hand",
    tolerance="1e-9",
)
def test_flap_in_its_hinge() -> None:
    """The file has no A∞, a frequency of NaN, and motions about a point 5 m above the hinge."""
    import xarray

    c = of_file(
        f"{{coefficients: {FLAP}, bodies: {{oswec_flap: {{center_of_gravity: [0, -8.9], "
        "reference_point: [0, -3.9]}}}"
    )
    weight, arm, inertia = 127e3 * 9.81, 5.0, 1.85e6 + 127e3 * 5.0**2
    with xarray.open_dataset(FLAP) as file:
        a = file["added_mass"].sel(omega=c.omega, method="nearest").values
        own = float(file["hydrostatic_stiffness"].values[4, 4])
    # the flap's middle moves by arm·θ; the halves of the file are as far apart as panels make them
    moved = a[:, 4, 4] + arm * (a[:, 0, 4] + a[:, 4, 0]) + arm**2 * a[:, 0, 0]
    assert c.added_mass[:, 2, 2] == pytest.approx(moved, rel=1e-9)
    stiffness = own + arm * (float(c.buoyancy[1]) - weight)

    def detuned(omega: float, mass: np.ndarray) -> float:
        return stiffness - omega**2 * (inertia + float(np.interp(omega, c.omega, mass)))

    periods = [
        2 * np.pi / float(cast(float, brentq(detuned, 0.2, 2.0, args=(mass,))))
        for mass in (c.added_mass[:, 2, 2], moved)
    ]
    assert periods[0] == pytest.approx(periods[1], rel=1e-9)
    assert 10.0 < periods[0] < 25.0
