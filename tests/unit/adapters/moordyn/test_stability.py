"""Longest stable internal steps, against eigenvalues of assembled lines."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from support.lines_in_waves import mooring_of

from m4e_adapters.moordyn.stability import MARGIN, Segment, cheapest_scheme, kind, stable_step
from m4e_fmi.errors import InputError
from m4e_fmi.runtime.library import library

NODES, BED = 11, -50.0
EXACT = {"RK2": [1, 1, 0.5], "RK4": [1, 1, 0.5, 1 / 6, 1 / 24]}


def segment(rng: np.random.Generator) -> Segment:
    diameter, length = 10 ** rng.uniform(-1.5, -0.5), 10 ** rng.uniform(0, 1.5)
    mass = 1025 * math.pi * diameter**2 / 4 * 10 ** rng.uniform(-0.05, 0.9)
    stiffness = mass * 10 ** rng.uniform(5, 7.5)
    return Segment(
        length=length,
        diameter=diameter,
        mass_per_length=mass,
        axial_stiffness=stiffness,
        damping=10 ** rng.uniform(-1, 0.3) * length * math.sqrt(stiffness * mass),
        bending_stiffness=0.0,
        seabed_stiffness=float(rng.choice([0.0, 3e5])),
        seabed_damping=10 ** rng.uniform(3.5, 6),
        water_density=1025.0,
        drag_coefficient=float(rng.choice([0.0, 1.2])),
        added_mass_coefficient=float(rng.choice([0.0, 1.0])),
        axial_drag_coefficient=float(rng.choice([0.0, 0.4])),
    )


def places(rng: np.random.Generator, line: Segment) -> np.ndarray:
    """Nodes (n, 3) [m] of a line that falls to the seabed and rises; taut, slack, or in parts."""
    down, up = np.radians(rng.choice([0, 90, rng.uniform(0, 90)], 2))
    angles = np.array([-down] * (NODES // 2) + [up] * (NODES // 2))
    angles += rng.uniform(-0.1, 0.1, len(angles))
    slack = rng.random(len(angles)) < rng.choice([0, 0.3, 1])
    strain = np.where(slack, -1e-3, 10 ** rng.uniform(-4, -2.5))
    turn = rng.uniform(0, math.tau)
    way = np.cos(angles)
    steps = np.array([way * math.cos(turn), way * math.sin(turn), np.sin(angles)]).T
    steps *= line.length * (1 + strain)[:, None]
    found = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    found[:, 2] += BED - np.sort(found[:, 2])[rng.integers(0, 4)] - 1e-9
    return found


def eigenvalues(line: Segment, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Of small motions [1/s] of nodes at r [m] with velocities v [m/s] in still water; ends held.

    Drag is twice its value across the flow, as along it.
    """
    inner, size, eye = NODES - 2, 3 * (NODES - 2), np.eye(3)
    m, c, k = (np.zeros((size, size)) for _ in range(3))
    across, along = line.masses
    density = line.water_density * line.diameter * line.length
    for i in range(inner):
        here, q = slice(3 * i, 3 * i + 3), r[i + 2] - r[i]
        q = np.outer(q, q) / (q @ q)
        wet = r[i + 1, 2] < 0
        masses = (across, along) if wet else (line.mass_per_length,) * 2
        m[here, here] = line.length * (masses[0] * (eye - q) + masses[1] * q)
        past = q @ v[i + 1]
        c[here, here] += density * (
            line.drag_coefficient * np.linalg.norm(v[i + 1] - past) * (eye - q)
            + math.pi * line.axial_drag_coefficient * np.linalg.norm(past) * q
        )
        if r[i + 1, 2] < BED:
            area = line.diameter * line.length
            c[here, here][2, 2] += line.seabed_damping * area
            k[here, here][2, 2] += line.seabed_stiffness * area
    for j in range(NODES - 1):
        turn = r[j + 1] - r[j]
        stretched = np.linalg.norm(turn)
        turn = np.outer(turn, turn) / stretched**2 / line.length
        for a in (j - 1, j):
            for b in (j - 1, j):
                if 0 <= a < inner and 0 <= b < inner:
                    block, at = (
                        (2 * (a == b) - 1) * turn,
                        np.s_[3 * a : 3 * a + 3, 3 * b : 3 * b + 3],
                    )
                    c[at] += line.damping * block
                    if stretched > line.length:
                        k[at] += line.axial_stiffness * block
    left = np.linalg.inv(m)
    return np.linalg.eigvals(np.block([[np.zeros_like(m), np.eye(size)], [-left @ k, -left @ c]]))


def alone(line: Segment, r: np.ndarray, v: np.ndarray, scheme: str, h: float) -> bool:
    """True if the loop over MoorDyn takes h [s] in one internal step."""
    doubles = ctypes.POINTER(ctypes.c_double)
    function = library().m4e_line_steps
    function.restype = ctypes.c_uint64
    given = np.array(kind(line, bed=BED)), np.ascontiguousarray(r), np.ascontiguousarray(v)
    numbers, at, speed = (values.ctypes.data_as(doubles) for values in given)
    found = function(
        numbers,
        ctypes.c_uint32(NODES - 1),
        ctypes.c_double(line.length * (NODES - 1)),
        at,
        speed,
        None,
        ctypes.c_double(h),
        ctypes.c_uint64(1),
        ctypes.c_uint32(int(scheme[2])),
        ctypes.c_double(1.0),
    )
    return found == 1


