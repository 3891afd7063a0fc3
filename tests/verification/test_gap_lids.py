"""Damped lids in gaps: energy and resonance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.hulls import configured, hulls, silent

from m4e_adapters.hydrodynamics import Coefficients, HydrodynamicsConfig
from m4e_adapters.hydrodynamics.build import coefficients_of
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.flow.flow_solver import FlowSolver
from m4e_adapters.hydrodynamics.flow.gap_lid import damped_lid

GAP, RHO, G = 4.0, 1000.0, 9.81
LID = {"length": 16, "width": GAP}
SIDES = {
    "left": {"length": 16, "width": 8, "draft": 2, "center_y": -(8 + GAP) / 2},
    "right": {"length": 16, "width": 8, "draft": 2, "center_y": (8 + GAP) / 2},
}


def config(*lids: dict, **more: object) -> HydrodynamicsConfig:
    bodies = {
        name: {
            "shape": {"box": box},
            "center_of_gravity": [0, box["center_y"], 0],
            "panels": 120,
        }
        for name, box in SIDES.items()
    }
    given = {"dimensions": 3, "water": {"density": RHO, "gravity": G}, "bodies": bodies}
    return configured({**given, "gap_lids": list(lids), **more})


def solved(omega: list[float], *lids: dict) -> Coefficients:
    given = config(*lids)
    return coefficients_of(given, hulls(given), omega=np.array(omega), progress=silent)


def together(c: Coefficients) -> np.ndarray:
    """Damping (nω,) [N.s/m] of both heaving together, which pumps the water in the gap."""
    return c.radiation_damping[:, [2, 2, 8, 8], [2, 8, 2, 8]].sum(axis=1)


def waves_sent_out(c: Coefficients) -> np.ndarray:
    """The same (nω,) of the waves alone, by Haskind's relation from the excitation."""
    orders = np.arange(c.harmonics.shape[1]) - c.harmonics.shape[1] // 2
    beta = np.radians(np.arange(0.0, 360.0, 5.0))
    turns = np.exp(1j * np.outer(beta, orders))
    force = np.einsum("bj,wjn->wbn", turns, c.harmonics)
    ways = np.stack([c.way(c.omega, math.degrees(b)) for b in beta], axis=1)
    both = (force * ways)[:, :, [2, 8]].sum(axis=2)
    k = c.omega**2 / G
    factor = k / (8 * math.pi * RHO * G * (G / (2 * c.omega)))
    return factor * 2 * math.pi * (np.abs(both) ** 2).mean(axis=1)


@pytest.mark.verifies(
    "energy: damping of two barges with a damped lid in their gap",
    independent="waves sent out, by Haskind's relation, and the power of the lid",
    tolerance="2e-2",
)
def test_energy_and_resonance() -> None:
    """The peak falls, long waves change by little; lid and waves take all the power."""
    omega, damping = [0.4, 1.5], 0.1
    free, damped = solved(omega), solved(omega, {**LID, "damping": damping})
    lower = together(damped) / together(free)
    assert lower[1] < 0.75  # the resonance of the gap
    assert abs(lower[0] - 1) < 0.02
    np.testing.assert_allclose(damped.added_mass_inf, free.added_mass_inf, rtol=1e-9, atol=1e-3)
    lost = np.array([power_of_lid(w, damping) for w in omega])
    assert lost[1] > 0.2 * together(damped)[1]
    np.testing.assert_allclose(waves_sent_out(damped) + lost, together(damped), rtol=0.02)
    halves = [c.radiation_damping - c.radiation_damping.swapaxes(1, 2) for c in (free, damped)]
    assert np.abs(halves[1]).max() < 1.1 * np.abs(halves[0]).max()  # reciprocity, of coarse panels


def power_of_lid(omega: float, damping: float) -> float:
    """Damping [N.s/m] of the lid while both heave: ρ ν/g ∫ |φ|² dS, of a unit amplitude."""
    given = config({**LID, "damping": damping})
    made = hulls(given)
    solver = FlowSolver(made, given.water, damped_lid(given.gap_lids, made))
    capytaine, body = import_capytaine(), solver._body
    rates = solver._lid_rates
    assert rates is not None
    there, potential = rates > 0, np.zeros(len(rates), dtype=complex)
    water = {"rho": RHO, "g": G, "water_depth": math.inf}
    for name in body.dofs:
        if "Heave" in name:
            problem = capytaine.RadiationProblem(
                body=body, radiating_dof=name, omega=omega, **water
            )
            potential += solver._solver.solve(problem).potential
    areas = body.mesh_including_lid.faces_areas
    return RHO * damping / G * float(areas[there] @ np.abs(potential[there]) ** 2)
