"""Longest stable internal steps, against eigenvalues of assembled lines on the seabed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from support.lines_in_waves import mooring_of

from m4e_adapters.moordyn.stability import (
    SPEED,
    Segment,
    decay_rate,
    fastest,
    oscillations,
    stable_step,
)
from m4e_fmi.errors import InputError

NODES = 9


def segment(rng: np.random.Generator) -> Segment:
    diameter, length = 10 ** rng.uniform(-1.5, -0.5), 10 ** rng.uniform(0, 1.5)
    mass = 1025 * math.pi * diameter**2 / 4 * 10 ** rng.uniform(-0.05, 0.9)
    stiffness = mass * 10 ** rng.uniform(5, 7.5)
    return Segment(
        length=length,
        diameter=diameter,
        mass_per_length=mass,
        axial_stiffness=stiffness,
        damping=10 ** rng.uniform(-1.3, 0.3) * length * math.sqrt(stiffness * mass),
        bending_stiffness=0.0,
        seabed_stiffness=0.0,
        seabed_damping=10 ** rng.uniform(3.5, 6),
        water_density=1025.0,
        drag_coefficient=float(rng.choice([0.0, 1.2])),
        added_mass_coefficient=float(rng.choice([0.0, 1.0])),
    )


def eigenvalues(line: Segment, angles: np.ndarray, touching: list[int], slack: set[int]):
    """Of small motions of nodes between segments of these angles [rad], both ends held.

    Nodes in `touching` are on the seabed, all move through the water at SPEED.
    """
    water = line.water_density * math.pi * line.diameter**2 / 4 * line.added_mass_coefficient
    q = np.array([np.cos(angles), np.sin(angles)]).T
    size = 2 * NODES
    m, c, k = (np.zeros((size, size)) for _ in range(3))
    for i in range(NODES):
        along = q[i] + q[i + 1]
        along = np.outer(along, along) / (along @ along)
        here, eye = slice(2 * i, 2 * i + 2), np.eye(2)
        m[here, here] = line.length * (line.mass_per_length * eye + water * (eye - along))
        drag = line.water_density * line.diameter * line.drag_coefficient * SPEED
        c[here, here] += line.length * drag * (eye - along)
        if i in touching:
            c[here, here] += np.diag([0, line.seabed_damping * line.diameter * line.length])
    for j in range(NODES + 1):
        turn, sides = np.outer(q[j], q[j]) / line.length, [i for i in (j - 1, j) if 0 <= i < NODES]
        for a in sides:
            for b in sides:
                block = (2 * (a == b) - 1) * turn
                c[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += line.damping * block
                if j not in slack:
                    k[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += line.axial_stiffness * block
    left = np.linalg.inv(m)
    return np.linalg.eigvals(np.block([[np.zeros_like(m), np.eye(size)], [-left @ k, -left @ c]]))


def test_no_assembled_line_is_faster_than_the_bound():
    rng = np.random.default_rng(3)
    shares = []
    for _ in range(300):
        line = segment(rng)
        down, up = np.radians(rng.choice([0, 90, rng.uniform(0, 90)], 2))
        before = NODES // 2
        angles = np.array([-down] * (before + 1) + [up] * (NODES - before))
        touching = list(range(before + 1)) if down == 0 else [before]
        slack = {int(j) for j in np.flatnonzero(rng.random(NODES + 1) < rng.choice([0, 0.3, 1]))}
        found = eigenvalues(line, angles, touching, slack)
        real = np.abs(found.imag) < 1e-6 * np.abs(found)
        fastest = oscillations(line)[0][0]
        assert (np.abs(found[~real]) <= fastest * (1 + 1e-9)).all()
        assert (-found.real[real]).max(initial=0) <= decay_rate(line) * (1 + 1e-9)
        shares.append((-found.real[real]).max(initial=0) / decay_rate(line))
    assert max(shares) > 0.97  # the bound is met


def plain(**changes: float) -> Segment:
    values = {"length": 10.0, "diameter": 0.1, "mass_per_length": 100.0, "axial_stiffness": 1e8}
    none = ("damping", "bending_stiffness", "seabed_stiffness", "seabed_damping")
    return Segment(**(values | dict.fromkeys(none, 0.0) | changes))


def test_stability_limits_against_the_known_ones():
    # ω = (2/10) √(1e8/100) = 200 rad/s; RK4 is stable on the negative real axis up to 2.7853, RK2
    # up to 2 (Hairer & Wanner, Solving ODEs II, IV.2). Between the imaginary axis (2√2) and there
    # RK4's boundary comes as near as 2.62, which further damping may reach.
    # The search steps by 1/400 of the mode; the growth it lets pass moves the limits by < 0.5 %.
    critical = plain(damping=10 * (1e8 * 100) ** 0.5)
    # slack segments have the damper without the spring: 2ζω = 400 1/s; a damper of the seabed
    # alone: rate cBot d/m' = 400 1/s, far above its spring's √(kBot d/m')
    seabed = plain(seabed_stiffness=1.0, seabed_damping=4e5)
    for line, scheme, rate, limit in (
        (plain(), "RK4", 200, 2.62),
        (critical, "RK4", 400, 2.7853),
        (critical, "RK2", 400, 2.0),
        (seabed, "RK4", 400, 2.7853),
    ):
        assert stable_step(line, scheme) * rate == pytest.approx(limit, rel=0.005)
    # without damping RK2 grows by (ω dt)^4/8 a step: 0.0001 at ω dt = 0.1682, found to 1/400
    assert stable_step(plain(), "RK2") * 200 == pytest.approx(0.1682, abs=1 / 400)


LANDING = """\
water: {density: 1025, depth: 200}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+9, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
anchors: {a1: [0, -200]}
fairleads: [f1]
lines: {l1: {type: chain, from: a1, to: f1, unstretched_length: 460, segments: SEGMENTS}}
"""


@pytest.mark.parametrize("scheme", ["RK2", "RK4"])
def test_the_chosen_step_is_stable(scheme: str):
    # ω = (2/46 m) √(1e9/150) = 112 rad/s alone would allow 2/ω = 0.018 s with RK2; the seabed's
    # damper, cBot d/m' = 200 1/s, allows about half of that
    text = LANDING.replace("SEGMENTS", "10")
    with pytest.raises(InputError, match="l1 allows at most") as caught:
        mooring_of(text + f"solver: {{scheme: {scheme}, time_step: 0.02}}\n")
    longest = float(str(caught.value).split("at most ")[1].split()[0])
    made = mooring_of(text + f"solver: {{scheme: {scheme}}}\n")
    assert 0.5 * longest < made.time_step < longest
    assert mooring_of(LANDING.replace("SEGMENTS", "1")).time_step >= 1  # nothing moves inside


@pytest.mark.parametrize("scheme", ["RK2", "RK4"])
def test_the_fastest_water_is_that_of_the_longest_step(scheme: str):
    """Of a rope whose limit is its drag, and of one without drag."""
    rope = Segment(
        length=10.0, diameter=0.1, mass_per_length=10.0, axial_stiffness=1e4, damping=2e3,
        bending_stiffness=0.0, seabed_stiffness=0.0, seabed_damping=10.0, water_density=1025.0,
        drag_coefficient=1.5, friction=30.0, speed=40.0,
    )  # fmt: skip
    assert fastest(rope, stable_step(rope, scheme), scheme) == pytest.approx(40.0, rel=1e-9)
    assert fastest(replace(rope, water_density=0.0), 0.01, scheme) == math.inf
