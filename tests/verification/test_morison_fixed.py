"""Forces on fixed members beside own quadrature, in waves and a current, plane and space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.optimize import brentq

from m4e_adapters.hydrodynamics.config import Current
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.water.current import current_velocity
from m4e_adapters.hydrodynamics.seas.water.kinematics import (
    Components,
    Stretching,
    elevation,
    flow,
)
from m4e_adapters.morison import MorisonConfig, morison_program
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python

RHO, DEPTH = 1025.0, 30.0
LEVER = np.array([2.0, -1.0, -30.0])
REGULAR = {"spectrum": "regular", "height": 6.0, "period": 9.0, "direction": 25, "ramp_time": 0}
SEA = {
    "spectrum": "jonswap", "significant_height": 4.0, "peak_period": 8.0, "direction": 25,
    "components": 15, "seed": 2, "ramp_time": 0,
}  # fmt: skip
CURRENT = {"speed": 1.1, "direction": 70, "profile": 0.143}
PILE = {"ends": [[4, 3, -30], [4, 3, 8]], "diameter": 1.2, "drag": 0.9, "added_mass": 0.9}
BRACE = {
    "ends": [[-3, 1, -12], [5, 4, 6]], "diameter": 0.8, "drag": 1.1, "tangential_drag": 0.05,
    "inertia": 1.8,
}  # fmt: skip


def config(member: dict[str, Any], **more: Any) -> MorisonConfig:
    given: dict[str, Any] = {
        "dimensions": 3,
        "water": {"depth": DEPTH, "density": RHO},
        "waves": REGULAR,
        "current": CURRENT,
        "members": {"leg": member},
        "reference_point": LEVER.tolist(),
    }
    return MorisonConfig.model_validate({**given, **more})


def made(given: MorisonConfig) -> Program:
    return morison_program(given, name="pile", folder=Path(), progress=lambda _: None)


def rows_of(program: Program, times: Sequence[float]) -> np.ndarray:
    """Force and moment (times, 6)."""
    form = load_python(program)
    p = [v.start for v in program.parameters]
    u = [v.start for v in program.inputs]
    names = [v.name for v in program.outputs]
    rows = np.array([form.outputs(t, [], u, p, form.constants(p)) for t in times])
    return rows[:, [names.index(name) for name in WRENCH]]


def waves_of(given: MorisonConfig) -> Components:
    return components_of(wave_systems(given.waves, depth=DEPTH, gravity=given.water.gravity), {})


def by_quadrature(given: MorisonConfig, t: float) -> np.ndarray:
    """Force and moment (6,) by adaptive quadrature of Morison's equation to the surface."""
    member, waves = given.members["leg"], waves_of(given)
    current = given.current
    stretching: Stretching = given.stretching
    first, second = (np.array(end) for end in member.ends)
    axis = (second - first) / member.length

    def depth(s: float) -> float:
        x, y, z = first + s * axis
        return float(elevation(waves, t, x, y)) - z

    half = 0.5 * member.diameter * math.hypot(axis[0], axis[1])
    kinks = [
        brentq(lambda s, k=k: depth(s) + k * half, 0.0, member.length, xtol=1e-12)
        for k in (-1.0, 1.0)
        if depth(member.length) + k * half < 0.0
    ]

    def per_length(s: float) -> np.ndarray:
        place = first + s * axis
        water = flow(waves, t, place, stretching=stretching)
        u, a = water.velocity, water.acceleration
        if isinstance(current, Current):
            u = u + current_velocity(current, place[2], depth=DEPTH)
        across, along = u - axis * (u @ axis), u @ axis
        force = 0.5 * RHO * member.diameter * member.drag * np.linalg.norm(across) * across
        skin = 0.5 * RHO * math.pi * member.diameter * member.tangential_drag
        force = force + skin * abs(along) * along * axis
        area = math.pi / 4 * member.diameter**2
        force = force + RHO * area * member.inertia_coefficient * (a - axis * (a @ axis))
        wet = depth(s) / (2 * half) + 0.5 if half else math.inf
        force = force * float(np.clip(wet, 0.0, 1.0))
        return np.concatenate([force, np.cross(place - LEVER, force)])

    end = kinks[-1] if kinks else member.length
    return np.asarray(quad_vec(per_length, 0.0, end, epsrel=1e-5, points=kinks[:-1])[0])


WRENCH = [f"fixed.{name}_{axis}" for name in ("force", "moment") for axis in "xyz"]


LIMIT = 5e-3
"""Of the error with the segments that members have by default, over the largest load."""


def largest_errors(
    member: dict[str, Any], segments: Sequence[int], *, count: int = 3, **more: Any
) -> list[float]:
    """Over a period, of force and moment over their largest size, one for each of `segments`."""
    times = np.linspace(0.0, 9.0, count, endpoint=False).tolist()
    expected = np.array([by_quadrature(config(member, **more), t) for t in times])
    sizes = [np.linalg.norm(expected[:, k : k + 3], axis=1).max() for k in (0, 3)]

    def error(number: int) -> float:
        program = made(config({**member, "segments": number}, **more))
        off = rows_of(program, times) - expected
        errors = [np.linalg.norm(off[:, k : k + 3], axis=1).max() for k in (0, 3)]
        return max(errors[0] / sizes[0], errors[1] / sizes[1])

    return [error(number) for number in segments]


@pytest.mark.verifies(
    "force and moment on a pile in waves (regular, JONSWAP) and a current, Wheeler and linear",
    independent="adaptive quadrature of Morison's equation up to the surface",
    tolerance="5e-3, and at least first order in the length of segments",
)
@pytest.mark.parametrize("waves", [REGULAR, SEA], ids=["regular", "irregular"])
@pytest.mark.parametrize("stretching", ["wheeler", "linear"])
def test_an_upright_cylinder_in_waves_and_current(waves: dict[str, Any], stretching: str) -> None:
    """The order is 8/7: at the bed the current is a power 1/7 of the height."""
    coarse, fine = largest_errors(PILE, (10, 40), waves=waves, stretching=stretching)
    assert coarse < LIMIT
    assert fine < coarse / 4


def test_an_upright_cylinder_in_a_uniform_current() -> None:
    """Loads are smooth up to the surface, where the last segment ends: three points are exact."""
    current = {key: CURRENT[key] for key in ("speed", "direction")}
    assert largest_errors(PILE, (10,), current=current, stretching="wheeler")[0] < 1e-6


@pytest.mark.parametrize("stretching", ["wheeler", "linear"])
def test_an_inclined_member(stretching: str) -> None:
    """Sections that are wet in part begin and end within segments, so the order varies."""
    coarse, fine = largest_errors(BRACE, (10, 40), stretching=stretching)
    assert coarse < LIMIT
    assert fine < coarse / 4
