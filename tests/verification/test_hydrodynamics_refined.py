"""Coefficients extrapolated from three meshes, and their stated errors, against exact solutions.

The tables of the meshes are stored; `make verify` computes them anew.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.exact_flows import cylinder_forces, submerged_sphere
from support.refined_cases import APART, BED, CASES, RADIUS, RHO, SUNK, largest, stored

from m4e_adapters.hydrodynamics import Refinement

DATA = Path(__file__).parents[1] / "data" / "hydrodynamics"
BALL = 4 / 3 * math.pi * RHO * RADIUS**3  # kg
HONEST = (1.0, 5.0)  # stated error over the true one, both the largest over the frequencies


def check(study: Refinement, quantity: str, motion: int, exact: np.ndarray, most: float) -> None:
    """That the limit differs by less than `most` of the largest value, and as stated."""
    place = (motion,) if quantity == "excitation" else (motion, motion)
    found = getattr(study, quantity)
    values = (getattr(study.meshes[-1], quantity), getattr(study.limit, quantity))
    stated = (found.error[place], found.remaining[place])
    for table, error in zip(values, stated, strict=True):
        true = largest(table[(..., *place)] - exact)
        assert HONEST[0] < error / true < HONEST[1], (quantity, error / true)
    assert largest(values[1][(..., *place)] - exact) < most * largest(exact)


@pytest.mark.verifies(
    "added mass and damping of a heaving hemisphere, extrapolated from up to 1024 panels",
    published="Hulme (1982)",
    tolerance="1e-3",
)
def test_heaving_hemisphere() -> None:
    study, ka = stored("hemisphere"), CASES["hemisphere"].ka
    table = np.loadtxt(DATA / "hemisphere_heave.csv", delimiter=",")
    rows = table[np.isin(table[:, 0], ka)]
    assert tuple(rows[:, 0]) == ka
    mass, damping = 0.5 * BALL * rows[:, 1], 0.5 * BALL * rows[:, 2] * study.limit.omega
    check(study, "added_mass", 1, mass, 1e-3)
    check(study, "radiation_damping", 1, damping, 1e-3)
    check(study, "added_mass_inf", 1, np.array(0.25 * BALL), 1e-3)
    np.testing.assert_allclose(study.limit.added_mass[:, 1, 1], mass, rtol=1e-3)
    assert 1.2 < study.added_mass.order[1, 1] < 2.2


@pytest.mark.verifies(
    "added mass and damping of a submerged sphere in surge and heave",
    analytic="multipoles and their images",
    tolerance="5e-3",
)
@pytest.mark.parametrize(("motion", "mode"), [(0, 1), (1, 0)], ids=["surge", "heave"])
def test_submerged_sphere(motion: int, mode: int) -> None:
    study, case = stored("submerged_sphere"), CASES["submerged_sphere"]
    exact = BALL * np.array(
        [submerged_sphere(k, radius=RADIUS, depth=SUNK, mode=mode) for k in case.wavenumbers]
    )
    check(study, "added_mass", motion, exact.real, 5e-3)
    check(study, "radiation_damping", motion, case.omega * exact.imag, 5e-3)


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
    "wave force on a cylinder from the surface to the sea bed",
    published="MacCamy and Fuchs (1954)",
    tolerance="5e-3",
)
def test_pile() -> None:
    study, case = stored("pile"), CASES["pile"]
    exact = np.array(
        [
            cylinder_forces(k, radii=[RADIUS], places=[(0.0, 0.0)], depth=BED)[0, 0]
            for k in case.wavenumbers
        ]
    )
    check(study, "excitation", 0, exact, 5e-3)


@pytest.mark.verifies(
    "wave forces on two cylinders from the surface to the sea bed, in a row",
    published="Linton and Evans (1990)",
    tolerance="1e-2",
)
def test_two_piles() -> None:
    study, case = stored("two_piles"), CASES["two_piles"]
    places = [(-APART / 2, 0.0), (APART / 2, 0.0)]
    exact = np.array(
        [
            cylinder_forces(k, radii=[RADIUS] * 2, places=places, depth=BED)[:, 0]
            for k in case.wavenumbers
        ]
    )
    alone = np.array(
        [
            cylinder_forces(k, radii=[RADIUS], places=places[:1], depth=BED)[0, 0]
            for k in case.wavenumbers
        ]
    )
    assert largest(np.abs(exact[:, 0]) / np.abs(alone) - 1) > 0.1  # they shelter each other
    check(study, "excitation", 0, exact[:, 0], 1e-2)
    check(study, "excitation", 3, exact[:, 1], 1e-2)
    np.testing.assert_allclose(study.limit.excitation[:, [0, 3]], exact, rtol=1e-2)


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
