"""Coefficients of one mesh against exact solutions, over the frequencies."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.exact_flows import cylinder_forces, submerged_sphere
from support.hulls import silent

from m4e_adapters.hydrodynamics import Coefficients, make_hull, solve_hulls
from m4e_adapters.hydrodynamics.config import Body, Water
from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency

RADIUS, RHO, G = 5.0, 1000.0, 9.81
BED, APART, SUNK = 15.0, 20.0, 7.5  # m: depth of the piles, distance of two, depth of the sphere
BALL = 4 / 3 * math.pi * RHO * RADIUS**3  # kg


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest difference [1], over the largest value of all frequencies."""
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def piles(*places: float, wavenumbers: np.ndarray, panels: int) -> Coefficients:
    """Of cylinders at x = `places` [m] from the surface to the bed, `panels` each."""
    water = Water(density=RHO, gravity=G, depth=BED)
    hulls = []
    for k, x in enumerate(places):
        shape = {"cylinder": {"radius": RADIUS, "draft": BED, "center_x": x}}
        body = Body.model_validate({"shape": shape, "panels": panels, "fixed": True})
        hull = make_hull(f"pile{k}", body, Path(), depth=BED, progress=silent)
        hulls.append(replace(hull, fixed=False, center=(x, -BED / 2)))  # for its forces
    omega = angular_frequency(wavenumbers, depth=BED, gravity=G)
    return solve_hulls(hulls, water=water, omega=omega, progress=silent)


@pytest.mark.verifies(
    "added mass and damping of a submerged sphere in surge and heave, 1012 panels",
    analytic="multipoles and their images",
    tolerance="2e-2",
)
def test_submerged_sphere() -> None:
    """The error of surge, 1.1 %, is that of 1.8 % of 612 panels times 612/1012: of second order."""
    k = np.array([0.1, 0.3, 0.5, 0.7, 1.0, 1.3, 1.6, 2.0]) / RADIUS
    shape = {"sphere": {"radius": RADIUS, "center_z": -SUNK}}
    given = {"shape": shape, "center_of_gravity": [0, -2], "panels": 1000}
    hull = make_hull("ball", Body.model_validate(given), Path(), progress=silent)
    omega = angular_frequency(k, depth=math.inf, gravity=G)
    found = solve_hulls([hull], water=Water(density=RHO, gravity=G), omega=omega, progress=silent)
    for motion, mode in ((0, 1), (1, 0)):
        exact = BALL * np.array(
            [submerged_sphere(one, radius=RADIUS, depth=SUNK, mode=mode) for one in k]
        )
        assert error(found.added_mass[:, motion, motion], exact.real) < 2e-2
        assert error(found.radiation_damping[:, motion, motion], omega * exact.imag) < 2e-2


def test_multipoles_far_below_the_surface_and_their_damping_by_haskind() -> None:
    """In unbounded water A = ρV/2. The damping of a small sphere follows from its excitation,
    3/2 ρ V times the acceleration of the wave at its centre: B/ω = k ∫|X|² dβ/(4π ρ g²)."""
    assert submerged_sphere(1.0, radius=1.0, depth=40.0, mode=0) == pytest.approx(0.5, rel=1e-4)
    k, deep, volume = 1.0, 0.5, 4 / 3 * math.pi * 0.05**3
    for mode, directions in ((0, 2 * math.pi), (1, math.pi)):
        force = 1.5 * volume * k * math.exp(-k * deep)  # over ρ g and the amplitude
        expected = k * force**2 * directions / (4 * math.pi) / volume
        found = submerged_sphere(k, radius=0.05, depth=deep, mode=mode)
        assert found.imag == pytest.approx(expected, rel=2e-3)


@pytest.mark.verifies(
    "wave force on a cylinder from the surface to the sea bed, 828 panels",
    published="MacCamy and Fuchs (1954)",
    tolerance="5e-3",
)
def test_pile() -> None:
    k = np.array([0.3, 0.6, 1.0, 1.5]) / RADIUS
    exact = np.array(
        [cylinder_forces(one, radii=[RADIUS], places=[(0.0, 0.0)], depth=BED)[0, 0] for one in k]
    )
    assert error(piles(0.0, wavenumbers=k, panels=800).excitation[:, 0], exact) < 5e-3


@pytest.mark.verifies(
    "wave forces on two cylinders from the surface to the sea bed, in a row, 952 panels",
    published="Linton and Evans (1990)",
    tolerance="1e-2",
)
def test_two_piles() -> None:
    k = np.array([0.3, 0.6, 1.0, 1.4]) / RADIUS
    places = [(-APART / 2, 0.0), (APART / 2, 0.0)]
    exact = np.array(
        [cylinder_forces(one, radii=[RADIUS] * 2, places=places, depth=BED)[:, 0] for one in k]
    )
    alone = np.array(
        [cylinder_forces(one, radii=[RADIUS], places=places[:1], depth=BED)[0, 0] for one in k]
    )
    assert np.abs(np.abs(exact[:, 0]) / np.abs(alone) - 1).max() > 0.1  # they shelter each other
    found = piles(-APART / 2, APART / 2, wavenumbers=k, panels=450)
    assert error(found.excitation[:, 0], exact[:, 0]) < 1e-2
    assert error(found.excitation[:, 3], exact[:, 1]) < 1e-2


def test_one_cylinder_is_that_of_mac_camy_and_fuchs() -> None:
    """4 ρ g tanh(kh)/(k² |H₁′(ka)|), and cylinders far apart do not feel each other."""
    from scipy.special import h1vp

    k, a, h = 0.3, 2.0, 10.0
    expected = 4 * 1000 * 9.81 * math.tanh(k * h) / k**2 / abs(h1vp(1, k * a))
    one = cylinder_forces(k, radii=[a], places=[(0.0, 0.0)], depth=h)
    assert abs(one[0, 0]) == pytest.approx(expected, rel=1e-12)
    assert abs(one[0, 1]) < 1e-12 * expected
    far = cylinder_forces(k, radii=[a, a], places=[(0.0, 0.0), (0.0, 1e6)], depth=h)
    assert abs(far[0, 0]) == pytest.approx(expected, rel=1e-2)
    turned = cylinder_forces(k, radii=[a], places=[(0.0, 0.0)], depth=h, direction=0.7)
    np.testing.assert_allclose(
        turned[0], one[0, 0] * np.array([math.cos(0.7), math.sin(0.7)]), rtol=1e-9
    )