def growth(found: np.ndarray, scheme: str, h: float) -> float:
    """Of the modes of these eigenvalues [1/s] in a step of h [s]."""
    return float(np.abs(np.polynomial.polynomial.polyval(found * h, EXACT[scheme])).max())


def does_not_grow(found: np.ndarray, scheme: str, h: float) -> bool:
    return growth(found, scheme, h) <= 1


def largest(single: Callable[[float], bool], low: float = 1e-9, high: float = 1e3) -> float:
    """The largest h [s], to 0.1 %, up to which `single(h)` holds."""
    while high / low > 1.001:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if single(middle) else (low, middle)
    return low


def test_chosen_steps_are_stable_and_hardly_shorter_than_they_must_be() -> None:
    rng = np.random.default_rng(3)
    shares = []
    for _ in range(150):
        line, scheme = segment(rng), str(rng.choice(["RK2", "RK4"]))
        r = places(rng, line)
        v = np.zeros_like(r)
        v[:, :] = rng.normal(0, 1) * np.array([1.0, 0.5, 0.0])  # no node nears another, or the bed
        found = eigenvalues(line, r, v)
        found = found[found.real < -1e-3 * np.abs(found)]  # others are hardly damped
        chosen = largest(partial(alone, line, r, v, scheme))
        assert growth(found, scheme, chosen) <= 1.0001
        stable = largest(partial(does_not_grow, found, scheme))
        if line.damping > 0.5 * line.length * math.sqrt(
            line.axial_stiffness * line.mass_per_length
        ):
            shares.append(chosen / stable)
    assert np.median(shares) > 0.9


def test_lines_that_will_be_slack_or_on_the_bed_get_shorter_steps() -> None:
    line = segment(np.random.default_rng(1))
    line = replace(
        line, damping=line.length * math.sqrt(line.axial_stiffness * line.mass_per_length)
    )
    up = np.arange(NODES)[:, None] * np.array([0.0, 0.0, line.length * 1.0001]) + [0, 0, BED + 0.01]
    still, down = np.zeros((NODES, 3)), np.zeros((NODES, 3))
    taut = largest(partial(alone, line, up, still, "RK2"))
    down[:, 2] = -np.linspace(0, 1, NODES) * line.length * 1e-3 * NODES / taut
    assert largest(partial(alone, line, up, down, "RK2")) < 0.55 * taut
    down[:, 2] = -0.02 / taut
    assert largest(partial(alone, line, up, down, "RK2")) < 0.9 * taut


def plain(**changes: float) -> Segment:
    values = {"length": 10.0, "diameter": 0.1, "mass_per_length": 100.0, "axial_stiffness": 1e8}
    none = ("damping", "bending_stiffness", "seabed_stiffness", "seabed_damping")
    return Segment(**(values | dict.fromkeys(none, 0.0) | changes))


def test_stability_limits_against_the_known_ones() -> None:
    # ω = (2/10) √(1e8/100) = 200 rad/s; RK4 is stable on the negative real axis up to 2.7853, RK2
    # up to 2 (Hairer & Wanner, Solving ODEs II, IV.2). Between the imaginary axis (2√2) and there
    # RK4's boundary comes as near as 2.62, which further damping may reach.
    # The search steps by 1/400 of the mode; the growth it lets pass moves the limits by < 0.5 %.
    critical = plain(damping=10 * (1e8 * 100) ** 0.5)
    # a damper of the seabed alone: rate cBot d/m' = 400 1/s, far above its spring's √(kBot d/m')
    seabed = plain(seabed_stiffness=1.0, seabed_damping=4e5)
    for line, scheme, rate, limit in (
        (plain(), "RK4", 200, 2.62),
        (critical, "RK4", 200, 2.7853),
        (critical, "RK2", 200, 2.0),
        (plain(damping=1.25 * critical.damping), "RK2", 400, 2.0),  # 1.25 + 0.75
        (seabed, "RK4", 400, 2.7853),
    ):
        assert stable_step(line, scheme) * rate == pytest.approx(limit, rel=0.005)
    # without damping RK2 grows by (ω dt)^4/8 a step: 0.0001 at ω dt = 0.1682, found to 1/400
    assert stable_step(plain(), "RK2") * 200 == pytest.approx(0.1682, abs=1 / 400)
    assert cheapest_scheme([critical]) == "RK2"
    assert cheapest_scheme([critical, plain()]) == "RK4"


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
def test_the_longest_step_is_stable(scheme: str) -> None:
    # ω = (2/46 m) √(1e9/150) = 112 rad/s alone would allow 2/ω = 0.018 s with RK2; the seabed's
    # damper, cBot d/(m' + 8) = 190 1/s, allows 0.0105 s
    text = LANDING.replace("SEGMENTS", "10")
    with pytest.raises(InputError, match="l1 allows at most") as caught:
        mooring_of(text + f"solver: {{scheme: {scheme}, time_step: 0.02}}\n")
    longest = float(str(caught.value).split("at most ")[1].split()[0])
    assert longest == pytest.approx({"RK2": 2.0, "RK4": 2.7853}[scheme] / 190, rel=0.005)
    made = mooring_of(text + f"solver: {{scheme: {scheme}}}\n")
    assert made.time_step == pytest.approx(MARGIN * longest, rel=0.01)
    assert mooring_of(LANDING.replace("SEGMENTS", "1")).time_step >= 0.9  # nothing moves inside
