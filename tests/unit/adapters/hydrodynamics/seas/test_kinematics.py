"""Kinematics of sums of Airy waves satisfy the equations of linear waves; profiles of currents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Current
from m4e_adapters.hydrodynamics.seas.water.current import current_velocity, record_current
from m4e_adapters.hydrodynamics.seas.water.kinematics import (
    Components,
    elevation,
    flow,
)
from m4e_fmi.files.document import Document
from m4e_fmi.program import Recorder, Variable, evaluated

STEP = 1e-4
DENSITY = 1025.0
WEIGHT = DENSITY * 9.81


def some_waves(depth: float) -> Components:
    rng = np.random.default_rng(3)
    return Components(
        omega=np.linspace(0.4, 2.5, 12),
        amplitude=rng.uniform(0.05, 0.3, 12),
        phase=rng.uniform(0.0, 2 * math.pi, 12),
        direction=rng.uniform(-1.0, 1.0, 12),
        depth=depth,
    )


PLACES = np.array([[0.0, 0.0, -1.0], [12.0, -7.0, -3.5], [-40.0, 22.0, -7.9]])
TIMES = np.array([0.0, 3.0, 11.0])


@pytest.mark.parametrize("depth", [8.0, math.inf])
def test_below_still_water_the_flow_is_a_potential_flow(depth: float) -> None:
    """Continuity, no vorticity, and ρ ∂u/∂t = −∇p; central differences leave 1e-7."""
    waves = some_waves(depth)
    found = flow(waves, TIMES, PLACES, stretching="linear")
    slopes = np.empty((3, 3, 3))
    force = np.empty((3, 3))
    for axis, shift in enumerate(STEP * np.eye(3)):
        there = [flow(waves, TIMES, PLACES + s, stretching="linear") for s in (shift, -shift)]
        slopes[:, :, axis] = (there[0].velocity - there[1].velocity) / (2 * STEP)
        force[:, axis] = -WEIGHT * (there[0].head - there[1].head) / (2 * STEP)
    assert np.abs(found.velocity).max() > 0.1
    assert np.abs(np.trace(slopes, axis1=1, axis2=2)).max() < 1e-7
    assert np.abs(slopes - slopes.swapaxes(1, 2)).max() < 1e-7
    np.testing.assert_allclose(force, DENSITY * found.acceleration, atol=1e-4)


@pytest.mark.parametrize("depth", [8.0, math.inf])
def test_the_surface_moves_with_the_water_and_has_no_pressure(depth: float) -> None:
    waves = some_waves(depth)
    x, y = PLACES[:, 0], PLACES[:, 1]
    height = elevation(waves, TIMES, x, y)
    rate = elevation(waves, TIMES + STEP, x, y) - elevation(waves, TIMES - STEP, x, y)
    still = np.stack([x, y, np.zeros(3)], axis=1)
    up = flow(waves, TIMES, still, stretching="linear").velocity[:, 2]
    np.testing.assert_allclose(up, rate / (2 * STEP), atol=1e-7)
    for stretching in ("wheeler", "linear"):
        surface = np.stack([x, y, np.maximum(height, 0.0 if stretching == "linear" else height)], 1)
        head = flow(waves, TIMES, surface, stretching=stretching).head
        np.testing.assert_allclose(head, height, rtol=1e-12)


def test_wheeler_takes_the_surface_for_still_water_and_the_bed_for_itself() -> None:
    waves = some_waves(8.0)
    height = elevation(waves, TIMES, 5.0)
    assert height.min() < -0.1
    assert height.max() > 0.1
    for level, still in ((height, 0.0), (np.full(3, -8.0), -8.0)):
        there = np.stack([np.full(3, 5.0), np.zeros(3), level], axis=1)
        same = np.stack([np.full(3, 5.0), np.zeros(3), np.full(3, still)], axis=1)
        stretched = flow(waves, TIMES, there, stretching="wheeler")
        unmoved = flow(waves, TIMES, same, stretching="linear")
        for a, b in (
            (stretched.velocity, unmoved.velocity),
            (stretched.acceleration, unmoved.acceleration),
        ):
            np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-15)
    bed = np.array([5.0, 0.0, -8.0])
    assert abs(flow(waves, 3.0, bed).velocity[2]) < 1e-15


def test_linear_stretching_follows_the_tangent_up_to_the_surface() -> None:
    waves = Components(np.array([1.0]), np.array([1.0]), np.zeros(1), np.zeros(1))
    k = 1.0 / 9.81
    for z, expected in ((-2.0, math.exp(-2 * k)), (0.0, 1.0), (0.5, 1 + 0.5 * k), (3.0, 1 + k)):
        u = flow(waves, 0.0, np.array([0.0, 0.0, z]), stretching="linear").velocity[0]
        assert u == pytest.approx(expected, rel=1e-14)


ALONG = np.array([math.cos(math.radians(30)), math.sin(math.radians(30)), 0.0])


@pytest.mark.parametrize(
    ("profile", "known"),
    [
        ("{speed: 1.2, direction: 30}", {3.0: 1.2, -29.0: 1.2}),
        ("{speed: 1.2, direction: 30, profile: 0.143}", {3.0: 1.2, -15.0: 1.2 * 0.5**0.143}),
        (
            "{direction: 30, profile: [[0, 1.2], [-10, 0.7], [-25, -0.1]]}",
            {-4.0: 1.0, -28.0: -0.1},
        ),
    ],
    ids=["uniform", "power", "table"],
)
def test_profiles_of_currents(profile: str, known: dict[float, float]) -> None:
    """In 30 m of water, by hand; a recorded current is that in numbers."""
    given = Document.parse(profile).validate(Current)
    found = current_velocity(given, list(known), depth=30.0)
    assert found == pytest.approx(np.outer([*known.values()], ALONG))
    recorder = Recorder("water", "a current")
    z = recorder.input(Variable("z", "m", "height"))
    recorded = record_current(recorder, given, depth=30.0, in_space=True)
    for axis, value in zip("xy", recorded.velocity(z), strict=True):
        recorder.output(Variable(axis, "m/s", "speed"), value)
    program = recorder.program()
    start = {v.name: v.start for v in program.parameters}
    for height in (5.0, 0.0, -3.0, -12.0, -29.0, -30.0, -31.0):
        values = evaluated(program.tape, list(program.results), {**start, "z": height, "time": 0.0})
        expected = current_velocity(given, height, depth=30.0)
        assert [values[k] for k in program.results] == pytest.approx(expected[:2], rel=1e-12)
