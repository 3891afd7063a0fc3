"""Two bodies in one water in space, one of them submerged: coefficients, and a turned world."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_adapters.hydrodynamics import Coefficients, HydrodynamicsConfig
from m4e_adapters.hydrodynamics.config import Radiation, Regular
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.mesh import make_hulls
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_fmi.files.document import Document
from m4e_fmi.program.python_form import load_python

OMEGA = np.linspace(0.4, 3.0, 8)
BODIES = ("barge", "keel")
CENTERS = np.array([[-1.5, -2.5, -0.5], [1.5, 2.5, -4.0]])  # about the origin
FILE = """\
dimensions: 3
water: {depth: 40}
bodies:
  barge:
    shape: {box: {length: 6, width: 3, draft: 1.2}}
    center_of_gravity: [-1.5, -2.5, -0.5]
    panels: 60
  keel:
    shape: {mesh: keel.stl}
    center_of_gravity: [1.5, 2.5, -4]
"""


def write_keel(folder: Path) -> None:
    """A submerged ellipsoid about (1.7, 2.5, −4), its axes along none of the water's."""
    u, v = np.meshgrid(np.linspace(0, 2 * math.pi, 9), np.linspace(0, math.pi, 7), indexing="ij")
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    c, s = math.cos(0.5), math.sin(0.5)
    stretch = np.array([[c, -s, 0], [s, c, 0.2], [0, 0, 1]]) @ np.diag([2.0, 1.0, 0.7])
    points = ball @ stretch.T + [1.7, 2.5, -4.0]
    lines = ["solid keel"]
    for i in range(8):
        for j in range(6):
            a, b, d, e = points[i, j], points[i + 1, j], points[i + 1, j + 1], points[i, j + 1]
            for facet in ([a, d, b], [a, e, d]):
                sides = facet[1] - facet[0], facet[2] - facet[0]
                if np.linalg.norm(np.cross(*sides)) < 1e-9:
                    continue  # at the poles
                lines += ["facet normal 0 0 0", "outer loop"]
                lines += [f"vertex {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}" for p in facet]
                lines += ["endloop", "endfacet"]
    (folder / "keel.stl").write_text("\n".join([*lines, "endsolid keel", ""]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("bodies")
    write_keel(found)
    return found


def hulls_of(folder: Path) -> tuple[HydrodynamicsConfig, Any]:
    config = Document.parse(FILE).validate(HydrodynamicsConfig)
    return config, make_hulls(config, folder, progress=lambda _: None)


@pytest.fixture(scope="module")
def found(folder: Path) -> Coefficients:
    config, hulls = hulls_of(folder)
    return solve_hulls(
        hulls, water=config.water, omega=OMEGA, wave_direction=25.0, progress=lambda _: None
    )


@pytest.mark.verifies(
    "coefficients of two bodies in space, one submerged", cross_code="Capytaine, called directly",
    tolerance="1e-9; excitation between its directions 1e-6",
)  # fmt: skip
def test_two_bodies_have_capytaines_coefficients(found: Coefficients, folder: Path) -> None:
    from m4e_adapters.hydrodynamics.flow.capytaine_setup import (
        accurate_finite_depth,
        import_capytaine,
    )

    capytaine: Any = import_capytaine()
    parts = []
    for hull, name, center in zip(hulls_of(folder)[1], BODIES, CENTERS, strict=True):
        lid = hull.lid and capytaine.Mesh(hull.lid.vertices, hull.lid.faces)
        parts.append(
            capytaine.FloatingBody(
                mesh=capytaine.Mesh(hull.panels.vertices, hull.panels.faces),
                lid_mesh=lid or None,
                dofs=capytaine.rigid_body_dofs(rotation_center=tuple(center)),
                name=name,
            )
        )
    both = parts[0] + parts[1]
    motions = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
    names = [f"{body}__{motion}" for body in BODIES for motion in motions]
    solver, k = capytaine.BEMSolver(method="direct"), 3
    common = {
        "body": both, "omega": float(OMEGA[k]), "water_depth": 40.0, "rho": 1025.0, "g": 9.81,
    }  # fmt: skip
    with accurate_finite_depth():
        for j, name in enumerate(names):
            solved = solver.solve(capytaine.RadiationProblem(radiating_dof=name, **common))
            for ours, theirs in (
                (found.added_mass, solved.added_masses),
                (found.radiation_damping, solved.radiation_dampings),
            ):
                expected = [theirs[i] for i in names]
                size = np.abs(ours[k]).max()
                np.testing.assert_allclose(ours[k, :, j], expected, atol=1e-9 * size)
        wave = capytaine.DiffractionProblem(wave_direction=math.radians(25.0), **common)
        scattered = solver.solve(wave).forces
        incident = capytaine.bem.airy_waves.froude_krylov_force(wave)
    expected = np.array([scattered[i] + incident[i] for i in names])
    np.testing.assert_allclose(found.excitation[k], expected, atol=1e-6 * np.abs(expected).max())
    assert np.abs(found.added_mass[k, :6, 6:]).max() > 1e-3 * np.abs(found.added_mass[k]).max()


def test_a_submerged_body_has_buoyancy_and_no_waterplane(found: Coefficients) -> None:
    own = found.own(1)
    stiffness, buoyancy = found.hydrostatic_stiffness[own, own], found.buoyancy[own]
    assert np.abs(stiffness[2]).max() < 1e-6 * buoyancy[2]  # heave changes nothing
    arm = buoyancy[4] / -buoyancy[2]  # the centre of buoyancy is 0.2 m ahead
    assert arm == pytest.approx(0.2, abs=0.01)
    assert stiffness[3, 5] == pytest.approx(-buoyancy[2] * arm, rel=0.05)


def load(coefficients: Coefficients, turn: float) -> Any:
    waves = Regular(
        spectrum="regular", height=1.0, period=6.0, direction=25.0 + turn, ramp_time=0.0
    )
    heading = Heading(turn)
    return hydrodynamics_program(
        coefficients, waves=waves, radiation=Radiation(order=2), heading=heading
    )


def memory_of(found: Coefficients) -> Coefficients:
    """The same with a memory that couples all motions, and is passive whatever the panels."""
    added = 0.5 * (found.added_mass_inf + found.added_mass_inf.T)
    s = 1j * OMEGA[:, None, None]
    memory = 0.5 * added * s / (s**2 + s + 1.0)
    return replace(
        found, resolved=(), added_mass_inf=added, added_mass=added + memory.imag / s.imag,
        radiation_damping=memory.real,
    )  # fmt: skip


VECTORS = (("x", "y", "z"), ("vx", "vy", "vz"), ("omega_x", "omega", "omega_z"))


@pytest.mark.verifies(
    "loads on two bodies in a world turned by 37° about Z",
    analytic="symmetry: the same bodies, not turned", tolerance="1e-10",
)  # fmt: skip
def test_two_bodies_in_a_turned_world(found: Coefficients) -> None:
    smooth, r = memory_of(found), np.random.default_rng(4)
    angle = math.radians(37.0)
    turn = np.array(
        [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]]
    )
    straight: dict[str, float] = {}
    aside: dict[str, float] = {}
    for body, center in zip(BODIES, CENTERS, strict=True):
        for kind, names in enumerate(VECTORS):
            vector = 0.3 * r.uniform(-1, 1, 3)
            moved = turn @ vector
            if kind == 0:
                moved = turn @ (center + vector)
                vector = center + vector
            straight |= {f"{body}.{n}": v for n, v in zip(names, vector, strict=True)}
            aside |= {f"{body}.{n}": v for n, v in zip(names, moved, strict=True)}
        phi, theta, psi = 0.05 * r.uniform(-1, 1, 3)
        straight |= {f"{body}.phi": phi, f"{body}.theta": theta, f"{body}.psi": psi}
        aside |= {f"{body}.phi": phi, f"{body}.theta": theta, f"{body}.psi": psi + angle}
    one, other = outputs(load(smooth, 0.0), straight), outputs(load(smooth, 37.0), aside)
    for body in BODIES:
        for part in ("", "excitation_", "radiation_"):
            for names in (("force_x", "force_y", "force_z"), ("moment_x", "moment_y", "moment_z")):
                expected = turn @ [one[f"{body}.{part}{n}"] for n in names]
                assert np.abs(expected).max() > 0
                got = [other[f"{body}.{part}{n}"] for n in names]
                np.testing.assert_allclose(got, expected, atol=1e-10 * np.abs(expected).max())


def outputs(program: Any, motion: dict[str, float]) -> dict[str, float]:
    form = load_python(program)
    p = [v.start for v in program.parameters]
    u = [motion.get(v.name, v.start) for v in program.inputs]
    x = [0.01 * (k % 7) * ("radiation" in v.name) for k, v in enumerate(program.states)]
    values = form.outputs(7.3, x, u, p, form.constants(p))
    return dict(zip((v.name for v in program.outputs), values, strict=True))
