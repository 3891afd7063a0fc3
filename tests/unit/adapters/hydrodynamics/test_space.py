"""Hydrodynamics in six degrees of freedom: a hull without symmetry, headings, wave directions."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_adapters.hydrodynamics import Coefficients, HydrodynamicsConfig
from m4e_adapters.hydrodynamics.config import Box, Drag, Radiation, Regular
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import make_hulls
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python

OMEGA = np.linspace(0.3, 3.6, 12)
CHECKED = (1, 5)  # of these, by Capytaine alone
WEDGE = """\
dimensions: 3
water: {depth: 30}
bodies:
  ship:
    shape: {mesh: wedge.stl}
    center_of_gravity: [0.4, 0.3, -0.5]
waves: {spectrum: regular, height: 1.0, period: 6.0, direction: 70}
"""
CORNERS = np.array([[-3, -1.5, -1], [4, -1, -1.6], [3, 2, -1.2], [-2.5, 1, -2], [0.5, 0.2, -2.4]])


def write_wedge(folder: Path) -> None:
    """A hull without any symmetry, in the water from z = 0 down to five points."""
    top = CORNERS[:4] * [1.2, 1.2, 0.0]
    low, keel = CORNERS[:4], CORNERS[4]
    facets = []
    for k in range(4):
        after = (k + 1) % 4
        for a in np.linspace(0, 1, 3)[:-1]:
            b = a + 0.5
            quad = [
                (1 - s) * (1 - t) * top[k] + s * (1 - t) * top[after]
                + (1 - s) * t * low[k] + s * t * low[after]
                for s, t in ((0, a), (0, b), (1, b), (1, a))
            ]  # fmt: skip
            facets += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
        facets.append([low[k], keel, low[after]])
    lines = ["solid wedge"]
    for facet in facets:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}" for p in facet]
        lines += ["endloop", "endfacet"]
    (folder / "wedge.stl").write_text("\n".join([*lines, "endsolid wedge", ""]))


def validated(text: str) -> HydrodynamicsConfig:
    return Document.parse(text).validate(HydrodynamicsConfig)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("wedge")
    write_wedge(found)
    return found


@pytest.fixture(scope="module")
def wedge(folder: Path) -> Coefficients:
    config = validated(WEDGE)
    hulls = make_hulls(config, folder, progress=lambda _: None)
    return solve_hulls(
        hulls, water=config.water, omega=OMEGA, wave_direction=70.0, progress=lambda _: None
    )


@pytest.mark.verifies(
    "coefficients of a hull without symmetry in six degrees of freedom",
    cross_code="Capytaine, called directly",
    tolerance="1e-10; excitation between its directions 1e-6",
)
def test_a_hull_without_symmetry_has_capytaines_coefficients(
    wedge: Coefficients, folder: Path
) -> None:
    from m4e_adapters.hydrodynamics.flow.capytaine_setup import (
        accurate_finite_depth,
        import_capytaine,
    )

    capytaine: Any = import_capytaine()
    (hull,) = make_hulls(validated(WEDGE), folder, progress=lambda _: None)
    mesh = capytaine.Mesh(hull.panels.vertices, hull.panels.faces)
    assert hull.lid is not None
    lid = capytaine.Mesh(hull.lid.vertices, hull.lid.faces)
    dofs = capytaine.rigid_body_dofs(rotation_center=(0.4, 0.3, -0.5))
    body = capytaine.FloatingBody(mesh=mesh, lid_mesh=lid, dofs=dofs)
    solver = capytaine.BEMSolver(method="direct")
    names = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
    for k in CHECKED:
        common = {
            "body": body,
            "omega": float(OMEGA[k]),
            "water_depth": 30.0,
            "rho": 1025.0,
            "g": 9.81,
        }
        with accurate_finite_depth():
            for j, name in enumerate(names):
                problem = capytaine.RadiationProblem(radiating_dof=name, **common)
                found: Any = solver.solve(problem)
                for ours, theirs in (
                    (wedge.added_mass, found.added_masses),
                    (wedge.radiation_damping, found.radiation_dampings),
                ):
                    expected = [theirs[i] for i in names]
                    size = np.abs(ours[k]).max()
                    np.testing.assert_allclose(ours[k, :, j], expected, atol=1e-10 * size)
            wave = capytaine.DiffractionProblem(wave_direction=math.radians(70.0), **common)
            scattered = solver.solve(wave).forces
            incident = capytaine.bem.airy_waves.froude_krylov_force(wave)
        expected = np.array([scattered[i] + incident[i] for i in names])
        size = np.abs(expected).max()
        np.testing.assert_allclose(wedge.excitation[k], expected, atol=1e-6 * size)
    assert np.abs(wedge.added_mass[0, 1, 4]) > 1e-3 * wedge.added_mass[0, 1, 1]


@pytest.fixture(scope="module")
def smooth(wedge: Coefficients) -> Coefficients:
    """The wedge with a memory K = 0.5 A∞ jω/(ω₀² − ω² + jω ω₀), which couples all motions.

    Its panels, few and large, make no memory without negative damping.
    """
    added = 0.5 * (wedge.added_mass_inf + wedge.added_mass_inf.T)
    s = 1j * OMEGA[:, None, None]
    memory = 0.5 * added * s / (s**2 + s + 1.0)
    return replace(
        wedge,
        resolved=(),
        added_mass_inf=added,
        added_mass=added + memory.imag / s.imag,
        radiation_damping=memory.real,
    )


STATE = {
    "x": 0.6, "y": 0.1, "z": -0.4, "phi": 0.05, "theta": -0.03, "psi": 0.02,
    "vx": 0.3, "vy": -0.7, "vz": 0.4, "omega_x": 0.1, "omega": -0.2, "omega_z": 0.15,
}  # fmt: skip
MEMORY = Radiation(order=2)
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")


def turned(vector: list[float], degrees: float) -> np.ndarray:
    """A vector with two components turned about Z; the third stays."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = vector
    return np.array([c * x - s * y, s * x + c * y, z])


