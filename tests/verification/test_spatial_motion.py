"""Motions of bodies in space with exact solutions: free bodies, tops, a pendulum on the Earth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipj, ellipkinc

from m4e_fmi.model import Body, Joint, Model, Point, TensionSpring
from m4e_fmi.simulate import Simulation, simulate

GYROSCOPE = Path(__file__).parents[2] / "examples" / "gyroscope" / "gyroscope.model.yaml"
MOMENTS = (1.0, 2.0, 3.0)  # kg m2
SPIN = (0.01, 1.0, 0.01)  # rad/s, about the middle axis, which is unstable
ATTITUDE = ("e0", "e1", "e2", "e3")


def axes(found: Simulation, owner: str) -> np.ndarray:
    """Rotation matrices (n, 3, 3), body to world axes, of the quaternion of a joint or body."""
    e = np.array([found[f"{owner}.{name}"] for name in ATTITUDE])
    w, x, y, z = e / np.linalg.norm(e, axis=0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def omegas(found: Simulation, owner: str) -> np.ndarray:
    return np.array([found[f"{owner}.{name}"] for name in ("omega_x", "omega", "omega_z")]).T


def tumbling(stop_time: float, tolerance: float) -> Simulation:
    initial: dict[str, Any] = dict(zip(("omega_x", "omega", "omega_z"), SPIN, strict=True))
    joint = Joint("floating", "block", initial=initial)
    model = Model("block", {"block": Body(1.0, MOMENTS)}, {"free": joint}, dimensions=3, gravity=0)
    return simulate(model, stop_time=stop_time, output_interval=0.1, tolerance=tolerance)


def test_a_free_body_keeps_its_angular_momentum() -> None:
    found = tumbling(1000.0, 1e-8)
    R, omega = axes(found, "body.block"), omegas(found, "body.block")
    local = np.einsum("nji,nj->ni", R, omega)
    momentum = np.einsum("nij,nj->ni", R, local * MOMENTS)
    drift = np.linalg.norm(momentum - momentum[0], axis=1) / np.linalg.norm(momentum[0])
    assert drift.max() < 1e-6
    length = np.linalg.norm([found[f"body.block.{name}"] for name in ATTITUDE], axis=0)
    assert np.abs(length - 1).max() < 1e-6
    assert np.abs(np.einsum("nij,nkj->nik", R, R) - np.eye(3)).max() < 1e-14


@pytest.mark.verifies(
    "a free body about its unstable axis, angular velocity over 100 s",
    independent="Jacobi's elliptic functions",
    tolerance="1e-6 of the spin",
)
def test_a_free_body_tumbles_as_jacobi_says() -> None:
    """Landau and Lifshitz, Mechanics, section 37: moments I1 < I2 < I3, momentum M, energy E."""
    a, b, c = MOMENTS
    energy = sum(m * w * w for m, w in zip(MOMENTS, SPIN, strict=True)) / 2
    square = sum((m * w) ** 2 for m, w in zip(MOMENTS, SPIN, strict=True))
    assert square > 2 * energy * b
    rate = math.sqrt((c - b) * (square - 2 * energy * a) / (a * b * c))
    m = (b - a) * (2 * energy * c - square) / ((c - b) * (square - 2 * energy * a))
    sizes = (
        math.sqrt((2 * energy * c - square) / (a * (c - a))),
        math.sqrt((2 * energy * c - square) / (b * (c - b))),
        math.sqrt((square - 2 * energy * a) / (c * (c - a))),
    )
    found = tumbling(100.0, 1e-13)
    R, omega = axes(found, "body.block"), omegas(found, "body.block")
    local = np.einsum("nji,nj->ni", R, omega)
    phase = math.atan2(local[0, 1] / sizes[1], local[0, 0] / sizes[0])
    sn, cn, dn, _ = ellipj(rate * found.time + ellipkinc(phase, m), m)
    exact = np.array([sizes[0] * cn, sizes[1] * sn, sizes[2] * dn]).T
    assert np.abs(local - exact).max() < 1e-6 * SPIN[1]


MASS, HEIGHT, ACROSS, ALONG, GRAVITY = 0.5, 0.08, 0.002, 0.001, 9.80665
"""A top: mass [kg], CG above its tip [m], moments of inertia about the CG [kg m2], m/s2."""
TILT, TOP_SPIN = 0.3, 150.0  # rad, rad/s


@pytest.fixture(scope="module")
def top() -> Simulation:
    """A top that is let go with a spin about its own axis only."""
    initial: dict[str, Any] = {
        "theta": TILT,
        "omega_x": TOP_SPIN * math.sin(TILT),
        "omega_z": TOP_SPIN * math.cos(TILT),
    }
    tip = Joint("spherical", "top", joint_to_child=(0, 0, HEIGHT), initial=initial)
    body = Body(MASS, (ACROSS, ACROSS, ALONG))
    model = Model("top", {"top": body}, {"tip": tip}, dimensions=3, gravity=GRAVITY)
    return simulate(model, stop_time=6.0, output_interval=1e-3, tolerance=1e-10)


@pytest.mark.verifies(
    "Lagrange's top: nutation and precession",
    independent="quadrature of the exact solution",
    tolerance="1e-4",
)
def test_a_top_nods_and_precesses_as_lagrange_says(top: Simulation) -> None:
    """Goldstein, Classical Mechanics, section 5.7: u = cos of the tilt, u'^2 = f(u)."""
    about_tip = ACROSS + MASS * HEIGHT**2
    a, b = ALONG * TOP_SPIN / about_tip, ALONG * TOP_SPIN * math.cos(TILT) / about_tip
    beta, first = 2 * MASS * GRAVITY * HEIGHT / about_tip, math.cos(TILT)
    # f(u) = (u0 - u) (beta (1 - u^2) - a^2 (u0 - u)), let go at rest
    low = min(np.roots([-beta, a * a, beta - a * a * first]), key=lambda u: abs(u - first)).real
    third = a * a / beta - low  # the sum of the quadratic's roots

    def over(angle: float, weight: float) -> float:
        """Integrand after u = low + (first - low) sin^2(angle)."""
        u = low + (first - low) * math.sin(angle) ** 2
        rate = 2 / math.sqrt(beta * (third - u))
        return rate * ((b - a * u) / (1 - u * u) if weight else 1.0)

    period = 2 * quad(over, 0, math.pi / 2, args=(0.0,), epsabs=1e-13)[0]
    advance = 2 * quad(over, 0, math.pi / 2, args=(1.0,), epsabs=1e-13)[0]
    x, y, z = (top[f"body.top.{axis}"] for axis in "xyz")
    tilt, yaw = np.arctan2(np.hypot(x, y), z), np.unwrap(np.arctan2(y, x))
    assert abs(np.cos(tilt).min() - low) < 1e-6
    lowest = [k for k in range(1, len(tilt) - 1) if tilt[k - 1] < tilt[k] >= tilt[k + 1]]
    times, yaws = zip(*(vertex(top.time, tilt, yaw, k) for k in lowest), strict=True)
    nods = len(lowest) - 1
    assert (times[-1] - times[0]) / nods == pytest.approx(period, rel=1e-4)
    assert (yaws[-1] - yaws[0]) / nods == pytest.approx(advance, rel=1e-4)


