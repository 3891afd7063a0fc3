"""Hydrodynamics in six degrees of freedom: hulls without symmetry, headings, a turned world."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import mesh_writers
from support.hulls import configured, hulls, silent
from support.programs import Evaluated

from m4e_adapters.hydrodynamics import Coefficients, HydrodynamicsConfig
from m4e_adapters.hydrodynamics.config import Drag, Radiation, Regular
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.flow.capytaine_setup import accurate_finite_depth, import_capytaine
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_fmi.program import Program

OMEGA = np.linspace(0.4, 3.0, 8)
WEDGE = """\
dimensions: 3
water: {depth: 30}
bodies: {ship: {shape: {mesh: wedge.stl}, center_of_gravity: [0.4, 0.3, -0.5]}}
"""
TWO = """\
dimensions: 3
water: {depth: 40}
bodies:
  barge:
    shape: {box: {length: 6, width: 3, draft: 1.2}}
    center_of_gravity: [-1.5, -2.5, -0.5]
    panels: 60
  keel: {shape: {mesh: keel.stl}, center_of_gravity: [1.5, 2.5, -4]}
"""  # about the origin
FORCES, MOMENTS = ("force_x", "force_y", "force_z"), ("moment_x", "moment_y", "moment_z")


def wedge() -> Panels:
    """A hull without any symmetry, in the water from z = 0 down to five points."""
    low = np.array([[-3, -1.5, -1], [4, -1, -1.6], [3, 2, -1.2], [-2.5, 1, -2]])
    keel, ring = np.array([0.5, 0.2, -2.4]), [0, 1, 2, 3, 0]
    top = low * [1.2, 1.2, 0.0]
    points = np.array([top[ring], low[ring], np.tile(keel, (5, 1))])
    return grid(points.transpose(1, 0, 2)).merged().divided(2)


def keel() -> Panels:
    """A submerged ellipsoid about (1.7, 2.5, −4), its axes along none of the water's."""
    u, v = np.meshgrid(np.linspace(0, 2 * math.pi, 9), np.linspace(0, math.pi, 7), indexing="ij")
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    c, s = math.cos(0.5), math.sin(0.5)
    stretch = np.array([[c, -s, 0], [s, c, 0.2], [0, 0, 1]]) @ np.diag([2.0, 1.0, 0.7])
    return grid(ball @ stretch.T + [1.7, 2.5, -4.0]).merged()


def outwards(panels: Panels) -> Panels:
    """With normals into the water."""
    return panels if hydrostatics_of(panels).volume > 0 else panels.reversed


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("space")
    for name, panels in (("wedge", wedge()), ("keel", keel())):
        (found / f"{name}.stl").write_text(mesh_writers.stl(outwards(panels)))
    return found


Solved = tuple[HydrodynamicsConfig, tuple[Hull, ...], Coefficients]


def solved(text: str, direction: float, folder: Path) -> Solved:
    config = configured(text)
    made = hulls(config, folder)
    keys = {"water": config.water, "omega": OMEGA, "wave_direction": direction}
    return config, made, solve_hulls(made, **keys, progress=silent)


@pytest.fixture(scope="module")
def one(folder: Path) -> Solved:
    return solved(WEDGE, 70.0, folder)


@pytest.fixture(scope="module")
def two(folder: Path) -> Solved:
    return solved(TWO, 25.0, folder)


