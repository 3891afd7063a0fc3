"""Pressure on the wetted part of hulls: closed forms, small motions, energy, a sea."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.hull_pressures import RHO, G, hull_load, surface

from m4e_adapters.hydrodynamics.config import Drag, HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.flow.bem import excited_by, without_flow
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import make_hulls
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_fmi.cosim import load_system, run
from m4e_fmi.program.python_form import load_python

BOX = {
    "shape": {"box": {"length": 20.0, "width": 8.0, "draft": 3.0, "freeboard": 3.0}},
    "center_of_gravity": [0.0, 0.0, -0.5],
    "panels": 300,
}
BUOY = {
    "shape": {"revolved": {"profile": [[2.0, -5.0], [6.0, -1.0], [6.0, 0.5], [3.0, 3.0]]}},
    "center_of_gravity": [0.4, -0.3, -2.0],
    "panels": 500,
}
UPRIGHT = (0.0, 0.0, 0.0)


@pytest.mark.verifies(
    "volume of a sphere below the water at any heave: order in the size of panels",
    analytic="spherical cap",
    tolerance="order 2 ± 0.3",
)
def test_caps_of_a_sphere_converge_with_second_order() -> None:
    errors = []
    for panels in (300, 1200, 4800):
        load = hull_load(
            {"shape": {"sphere": {"radius": 5.0}}, "center_of_gravity": [0, -2], "panels": panels}
        )
        heights = np.linspace(-4.5, 4.5, 13)
        found = [load.at((0, 0, z - 2), UPRIGHT, 0.0) for z in heights.tolist()]
        volumes = np.array([one.wetted_volume for one in found])
        depth = 5.0 - heights
        errors.append(np.abs(volumes - math.pi * depth**2 * (15.0 - depth) / 3.0).max())
        forces = np.array([one.hydrostatic[2] for one in found])
        np.testing.assert_allclose(forces, RHO * G * volumes, rtol=1e-12)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.mean() == pytest.approx(2.0, abs=0.3)
    assert errors[-1] < 2e-4 * 4 / 3 * math.pi * 125.0


@pytest.mark.verifies(
    "righting moment of a box heeled and trimmed by 30 deg",
    analytic="wall-sided formula, (GM + BM tan²φ/2) sin φ",
    tolerance="1e-9",
)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_box_heels_as_wall_sided(axis: int) -> None:
    angle, sides = math.radians(30.0 if axis == 0 else -8.0), (20.0, 8.0)
    angles = np.zeros(3)
    angles[axis] = angle
    center = 0.0, -0.5 * -math.sin(angle) * (axis == 0), -0.5 * math.cos(angle)
    center = (-0.5 * math.sin(angle) * (axis == 1), *center[1:])
    load = hull_load(BOX).at(center, angles.tolist(), 0.0)
    weight, side = RHO * G * 20.0 * 8.0 * 3.0, sides[1 - axis]
    assert load.hydrostatic[2] == pytest.approx(weight, rel=1e-9)
    radius = side**2 / 12.0 / 3.0
    height = radius - 1.5 + 0.5
    lever = (height + 0.5 * radius * math.tan(angle) ** 2) * math.sin(angle)
    assert load.hydrostatic[3 + axis] == pytest.approx(-weight * lever, rel=1e-9)
    others = np.delete(load.hydrostatic, [2, 3 + axis])
    np.testing.assert_allclose(others, 0.0, atol=1e-9 * weight)


@pytest.mark.verifies(
    "difference from linear hydrostatics, over the amplitude",
    analytic="buoyancy and stiffness of the reference pose",
    tolerance="order 2 ± 0.1",
)
@pytest.mark.parametrize("body", [BOX, BUOY], ids=["box", "buoy"])
def test_small_motions_are_linear_but_for_second_order(body: dict) -> None:
    """The linear part is that of the same panels cut at z = 0, by Capytaine."""
    capytaine = import_capytaine()
    load, panels = hull_load(body), surface(body)
    cut = capytaine.Mesh(panels.vertices, panels.faces, auto_check=False).immersed_part()
    known = hydrostatics_of(Panels(np.asarray(cut.vertices), np.asarray(cut.faces)))
    center = body["center_of_gravity"]
    direction = np.array([0.3, -0.5, 1.0, 0.08, -0.06, 0.1])
    buoyancy, stiffness = known.buoyancy(center, RHO, G), known.stiffness(center, RHO, G)
    differences = []
    for size in (0.1, 0.05, 0.025):
        moved = size * direction
        force = load.at(center + moved[:3], moved[3:].tolist(), 0.0).hydrostatic
        differences.append(np.linalg.norm(force - (buoyancy - stiffness @ moved)))
    orders = np.log2(np.array(differences[:-1]) / differences[1:])
    assert orders == pytest.approx(2.0, abs=0.1)


@pytest.mark.verifies(
    "work of still water around a closed path of poses, over its largest part",
    analytic="hydrostatic forces are conservative",
    tolerance="1e-6",
)
@pytest.mark.parametrize("body", [BOX, BUOY], ids=["box", "buoy"])
def test_still_water_does_no_work_around_a_closed_path(body: dict) -> None:
    load, steps = hull_load(body), 4000
    powers = []
    for s in (2 * math.pi * np.arange(steps) / steps).tolist():
        place = [math.sin(2 * s), 0.5 * math.cos(s), -0.5 + 2.0 * math.sin(s)]
        rates = [2 * math.cos(2 * s), -0.5 * math.sin(s), 2.0 * math.cos(s)]
        phi, theta, psi = 0.6 * math.cos(s), 0.4 * math.sin(s + 1), 0.5 * math.sin(3 * s)
        d_phi, d_theta = -0.6 * math.sin(s), 0.4 * math.cos(s + 1)
        d_psi = 1.5 * math.cos(3 * s)
        # ω = ψ' e_z + θ' R_z e_y + φ' R_z R_y e_x
        c, d = math.cos(psi), math.sin(psi)
        turn = [
            -d * d_theta + c * math.cos(theta) * d_phi,
            c * d_theta + d * math.cos(theta) * d_phi,
            d_psi - math.sin(theta) * d_phi,
        ]
        powers.append(load.at(place, (phi, theta, psi), 0.0).hydrostatic @ [*rates, *turn])
    work = np.cumsum(powers)
    assert abs(work[-1]) < 1e-6 * np.ptp(work)


@pytest.mark.verifies(
    "Froude-Krylov force in small waves, over amplitude: what is left is of first order in it",
    independent="linear excitation over Capytaine's panels",
    tolerance="order 1 ± 0.15",
)
@pytest.mark.parametrize("depth", [math.inf, 15.0], ids=["deep", "shallow"])
def test_small_waves_press_as_linear_ones(depth: float) -> None:
    wave = {"spectrum": "regular", "period": 5.0, "phase": 0.3, "ramp_time": 0.0, "direction": 40.0}
    body = {**BUOY, "panels": 2000}
    water = Water(depth=depth)
    config = HydrodynamicsConfig.model_validate(
        {
            "dimensions": 3,
            "bodies": {"hull": {**body, "panels": 1500}},
            "water": {"depth": depth},
        }
    )
    omega = 2 * math.pi / 5.0
    hulls = make_hulls(config, Path(), progress=lambda _: None)
    still = without_flow(hulls, water=water, omega=np.array([omega]), wave_direction=40.0)
    linear = excited_by(still, hulls, ("froude_krylov",)).excitation[0]
    rates, times = [], np.arange(3) * 0.7
    expected = (linear[:, None] * np.exp(-1j * (omega * times + 0.3))).real
    for height in (0.4, 0.2, 0.1):
        load = hull_load(body, waves={**wave, "height": height}, water={"depth": depth})
        place = body["center_of_gravity"]
        found = [load.at(place, UPRIGHT, t).froude_krylov for t in times.tolist()]
        rates.append(np.array(found).T / (0.5 * height))
    shrinking = [np.linalg.norm(a - b) for a, b in pairwise(rates)]
    assert math.log2(shrinking[0] / shrinking[1]) == pytest.approx(1.0, abs=0.15)
    limit = 2 * rates[-1] - rates[-2]
    scale = np.abs(linear).reshape(2, 3).max(axis=1).repeat(3)[:, None]
    np.testing.assert_allclose(limit / scale, expected / scale, atol=0.01)


def test_the_sea_is_that_of_the_linear_load() -> None:
    """The same keys make the same elevation; the surface there is the waterline."""
    sea = {"spectrum": "jonswap", "significant_height": 1.5, "peak_period": 6.0, "seed": 3}
    config = HydrodynamicsConfig.model_validate(
        {
            "bodies": {
                "hull": {"shape": {"sphere": {"radius": 2.0}}, "center_of_gravity": [0.0, -0.5]}
            },
            "waves": sea,
            "water": {"depth": 20.0},
        }
    )
    hulls = make_hulls(config, Path(), progress=lambda _: None)
    omega = np.linspace(0.3, 3.0, 20)
    still = without_flow(hulls, water=config.water, omega=omega)
    program = hydrodynamics_program(still, waves=config.waves, drag={"hull": Drag()})
    form, parameters = load_python(program), [v.start for v in program.parameters]
    column = [v.name for v in program.outputs].index("wave.elevation")
    body = {"shape": {"sphere": {"radius": 2.0}}, "center_of_gravity": [0.0, -0.5]}
    load = hull_load(body, waves=sea, water={"depth": 20.0})
    for time in (0.0, 5.0, 40.0):
        inputs, constants = [v.start for v in program.inputs], form.constants(parameters)
        states = [0.0] * len(program.states)
        expected = form.outputs(time, states, inputs, parameters, constants)[column]
        found = load.at((0.0, 0.0, -0.5), UPRIGHT, time)
        assert found.water_level == pytest.approx(expected, abs=1e-12)


def test_a_hull_deep_in_the_trough_and_on_the_crest_of_a_long_wave() -> None:
    """A very long wave lifts the still water: the load is that of a hull lowered by η."""
    wave = {"spectrum": "regular", "period": 60.0, "height": 4.0, "ramp_time": 0.0}
    in_waves, still = hull_load(BUOY, waves=wave), hull_load(BUOY)
    x, y, z = BUOY["center_of_gravity"]
    for time in (0.0, 13.0, 30.0):
        load = in_waves.at((x, y, z), UPRIGHT, time)
        lowered = still.at((x, y, z - load.water_level), UPRIGHT, 0.0)
        assert load.wetted_volume == pytest.approx(lowered.wetted_volume, rel=2e-3)
        whole = load.hydrostatic[2] + load.froude_krylov[2]
        # the wave's pressure falls with depth by k z: k = 1.1e-3 rad/m, 3 m, of 2 m of elevation
        assert whole == pytest.approx(lowered.hydrostatic[2], rel=5e-3)
    assert abs(in_waves.at((x, y, z), UPRIGHT, 0.0).water_level - 2.0) < 1e-3


BARGE = """
name: barge
dimensions: 3
gravity: 9.81
bodies: {hull: {mass: neutral, inertia: [5.0e+6, 2.0e+7, 2.2e+7]}}
joints: {sea: {type: floating, child: hull, initial: {z: -0.5}}}
"""
ROLLS = """
name: roll
components:
  barge: {model: barge.model.yaml, start: {body.hull.phi: 1 deg}}
  water:
    kind: hull_pressure
    dimensions: 3
    bodies:
      hull:
        shape: {box: {length: 20, width: 8, draft: 3, freeboard: 3}}
        center_of_gravity: [0, 0, -0.5]
        panels: 300