def vertex(time: np.ndarray, tilt: np.ndarray, yaw: np.ndarray, k: int) -> tuple[float, float]:
    """Time and yaw at the top of the parabola through three points of the tilt."""
    before, here, after = tilt[k - 1 : k + 2]
    shift = (before - after) / (2 * (before - 2 * here + after))
    at = time[k] + shift * (time[1] - time[0])
    return at, float(np.interp(at, time, yaw))


@pytest.mark.verifies(
    "steady precession of a spinning disc on two gimbals",
    independent="the condition of steady precession",
    tolerance="1e-8 rad",
)
def test_the_gyroscope_of_the_examples_precesses_steadily() -> None:
    """m g l = C n p - (A + m l^2) p^2 cos(tilt), n the disc's turning about its own axis."""
    found = simulate(GYROSCOPE, stop_time=20.0, output_interval=0.1, tolerance=1e-12)
    assert np.abs(found["joint.pitch.q"] - math.radians(63)).max() < 1e-8
    np.testing.assert_allclose(found["joint.yaw.q"], 0.8 * found.time, atol=1e-8)
    np.testing.assert_allclose(found["body.disc.omega_z"], found["body.disc.omega_z"][0], atol=1e-6)


LATITUDE, TURN, RADIUS, ROPE = math.radians(50), 2e-3, 1e3, 9.0
"""A small planet that turns faster than ours: rad, rad/s, m; the pendulum's length [m]."""


