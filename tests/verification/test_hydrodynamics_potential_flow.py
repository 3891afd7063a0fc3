"""Coefficients by Capytaine against exact solutions, symmetries and limits."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Body, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull
from m4e_adapters.hydrodynamics.geometry.panels import Panels

DATA = Path(__file__).parents[1] / "data" / "hydrodynamics"
RADIUS, RHO, G = 5.0, 1000.0, 9.81
DEEP = Water(density=RHO, gravity=G)
BALL = {"sphere": {"radius": RADIUS}}
UNIT = 2 / 3 * math.pi * RHO * RADIUS**3  # mass of the displaced water


def hull(shape: dict, *, panels: int, center: tuple[float, float] = (0.0, -2.0)) -> Hull:
    body = Body.model_validate({"shape": shape, "center_of_gravity": center, "panels": panels})
    return make_hull("b", body, Path(), progress=lambda _: None)


def solved(*hulls: Hull, omega: list[float], water: Water = DEEP, **options) -> Coefficients:
    table = np.array(omega)
    return solve_hulls(hulls, water=water, omega=table, progress=lambda _: None, **options)


def hemisphere() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """ω, A33 and B33/ω of the exact solution, for Ka = 0.1, 0.5, 1."""
    table = np.loadtxt(DATA / "hemisphere_heave.csv", delimiter=",")
    rows = table[np.isin(table[:, 0], [0.1, 0.5, 1.0])]
    return np.sqrt(rows[:, 0] * G / RADIUS), rows[:, 1] * UNIT, rows[:, 2] * UNIT


@pytest.fixture(scope="module")
def ball() -> Coefficients:
    omega, _, _ = hemisphere()
    return solved(hull(BALL, panels=576), omega=omega.tolist())


@pytest.mark.verifies(
    "added mass and damping of a heaving hemisphere, 576 panels",
    published="Hulme (1982)",
    tolerance="2.5e-3",
)
def test_heaving_hemisphere(ball: Coefficients) -> None:
    """Hulme (1982). The discretisation error of 576 panels was measured by refining to 2304:
    0.1 to 0.2 % in A33 and B33, 0.13 % in A33 at infinite frequency."""
    omega, mass, damping = hemisphere()
    np.testing.assert_allclose(ball.added_mass[:, 1, 1], mass, rtol=2.5e-3)
    np.testing.assert_allclose(ball.radiation_damping[:, 1, 1] / omega, damping, rtol=2.5e-3)
    assert ball.added_mass_inf[1, 1] == pytest.approx(0.5 * UNIT, rel=2e-3)


def test_the_direct_method_converges_quadratically() -> None:
    """With all vertices on the sphere; half the panel size has a quarter of the error."""
    omega, mass, _ = hemisphere()
    errors = []
    for panels in (144, 576):
        made = hull(BALL, panels=panels)
        radii = np.linalg.norm(made.panels.vertices, axis=1, keepdims=True)
        inscribed = Panels(made.panels.vertices * RADIUS / radii, made.panels.faces)
        plain = replace(made, panels=inscribed, lid=None, hydrostatics=hydrostatics_of(inscribed))
        found = solved(plain, omega=[float(omega[1])])
        errors.append([found.added_mass_inf[1, 1] / (0.5 * UNIT) - 1])
        errors[-1].append(found.added_mass[0, 1, 1] / mass[1] - 1)
    orders = np.log2(np.array(errors[0]) / np.array(errors[1]))
    assert np.all(orders > 1.6)
    assert np.all(orders < 2.6)
    assert np.all(np.abs(errors[1]) < 6e-3)


@pytest.mark.verifies(
    "excitation from radiation damping", analytic="Haskind's relation", tolerance="5e-3"
)
def test_haskind_relation(ball: Coefficients) -> None:
    """|X₃|² = 2 ρ g³ B₃₃/ω³ for a body of revolution in deep water (Newman 1962): radiation and
    diffraction are solved separately, so this holds to the discretisation error only."""
    expected = np.sqrt(2 * RHO * G**3 * ball.radiation_damping[:, 1, 1] / ball.omega**3)
    np.testing.assert_allclose(np.abs(ball.excitation[:, 1]), expected, rtol=5e-3)


@pytest.mark.verifies(
    "excitation by long waves",
    analytic="hydrostatics, Froude and Krylov with added mass",
    tolerance="0.02",
)
def test_excitation_of_long_waves(ball: Coefficients) -> None:
    """e^{−iωt}, towards +X: heave follows the elevation with ρ g A_wp; surge is pushed by
    −∂p/∂x = −i k ρ g a, on the displaced and the added mass; reversed waves reverse surge."""
    omega = [0.12]
    small = hull(BALL, panels=144)
    found = solved(small, omega=omega)
    k = omega[0] ** 2 / G  # k a = 0.007: higher terms are of that order
    heave = found.excitation[0, 1]
    assert heave == pytest.approx(RHO * G * math.pi * RADIUS**2, rel=0.02)
    surge = -1j * k * RHO * G * (UNIT / RHO + found.added_mass[0, 0, 0] / RHO)
    assert found.excitation[0, 0] == pytest.approx(surge, rel=0.02)
    back = solved(small, omega=omega, wave_direction=180.0)
    assert back.excitation[0, 0] == pytest.approx(-found.excitation[0, 0], rel=1e-6)
    assert back.excitation[0, 1] == pytest.approx(heave, rel=1e-6)
    assert found.excitation_at(np.array([0.0]))[0, 1] == pytest.approx(heave, rel=0.02)
    assert ball.excitation_at(ball.omega) == pytest.approx(ball.excitation, rel=1e-9)


def test_pitch_is_ours() -> None:
    """About G below the ball's centre by 2 m, pitch moves the centre by +2 m·theta in x: a sphere
    feels nothing but that, so A₁₅ = 2 A₁₁ and A₅₅ = 4 A₁₁. The panels are a sphere to 0.3 %, which
    is what its area and volume are corrected by; twice in A₁₅, four times in A₅₅."""
    found = solved(hull(BALL, panels=576), omega=[1.0])
    a11 = found.added_mass[0, 0, 0]
    assert found.added_mass[0, 0, 2] == pytest.approx(2 * a11, rel=7e-3)
    assert found.added_mass[0, 2, 2] == pytest.approx(4 * a11, rel=1.4e-2)
    assert found.excitation[0, 2] == pytest.approx(2 * found.excitation[0, 0], rel=7e-3)


@pytest.mark.verifies(
    "coefficients in 100 m of water", analytic="deep water, images", tolerance="1e-3"
)
def test_finite_depth_tends_to_deep_water() -> None:
    """The bottom acts like images 2 h away: (a/2h)³ ~ 1e-5 for h = 100 m, and e^{−2kh} ~ 1e-5."""
    small = hull(BALL, panels=144)
    deep = solved(small, omega=[0.8, 1.6])
    finite = solved(small, omega=[0.8, 1.6], water=DEEP.model_copy(update={"depth": 100.0}))
    for name in ("added_mass", "added_mass_inf", "excitation"):
        a, b = getattr(deep, name), getattr(finite, name)
        np.testing.assert_allclose(b, a, atol=1e-3 * np.abs(a).max())


@pytest.mark.verifies("two interacting bodies", analytic="mirror symmetry", tolerance="1e-6")
def test_two_bodies_mirror_one_another() -> None:
    """Two equal boxes at x = ∓10 m: reflection in x = 0 exchanges them, with the signs of surge
    and pitch; the far waves of one act on the other."""
    sides = [
        hull(
            {"box": {"length": 4.0, "width": 6.0, "draft": 2.0, "center_x": x}},
            panels=60,
            center=(x, -0.5),
        )
        for x in (-10.0, 10.0)
    ]
    found = solved(replace(sides[0], name="left"), replace(sides[1], name="right"), omega=[1.5])
    flip = np.diag([-1.0, 1.0, -1.0])
    a = found.added_mass[0]
    np.testing.assert_allclose(flip @ a[:3, :3] @ flip, a[3:, 3:], atol=1e-6 * a.max())
    np.testing.assert_allclose(flip @ a[:3, 3:] @ flip, a[3:, :3], atol=1e-6 * a.max())
    alone = solved(sides[0], omega=[1.5])
    assert abs(a[0, 3]) > 0.1 * a[0, 0]  # one body's waves push the other
    assert a[1, 1] == pytest.approx(alone.added_mass[0, 1, 1], rel=0.1)
    assert a[1, 1] != pytest.approx(alone.added_mass[0, 1, 1], rel=1e-4)


@pytest.mark.verifies(
    "yaw of a float of revolution that turns about a vertical beside its axis",
    analytic="symmetry: a body of revolution does not move the water when it spins",
    tolerance="1e-12",
)
def test_a_body_of_revolution_spins_freely() -> None:
    """Turning about a vertical beside its axis, it moves as the axis does: (4, 3) m for 1 rad."""
    shape = {"revolved": {"profile": [[2.0, -6.0], [1.0, -2.0], [1.0, 0.0]]}}
    body = Body.model_validate(
        {"shape": shape, "center_of_gravity": [-3.0, 4.0, -3.0], "panels": 100}
    )
    made = make_hull("float", body, Path(), progress=lambda _: None)
    found = solved(made, omega=[1.5])
    for table in (found.added_mass[0], found.radiation_damping[0], found.added_mass_inf):
        np.testing.assert_allclose(table[:, 5], 4.0 * table[:, 0] + 3.0 * table[:, 1], rtol=1e-12)
        np.testing.assert_allclose(table[5], 4.0 * table[0] + 3.0 * table[1], rtol=1e-12)
        assert table[5, 5] == pytest.approx(25.0 * table[0, 0], rel=1e-6)
    np.testing.assert_allclose(
        found.harmonics[0, :, 5],
        4.0 * found.harmonics[0, :, 0] + 3.0 * found.harmonics[0, :, 1],
        rtol=1e-9,
        atol=1e-9 * np.abs(found.harmonics).max(),
    )
