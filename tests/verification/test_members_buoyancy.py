"""Buoyancy of members: forces by hand, stability of a frame, energy of bodies that tumble."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.frames import (
    COLUMN,
    DRAFT,
    HEIGHT,
    LEVEL,
    MASS,
    PLACES,
    PONTOON,
    RHO,
    SIDE,
    G,
    floating_frame,
)

from m4e_adapters.morison import MorisonConfig, morison_program
from m4e_adapters.morison.buoyancy import buoyancy
from m4e_adapters.morison.stability import stability_of
from m4e_fmi.analysis import equilibrium
from m4e_fmi.cosim import load_system, system_program
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.program.python_form import load_python
from m4e_fmi.simulate import simulate

R, L = 0.7, 6.0
Place = tuple[float, float, float]


def wrench(middle: Place, along: Place) -> np.ndarray:
    """Force and moment about the origin (6,) per ρ g, of a cylinder of 0.7 m by 6 m."""
    size = math.hypot(*along)
    x, y, z = (a / size for a in along)
    ends = [
        tuple(m + s * a for m, a in zip(middle, (x, y, z), strict=True)) for s in (-L / 2, L / 2)
    ]
    low, high = ((float(p[0]), float(p[1]), float(p[2])) for p in ends)
    force, moment = buoyancy(
        (low, high), (x, y, z), (-low[2], -high[2]), radius=R, length=L, weight=1.0
    )
    return np.array([*force, *moment], dtype=float)


def counted(middle: Place, along: Place) -> np.ndarray:
    """The same by points: slices across the axis, each cut by the surface."""
    e = np.array(along) / math.hypot(*along)
    a = np.cross(e, [0.3, 0.9, 0.1])
    a /= np.linalg.norm(a)
    b = np.cross(e, a)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    turns = 2 * np.pi * (np.arange(100) + 0.5) / 100
    radii = R * np.sqrt((np.arange(100) + 0.5) / 100)
    disc = (
        radii[:, None, None] * (np.cos(turns)[:, None] * a + np.sin(turns)[:, None] * b)
    ).reshape(-1, 3)
    total = np.zeros(6)
    for node, weight in zip(nodes, weights, strict=True):
        points = np.array(middle) + node * L / 2 * e + disc
        wet = points[points[:, 2] < 0]
        share = weight * L / 2 * math.pi * R**2 / len(points)
        up = np.array([0.0, 0.0, share])
        total += [0, 0, share * len(wet), *np.cross(wet, up).sum(axis=0)]
    return total


def test_an_upright_cylinder_is_exact() -> None:
    for out in (0.5, 2.0, 5.5):
        found = wrench((0.4, -0.2, out - L / 2), (0, 0, 1))
        volume = math.pi * R**2 * (L - out)
        # a tilt by 1e-6 guards a root: its square is left
        assert found == pytest.approx([0, 0, volume, -0.2 * volume, -0.4 * volume, 0], abs=1e-10)


@pytest.mark.parametrize("depth", [-0.69, -0.3, 0.0, 0.2, 0.6, 0.69])
def test_a_level_cylinder_is_exact(depth: float) -> None:
    """The segment of a circle."""
    angle = math.acos(-depth / R)
    volume = L * R**2 * (angle - math.sin(angle) * math.cos(angle))
    found = wrench((0.0, 0.0, -depth), (1, 0, 0))
    assert found == pytest.approx([0, 0, volume, 0, 0, 0], abs=1e-12 * L)


@pytest.mark.parametrize(
    ("middle", "along"),
    [
        ((0.3, 0.2, -1.0), (0.3, 0.1, 1.0)),
        ((0.3, 0.2, -0.2), (1.0, 0.5, 0.3)),
        ((0.3, 0.2, 0.1), (1.0, 0.5, -0.02)),
        ((1.0, 2.0, -0.3), (0.2, 0.1, -1.0)),
        ((0.3, 0.2, 0.3), (1.0, 0.0, 0.0015)),
        ((0.3, 0.2, -4.0), (1.0, 0.0, 0.2)),
    ],
)
def test_inclined_cylinders_beside_points(middle: Place, along: Place) -> None:
    """Points leave 2e-3 of the largest: 10000 in each of 200 slices."""
    found, expected = wrench(middle, along), counted(middle, along)
    assert found == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())


def test_deep_water_leaves_no_noise() -> None:
    """At 200 m, nearly level, the moment is that of the middle: to 1e-10 of ρ g V times 6 m."""
    found = wrench((0.5, 0.0, -200.0), (1.0, 0.0, 0.004))
    volume = math.pi * R**2 * L
    assert found == pytest.approx([0, 0, volume, 0, -0.5 * volume, 0], abs=1e-10 * volume * L)


def test_quotients_and_means_meet() -> None:
    """From level to steep, forces have no step where one replaces the other."""
    slopes = np.linspace(0.0, 0.01, 101)
    found = np.array([wrench((0.1, 0.0, -0.3), (1.0, 0.0, s)) for s in slopes])
    bends = np.abs(np.diff(found, n=3, axis=0)).max(axis=0)
    assert bends.max() < 1e-6 * np.abs(found).max()


@pytest.mark.verifies(
    "a frame of columns and pontoons floats at its draft, with the metacentric height by hand",
    analytic="GM = KB + I/V − KG",
    tolerance="1e-6",
)
def test_the_stability_of_a_frame(tmp_path: Path) -> None:
    program = system_program(load_system(floating_frame(tmp_path)))
    rest = equilibrium(program)
    assert rest.values["frame.body.frame.z"] == pytest.approx(HEIGHT, abs=1e-6)
    columns, pontoons = 3 * math.pi / 4 * COLUMN**2 * DRAFT, 3 * math.pi / 4 * PONTOON**2 * SIDE
    center = (-DRAFT / 2 * columns + LEVEL * pontoons) / (columns + pontoons)
    plane = math.pi / 4 * COLUMN**2
    second = 3 * math.pi / 64 * COLUMN**4 + plane * sum(x * x for x, _ in PLACES)
    height = center + second / (columns + pontoons) - HEIGHT
    assert height > 1.0
    (told,) = stability_of(water_of(tmp_path))
    assert told.hydrostatics.center_of_buoyancy == pytest.approx((0, 0, center), abs=1e-6)
    for of in ("metacentric_height", "transverse_metacentric_height"):
        assert getattr(told.hydrostatics, of)(told.center) == pytest.approx(height, rel=1e-6)
    turned = 1e-4
    (found,) = outputs(tmp_path, {"frame.theta": turned}, "frame.buoyancy_moment_y")
    assert found == pytest.approx(-MASS * G * height * turned, rel=1e-6)


def outputs(folder: Path, values: dict[str, float], *names: str) -> list[float]:
    """Outputs of the water of a frame where inputs have these values, others the reference pose."""
    program = morison_program(
        water_of(folder), name="water", folder=folder, progress=lambda _: None
    )
    return run_once(program, values, *names)


def water_of(folder: Path) -> MorisonConfig:
    """The configuration of the members of a frame."""
    system = load_system(floating_frame(folder))
    (source,) = (c.source for c in system.components if isinstance(c.source, Kind))
    assert isinstance(source.config, MorisonConfig)
    return source.config


def run_once(program: Any, values: dict[str, float], *names: str) -> list[float]:
    form = load_python(program)
    p = [v.start for v in program.parameters]
    u = [values.get(v.name, v.start) for v in program.inputs]
    found = form.outputs(0.0, [], u, p, form.constants(p))
    known = dict(zip([v.name for v in program.outputs], found, strict=True))
    return [known[name] for name in names]


TUMBLER = """\
name: tumbler
dimensions: 3
gravity: {g}
bodies: {{log: {{mass: 6000, inertia: [9e3, 2e4, 1.8e4]}}}}
joints: {{sea: {{type: floating, child: log, initial: {{z: 1.5, vx: 0.2, omega_x: 0.4, omega: 0.9,
  omega_z: -0.3}}}}}}
