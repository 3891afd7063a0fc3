"""Damping of our solution against the energy that its waves carry away."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics import make_hull, solve_hulls
from m4e_adapters.hydrodynamics.config import Body, Water
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine

RHO, G, OMEGA = 1000.0, 9.81, 1.6


@pytest.mark.verifies(
    "damping of a horizontal cylinder in surge and heave",
    analytic="energy of the waves far away, by Green's theorem",
    tolerance="1e-2",
)
def test_damping_is_the_energy_that_waves_carry_away() -> None:
    """B = 4π ρ k/ω ∫|H|² dβ in deep water, with the Kochin function of unit motion

        H(β) = 1/4π ∫ (∂φ/∂n − φ ∂/∂n) e^{kz − ik(x cos β + y sin β)} dS.

    B is the pressure on 204 panels, H the potential far away: what the panels lose is seen.
    """
    shape = {"horizontal_cylinder": {"radius": 2.0, "length": 8.0}}
    body = Body.model_validate({"shape": shape, "center_of_gravity": [0, -0.5], "panels": 200})
    hull = make_hull("float", body, Path(), progress=print)
    assert hull.lid is not None
    water = Water(density=RHO, gravity=G)
    damping = solve_hulls(
        [hull], water=water, omega=np.array([OMEGA]), progress=print
    ).radiation_damping[0]

    capytaine = import_capytaine()
    mesh, lid = (capytaine.Mesh(p.vertices, p.faces) for p in (hull.panels, hull.lid))
    dofs = capytaine.rigid_body_dofs(rotation_center=(0, 0, -0.5), only=["Surge", "Heave"])
    floating = capytaine.FloatingBody(mesh=mesh, lid_mesh=lid, dofs=dofs, name="float")
    solver, k = capytaine.BEMSolver(method="direct"), OMEGA**2 / G
    beta = np.linspace(0.0, 2 * math.pi, 36, endpoint=False)
    along = np.stack([np.cos(beta), np.sin(beta)])
    places, normals = mesh.faces_centers, mesh.faces_normals
    wave = np.exp(k * places[:, 2:] - 1j * k * places[:, :2] @ along)
    slope = k * (normals[:, 2:] - 1j * normals[:, :2] @ along) * wave
    for motion, name in enumerate(("Surge", "Heave")):
        problem = capytaine.RadiationProblem(
            body=floating, radiating_dof=name, omega=OMEGA, rho=RHO, g=G
        )
        result = solver.solve(problem, keep_details=True)
        count = mesh.nb_faces
        potential, flux = result.potential[:count], problem.boundary_condition[:count]
        kochin = mesh.faces_areas @ (flux[:, None] * wave - potential[:, None] * slope)
        energy = 2 * math.pi * np.mean(np.abs(kochin / (4 * math.pi)) ** 2)
        carried = 4 * math.pi * RHO * k / OMEGA * energy
        assert damping[motion, motion] == pytest.approx(carried, rel=1e-2)