def check_by_capytaine(found: Solved, k: int, tolerance: float) -> None:
    """Coefficients at the `k`-th frequency, and the excitation, which is between directions."""
    config, made, ours = found
    capytaine: Any = import_capytaine()
    bodies = [
        capytaine.FloatingBody(
            mesh=capytaine.Mesh(hull.panels.vertices, hull.panels.faces),
            lid_mesh=hull.lid and capytaine.Mesh(hull.lid.vertices, hull.lid.faces),
            dofs=capytaine.rigid_body_dofs(rotation_center=tuple(hull.center)),
            name=hull.name,
        )
        for hull in made
    ]
    body = bodies[0] + bodies[1] if len(bodies) > 1 else bodies[0]
    names, solver = list(body.dofs), capytaine.BEMSolver(method="direct")
    water = {"water_depth": config.water.depth, "rho": 1025.0, "g": 9.81}
    common = {"body": body, "omega": float(OMEGA[k]), **water}
    with accurate_finite_depth():
        for j, name in enumerate(names):
            theirs = solver.solve(capytaine.RadiationProblem(radiating_dof=name, **common))
            for matrix, column in (
                (ours.added_mass[k], theirs.added_masses),
                (ours.radiation_damping[k], theirs.radiation_dampings),
            ):
                size = np.abs(matrix).max()
                expected = [column[i] for i in names]
                np.testing.assert_allclose(matrix[:, j], expected, atol=tolerance * size)
        beta = math.radians(ours.wave_direction)
        wave = capytaine.DiffractionProblem(wave_direction=beta, **common)
        scattered = solver.solve(wave).forces
        incident = capytaine.bem.airy_waves.froude_krylov_force(wave)
    expected = np.array([scattered[i] + incident[i] for i in names])
    np.testing.assert_allclose(ours.excitation[k], expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.verifies(
    "coefficients of a hull without symmetry in six degrees of freedom",
    independent="Capytaine, called directly",
    tolerance="1e-10",
)
def test_a_hull_without_symmetry_has_capytaines_coefficients(one: Solved) -> None:
    for k in (1, 4):
        check_by_capytaine(one, k, 1e-10)
    added = one[2].added_mass[0]
    assert np.abs(added[1, 4]) > 1e-3 * added[1, 1]


@pytest.mark.verifies(
    "coefficients of two bodies in space, one submerged", independent="Capytaine, called directly",
    tolerance="1e-9",
)  # fmt: skip
def test_two_bodies_have_capytaines_coefficients(two: Solved) -> None:
    check_by_capytaine(two, 3, 1e-9)
    added = two[2].added_mass[3]
    assert np.abs(added[:6, 6:]).max() > 1e-3 * np.abs(added).max()


def smooth(found: Coefficients) -> Coefficients:
    """The same with a memory K = 0.5 A∞ jω/(ω₀² − ω² + jω ω₀), which couples all motions.

    Few and large panels make no memory without negative damping.
    """
    added = 0.5 * (found.added_mass_inf + found.added_mass_inf.T)
    s = 1j * OMEGA[:, None, None]
    memory = 0.5 * added * s / (s**2 + s + 1.0)
    return replace(
        found, resolved=(), added_mass_inf=added, added_mass=added + memory.imag / s.imag,
        radiation_damping=memory.real,
    )  # fmt: skip


def load(coefficients: Coefficients, turn: float, direction: float = 25.0, **keys: Any) -> Program:
    """The load in a regular wave, and with drag, all turned by `turn` [deg]."""
    waves = Regular(
        spectrum="regular", height=1.0, period=6.0, direction=direction + turn, ramp_time=0.0
    )
    heading = keys.pop("heading", Heading(turn))
    return hydrodynamics_program(
        coefficients, waves=waves, radiation=Radiation(order=2), heading=heading, **keys
    )


def states(program: Program) -> dict[str, float]:
    """A memory that is not 0."""
    names = [v.name for v in program.states if "radiation" in v.name]
    return {name: 0.01 * (k % 7) for k, name in enumerate(names)}


@pytest.mark.verifies(
    "loads on two bodies in a world turned by 37° about Z",
    analytic="symmetry: the same bodies, not turned", tolerance="1e-10",
)  # fmt: skip
def test_two_bodies_in_a_turned_world(two: Solved) -> None:
    """Forces, and the added mass; no centre of gravity is on the axis."""
    found, r = smooth(two[2]), np.random.default_rng(4)
    c, s = math.cos(math.radians(37.0)), math.sin(math.radians(37.0))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    straight: dict[str, float] = {}
    aside: dict[str, float] = {}
    for body, center in zip(found.bodies, found.centers, strict=True):
        for names, origin in (("x y z", center), ("vx vy vz", 0.0), ("omega_x omega omega_z", 0.0)):
            vector = origin + 0.3 * r.uniform(-1, 1, 3)
            for values, given in ((straight, vector), (aside, turn @ vector)):
                values |= {f"{body}.{n}": v for n, v in zip(names.split(), given, strict=True)}
        angles = 0.05 * r.uniform(-1, 1, 3)
        for values, more in ((straight, 0.0), (aside, math.radians(37.0))):
            phi, theta, psi = (angles + np.array([0, 0, more])).tolist()
            values |= {f"{body}.phi": phi, f"{body}.theta": theta, f"{body}.psi": psi}
    drag = {"barge": Drag(surge=2e3, sway=5e3, roll=1e4, yaw=3e3)}
    programs = [load(found, angle, drag=drag) for angle in (0.0, 37.0)]
    one, other = (
        Evaluated(program).outputs({**values, **states(program)}, t=7.3)
        for program, values in zip(programs, (straight, aside), strict=True)
    )
    for body in found.bodies:
        for part in ("", "excitation_", "radiation_"):
            for names in (FORCES, MOMENTS):
                expected = turn @ [one[f"{body}.{part}{n}"] for n in names]
                assert np.abs(expected).max() > 0
                got = [other[f"{body}.{part}{n}"] for n in names]
                np.testing.assert_allclose(got, expected, atol=1e-10 * np.abs(expected).max())
    before, after = (
        np.array([[v[f"added_mass[{i},{j}]"] for j in range(1, 13)] for i in range(1, 13)])
        for v in (Evaluated(program).calculated({}) for program in programs)
    )
    turns = np.kron(np.eye(4), turn)
    np.testing.assert_allclose(after, turns @ before @ turns.T, atol=1e-10 * np.abs(before).max())


def test_a_symmetric_hull_has_zeros_where_symmetry_says_so() -> None:
    """Of a box only surge and pitch, sway and roll are coupled; head waves excite no sway."""
    box = "{shape: {box: {length: 8, width: 4, draft: 1.5}}, center_of_gravity: [0, 0, -0.5]"
    config = configured(f"dimensions: 3\nbodies: {{ship: {box}, panels: 48}}}}\n")
    found = solve_hulls(hulls(config), water=config.water, omega=OMEGA[:1], progress=silent)
    for matrix in (found.added_mass[0], found.radiation_damping[0], found.added_mass_inf):
        nonzero = {(int(i), int(j)) for i, j in np.argwhere(matrix) if i != j}
        assert nonzero == {(0, 4), (4, 0), (1, 3), (3, 1)}
    assert np.all(np.abs(found.excitation[0, [1, 3, 5]]) < 1e-10 * np.abs(found.excitation).max())