@pytest.mark.verifies(
    "Foucault's pendulum on a turning planet",
    independent="turning of the plumb line, with the next order in amplitude",
    tolerance="1e-4",
)
def test_foucaults_pendulum() -> None:
    """The plane of swing turns by -Ω sin(latitude), and by Airy's 3/8 of the ellipse that it is."""
    gravity, mass, swing = 9.8, 1.0, 0.05
    up = np.array([math.cos(LATITUDE), 0, math.sin(LATITUDE)])
    # the plumb line hangs along gravity less the centripetal acceleration of its own place
    hang = -up
    for _ in range(50):
        bob = RADIUS * up + ROPE * hang
        pull = -gravity * bob / np.linalg.norm(bob) + TURN**2 * np.array([bob[0], 0, 0])
        hang = pull / np.linalg.norm(pull)
    east, north = np.array([0.0, 1.0, 0.0]), np.cross(-hang, [0.0, 1.0, 0.0])
    start = math.cos(swing) * hang + math.sin(swing) * north
    model = Model(
        "planet",
        {"planet": Body(1.0, (1e12, 1e12, 1e12)), "bob": Body(mass, (1e-9, 1e-9, 1e-9))},
        {
            "axis": Joint("revolute", "planet", axis=(0, 0, 1), initial={"u": TURN}),
            "hook": Joint(
                "universal", "bob", "planet", tuple(RADIUS * up), tuple(ROPE * start),
                axis=tuple(east), second_axis=tuple(np.cross(east, start)),
            ),
        },
        points={"centre": Point("planet", (0, 0, 0)), "bob": Point("bob", (0, 0, 0))},
        loads={"weight": TensionSpring(("bob", "centre"), length=0.0, law=str(mass * gravity))},
        dimensions=3,
        gravity=0,
    )  # fmt: skip
    found = simulate(model, stop_time=1200.0, output_interval=0.02, tolerance=1e-11)
    place = np.array([found[f"body.bob.{axis}"] for axis in "xyz"]).T
    turned = found["joint.axis.q"]
    local = np.array([
        np.cos(turned) * place[:, 0] + np.sin(turned) * place[:, 1],
        np.cos(turned) * place[:, 1] - np.sin(turned) * place[:, 0],
        place[:, 2],
    ]).T - RADIUS * up  # fmt: skip
    along, across = local @ north, local @ east
    away = np.hypot(along, across)
    furthest = [k for k in range(1, len(away) - 1) if away[k - 1] < away[k] >= away[k + 1]]
    angles = np.unwrap(2 * np.arctan2(across, along)[furthest]) / 2
    slope = np.polyfit(found.time[furthest], angles, 1)[0]
    expected = TURN * (-hang)[2]
    airy = 3 / 8 * (ROPE * math.sin(swing)) ** 2 / ROPE**2
    assert abs(slope) == pytest.approx(expected * (1 - airy), rel=1e-4)