"""
WATER = """\
name: tumbler
components:
  tumbler: {{model: tumbler.model.yaml}}
  water:
    kind: morison
    dimensions: 3
    water: {{density: {rho}, depth: 60, gravity: {g}}}
    bodies: {{log: {{center_of_gravity: [0, 0, 1.5]}}}}
    members:
      log_axis: {{ends: [[-3, 0.3, 1], [3, -0.2, 2]], diameter: 1.4, drag: 0, added_mass: 0,
        inertia: 0, buoyancy: true, body: log}}
connections: [tumbler.log <-> water.log]
simulation: {{stop_time: 5, step_size: 0.02}}
"""


@pytest.mark.verifies(
    "a cylinder that falls into still water and tumbles keeps its energy",
    analytic="kinetic + potential + displaced water",
    tolerance="1e-6",
)
def test_tumbling_keeps_the_energy(tmp_path: Path) -> None:
    """The energy of the displaced water is integrated here, over slices with Gauss points."""
    (tmp_path / "tumbler.model.yaml").write_text(TUMBLER.format(g=G), "utf-8")
    (tmp_path / "system.yaml").write_text(WATER.format(g=G, rho=RHO), "utf-8")
    program = system_program(load_system(tmp_path / "system.yaml"))
    result = simulate(program, stop_time=12.0, output_interval=0.25, tolerance=1e-10)
    pose = {
        name: np.asarray(result[f"tumbler.body.log.{name}"])
        for name in ("z", "phi", "theta", "psi")
    }
    total = np.asarray(result["tumbler.energy.total"])
    water = np.array(
        [displaced(*row) for row in zip(pose["z"], pose["phi"], pose["theta"], strict=True)]
    )
    assert np.ptp(water) > 1e4
    assert np.ptp(pose["theta"]) > 1.0
    assert np.ptp(total + water) < 1e-6 * np.ptp(water)


def displaced(z: float, phi: float, theta: float) -> float:
    """ρ g ∫ −z dV [J] of the wet part of the log, by slices across the axis."""
    first, second = np.array([-3, 0.3, -0.5]), np.array([3, -0.2, 0.5])

    def height(v: np.ndarray) -> float:
        """z of a vector of the body: of R_z R_y R_x v."""
        lifted = math.sin(phi) * v[1] + math.cos(phi) * v[2]
        return float(math.cos(theta) * lifted - math.sin(theta) * v[0])

    length = float(np.linalg.norm(second - first))
    low, high = z + height(first), z + height(second)
    half = 0.7 * math.sqrt(max(1 - ((high - low) / length) ** 2, 0.0))
    shares = (np.arange(4000) + 0.5) / 4000
    depth = -(low + shares * (high - low))
    angle = np.arccos(np.clip(-depth / half, -1, 1))
    area = 0.49 * (angle - np.sin(angle) * np.cos(angle))
    first_moment = 2 / 3 * 0.343 * np.sin(angle) ** 3
    energy = depth * area + half / 0.7 * first_moment
    return RHO * G * length * float(energy.mean())


def config(**keys: Any) -> MorisonConfig:
    member = {"ends": [[0, -9], [0, 2]], "diameter": 1, "drag": 1, "body": "hull", **keys}
    return MorisonConfig.model_validate(
        {"bodies": {"hull": {"center_of_gravity": [0, 0]}}, "members": {"leg": member}}
    )


@pytest.mark.parametrize(
    ("keys", "is_buoyant"),
    [
        ({}, True),
        ({"flooded": True}, False),
        ({"buoyancy": False}, False),
        ({"added_mass": 0, "inertia": 0}, False),
        ({"added_mass": 0, "inertia": 0, "buoyancy": True}, True),
    ],
)
def test_members_that_displace_water(keys: dict[str, Any], is_buoyant: bool) -> None:
    program = morison_program(config(**keys), name="m", folder=Path(), progress=lambda _: None)
    names = {v.name for v in program.outputs}
    assert ("hull.buoyancy_force_z" in names) is is_buoyant
    if is_buoyant:
        found = run_once(program, {}, "hull.force_z", "hull.buoyancy_force_z")
        assert found == pytest.approx([1025 * 9.81 * math.pi / 4 * 9] * 2)