def evaluated(program: Program, motion: dict[str, float]) -> dict[str, float]:
    """Outputs and calculated parameters at 7.3 s, with states of the memory that are not 0."""
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c = form.constants(p)
    u = [motion.get(v.name.removeprefix("ship."), v.start) for v in program.inputs]
    x = [0.01 * k * v.name.startswith("ship.") for k, v in enumerate(program.states)]
    names = [v.name for v in (*program.outputs, *program.calculated)]
    values = [*form.outputs(7.3, x, u, p, c), *form.calculated(p, c)]
    return dict(zip(names, values, strict=True))


def load(coefficients: Coefficients, heading: float, direction: float = 70.0) -> Program:
    """The load in a regular wave, and with drag, all turned by `heading` [deg]."""
    waves = Regular(
        spectrum="regular", height=1.0, period=6.0, direction=direction + heading, ramp_time=0.0
    )
    drag = {"ship": Drag(surge=2e3, sway=5e3, roll=1e4, yaw=3e3)}
    return hydrodynamics_program(
        coefficients, waves=waves, drag=drag, radiation=MEMORY, heading=Heading(heading)
    )


def motion_turned(motion: dict[str, float], degrees: float) -> dict[str, float]:
    """Places and velocities turned about the Z axis, and the yaw with them."""
    found = dict(motion)
    for names in (("x", "y", "z"), ("vx", "vy", "vz"), ("omega_x", "omega", "omega_z")):
        found |= zip(names, turned([motion[n] for n in names], degrees).tolist(), strict=True)
    found["psi"] += math.radians(degrees)
    return found


def test_all_that_is_turned_by_37_deg_gives_turned_forces(smooth: Coefficients) -> None:
    """Hull, waves and motion, about the Z axis of the world."""
    center = turned(smooth.centers[0].tolist(), 37.0)
    straight = evaluated(load(smooth, 0.0), STATE)
    moved = replace(smooth, centers=center[None, :])
    aside = evaluated(load(moved, 37.0), motion_turned(STATE, 37.0))
    for part in ("", "excitation_", "radiation_"):
        for names in (FORCES[:3], FORCES[3:]):
            expected = turned([straight[f"ship.{part}{n}"] for n in names], 37.0)
            assert np.abs(expected).max() > 0
            found = [aside[f"ship.{part}{n}"] for n in names]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * max(abs(expected)))
    one, other = (
        np.array([[v[f"added_mass[{i},{j}]"] for j in range(1, 7)] for i in range(1, 7)])
        for v in (straight, aside)
    )
    turn = np.kron(np.eye(2), np.column_stack([turned(list(row), 37.0) for row in np.eye(3)]))
    np.testing.assert_allclose(other, turn @ one @ turn.T, atol=1e-10 * np.abs(one).max())


