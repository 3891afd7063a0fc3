"""Mean force on a body in deep water from the momentum through a cylinder around it.

F = −∫ (p̄ n + ρ mean(u u·n)) dS, n outwards, p̄ = −ρ/2 mean|u|², and −ρ g/2 mean(η²) n on the strip
at the waterline. Potential and velocity in the water are those of Capytaine's sources on the hull.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine, kept_warnings
from m4e_adapters.hydrodynamics.geometry.mesh import Hull

AROUND, DOWN, REACH = 32, 10, 4.0  # points around, down, depth in 1/k


def momentum_through_cylinder(
    hull: Hull, k: float, motions: np.ndarray, *, radius: float, density: float, g: float
) -> float:
    """F_x per squared amplitude [N/m2] in waves of the wavenumber `k` [rad/m] to +X.

    `motions` (3,) are surge, heave and pitch per amplitude about x = z = 0.
    """
    omega = math.sqrt(g * k)
    theta = 2.0 * math.pi / AROUND * np.arange(AROUND)
    nodes, weights = np.polynomial.legendre.leggauss(DOWN)
    z, down = 0.5 * REACH / k * (nodes - 1.0), 0.5 * REACH / k * weights
    ring = radius * np.stack([np.cos(theta), np.sin(theta)], axis=1)
    side = np.array([[x, y, level] for x, y in ring for level in z])
    edge = np.column_stack([ring, np.full(AROUND, -1e-6)])
    with kept_warnings():
        _, u = _flow(hull, k, motions, side, g)
        phi, _ = _flow(hull, k, motions, edge, g)
    normal = np.cos(np.repeat(theta, DOWN))
    out = u[:, 0] * normal + u[:, 1] * np.sin(np.repeat(theta, DOWN))
    area = np.tile(down, AROUND) * 2.0 * math.pi / AROUND * radius
    flux = 0.5 * np.real(u[:, 0] * out.conj()) - 0.25 * (np.abs(u) ** 2).sum(axis=1) * normal
    strip = 0.25 * g * (omega / g * np.abs(phi)) ** 2 @ np.cos(theta)
    return -density * float(flux @ area + strip * 2.0 * math.pi / AROUND * radius)


def _flow(
    hull: Hull, k: float, motions: np.ndarray, points: np.ndarray, g: float
) -> tuple[np.ndarray, np.ndarray]:
    """Potential (n,) [m2/s] and velocity (n, 3) [m/s] per amplitude of the wave at `points`."""
    cpt: Any = import_capytaine()
    omega = math.sqrt(g * k)
    body = cpt.FloatingBody(
        mesh=cpt.Mesh(hull.panels.vertices, hull.panels.faces),
        dofs=cpt.rigid_body_dofs(rotation_center=(0, 0, 0), only=["Surge", "Heave", "Pitch"]),
    )
    solver, common = cpt.BEMSolver(method="indirect"), {"body": body, "omega": omega, "g": g}
    diffraction = cpt.DiffractionProblem(wave_direction=0.0, **common)
    parts = [(1.0, diffraction)] + [
        (x, cpt.RadiationProblem(radiating_dof=name, **common))
        for x, name in zip(motions, ("Surge", "Heave", "Pitch"), strict=True)
    ]
    phi = cpt.bem.airy_waves.airy_waves_potential(points, diffraction)
    velocity = cpt.bem.airy_waves.airy_waves_velocity(points, diffraction)
    for factor, problem in parts:
        result = solver.solve(problem, keep_details=True)
        phi = phi + factor * solver.compute_potential(points, result)
        velocity = velocity + factor * solver.compute_velocity(points, result)
    return phi, velocity