connections: [barge.hull <-> water.hull]
simulation: {stop_time: 8, step_size: 0.1}
"""


@pytest.mark.verifies(
    "period of a floating box in roll, from its FMUs, without added mass",
    analytic="metacentric height",
    tolerance="1e-3",
)
def test_a_barge_rolls_with_the_period_of_its_metacentric_height(tmp_path: Path) -> None:
    """One connection carries motion, force and neutral mass, in space."""
    (tmp_path / "barge.model.yaml").write_text(BARGE)
    (tmp_path / "roll.system.yaml").write_text(ROLLS)
    outcome = run(
        load_system(tmp_path / "roll.system.yaml"),
        results=tmp_path / "roll.nc",
        build_directory=tmp_path,
        certify=False,
    )
    results = outcome.results()
    roll, weight = results["barge.body.hull.phi"].values, RHO * G * 480.0
    height = 64.0 / 36.0 - 1.5 + 0.5
    # half a period after the start it is at rest on the other side
    k = int(np.argmin(roll))
    before, here, after = roll[k - 1 : k + 2]
    half = results.time[k] + 0.1 * 0.5 * (before - after) / (before - 2 * here + after)
    assert 2 * half == pytest.approx(2 * math.pi * math.sqrt(5e6 / (weight * height)), rel=1e-3)
    assert results["water.hull.wetted_volume"].values == pytest.approx(480.0, rel=1e-3)