def test_the_heading_follows_the_yaw(smooth: Coefficients) -> None:
    """As ḣ = sin(ψ − h)/T from the heading of the reference pose; then the load is turned."""
    waves = Regular(spectrum="regular", height=1.0, period=6.0, direction=70.0, ramp_time=0.0)
    program = hydrodynamics_program(
        smooth, waves=waves, radiation=MEMORY, heading=Heading(10.0, filter_time=20.0)
    )
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c = form.constants(p)
    states, inputs = [v.name for v in program.states], [v.name for v in program.inputs]
    x, u = [0.0] * len(states), [v.start for v in program.inputs]
    place = states.index("heading_change")
    u[inputs.index("ship.psi")] = math.radians(37.0)
    rate = form.rates(0.0, x, u, p, c)[place]
    assert rate == pytest.approx(math.sin(math.radians(27.0)) / 20.0, rel=1e-12)
    x[place] = math.radians(27.0)
    assert form.rates(0.0, x, u, p, c)[place] == pytest.approx(0.0, abs=1e-15)
    names = [v.name for v in program.outputs]
    filtered = dict(zip(names, form.outputs(7.3, x, u, p, c), strict=True))
    fixed = hydrodynamics_program(smooth, waves=waves, radiation=MEMORY, heading=Heading(37.0))
    form = load_python(fixed)
    p = [v.start for v in fixed.parameters]
    u = [v.start for v in fixed.inputs]
    values = form.outputs(7.3, [0.0] * len(fixed.states), u, p, form.constants(p))
    for variable, value in zip(fixed.outputs, values, strict=True):
        assert filtered[variable.name] == pytest.approx(value, rel=1e-9, abs=1e-6)
    for variable, value in zip(
        fixed.calculated, form.calculated(p, form.constants(p)), strict=True
    ):
        if variable.name.startswith("added_mass["):
            assert filtered[variable.name] == pytest.approx(value, rel=1e-9, abs=1e-6)


BOX = """dimensions: 3
bodies:
  ship:
    shape: {box: {length: 8, width: 4, draft: 1.5}}
    center_of_gravity: [0, 0, -0.5]
    panels: 48
"""


def test_a_symmetric_hull_has_zeros_where_symmetry_says_so(tmp_path: Path) -> None:
    """Of a box only surge and pitch, sway and roll are coupled; head waves excite no sway."""
    config = validated(BOX)
    hulls = make_hulls(config, tmp_path, progress=lambda _: None)
    found = solve_hulls(hulls, water=config.water, omega=OMEGA[:1], progress=lambda _: None)
    coupled = {(0, 4), (4, 0), (1, 3), (3, 1)}
    for matrix in (found.added_mass[0], found.radiation_damping[0], found.added_mass_inf):
        nonzero = {(int(i), int(j)) for i, j in np.argwhere(matrix) if i != j}
        assert nonzero == coupled
    assert np.all(np.abs(found.excitation[0, [1, 3, 5]]) < 1e-10 * np.abs(found.excitation).max())


def test_stiffness_is_the_change_of_buoyancy_of_a_moved_box() -> None:
    """A box aside of its centre of gravity: slender upright columns, to first order in angles."""
    center, n = np.array([0.5, -0.4, 0.3]), 400
    shape = Box(length=4.0, width=2.0, draft=1.0, center_x=0.2, center_y=0.7)
    hydrostatics = hydrostatics_of(box_panels(shape, 48))
    x = 0.2 + 4.0 * ((np.arange(n) + 0.5) / n - 0.5)
    y = 0.7 + 2.0 * ((np.arange(n) + 0.5) / n - 0.5)
    arms = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1) - center[:2]
    area = 8.0 / n**2

    def wrench(heave: float, roll: float, pitch: float, yaw: float) -> np.ndarray:
        """Of columns from the bottom at z = -1 to the water, each turned about the centre."""
        ax, ay = arms[..., 0], arms[..., 1]
        depth = 1.0 - heave - roll * ay + pitch * ax
        middle = -1.0 + depth / 2 - center[2]
        lift = 1025.0 * 9.81 * area * depth
        across, along = ay + yaw * ax - roll * middle, ax - yaw * ay + pitch * middle
        return np.array([0, 0, lift.sum(), (across * lift).sum(), -(along * lift).sum(), 0])

    scale, step = 1025.0 * 9.81 * 8.0, 1e-4
    np.testing.assert_allclose(
        hydrostatics.buoyancy(center.tolist(), 1025.0, 9.81), wrench(0, 0, 0, 0), atol=1e-9 * scale
    )
    stiffness = hydrostatics.stiffness(center.tolist(), 1025.0, 9.81)
    for k in range(4):
        after, before = (wrench(*(sign * step * np.eye(4)[k])) for sign in (1, -1))
        # columns resolve the second moments to 1/(12 n²)
        change = (before - after) / (2 * step)
        np.testing.assert_allclose(stiffness[:, 2 + k], change, atol=1e-5 * scale)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("[0, 0, -0.5]", "[0, -0.5]", 5, "'center_of_gravity' has 2 coordinates"),
        ("dimensions: 3\n", "", 4, "'center_of_gravity' has 3 coordinates, expected [x, z]"),
        ("dimensions: 3", "heading: 30", 1, "'heading' is of space"),
        ("dimensions: 3", "dimensions: 4", 1, "known: 2, 3"),
        ("panels: 48", "drag: {swey: 1}", 6, "did you mean 'sway'?"),
    ],
)
def test_keys_of_another_dimension_are_told(old: str, new: str, line: int, message: str) -> None:
    with pytest.raises(InputError) as caught:
        validated(BOX.replace(old, new, 1))
    assert message in str(caught.value)
    assert caught.value.problems[0].line == line
