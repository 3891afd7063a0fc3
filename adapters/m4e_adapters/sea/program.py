"""The undisturbed sea as a Program: Airy waves at fixed and moving points.

The equations are those of `m4e_adapters.hydrodynamics.seas.kinematics`, with one difference: all
components of a system are multiplied by its ramp, accelerations and pressures too. The elevation at
x = y = 0 is recorded in the order of the hydrodynamics, so that both give the same bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import elevation_at_origin
from m4e_adapters.hydrodynamics.seas.systems import RecordedWaves, WaveSystem
from m4e_adapters.sea.config import SeaConfig
from m4e_fmi.program import (
    Program,
    Recorder,
    Scalar,
    Variable,
    cos,
    exp,
    maximum,
    minimum,
    sin,
)

Number = Scalar | float
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Flow:
    """The water at a point: `elevation` [m], vectors (3,) [m/s, m/s2], pressure [Pa]."""

    elevation: Number
    velocity: tuple[Number, Number, Number]
    acceleration: tuple[Number, Number, Number]
    pressure: Number


def sea_program(
    config: SeaConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The program of the sea called `name`; files of its waves are in `folder`.

    Inputs `<point>.x .z` (and `.y` in space) of moving points, parameters of fixed ones; outputs
    `wave.elevation`, and `<point>.elevation`, `.submergence`, `.velocity_x` …, `.acceleration_x` …,
    `.dynamic_pressure`. `progress` is told of waves that there are not.
    """
    recorder = Recorder(name, "undisturbed sea")
    water, in_space = config.water, config.dimensions == 3
    systems = wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)
    tell_doubts(systems, progress)
    waves = [system.record(recorder, in_space=in_space) for system in systems]
    clocks = [_clocks(recorder, own) for own in waves]
    elevation: Number = 0.0
    for own, clock in zip(waves, clocks, strict=True):
        elevation = elevation + own.ramp * _height(own, clock)
    recorder.output(elevation_at_origin(config.dimensions), elevation)
    for point in (*config.points, *config.moving_points):
        place = record_place(recorder, config, point)
        flow = _flow(config, waves, clocks, place)
        record_outputs(recorder, point, flow, place[2], in_space=in_space)
    return recorder.program()


def tell_doubts(systems: Sequence[WaveSystem], progress: Callable[[str], object]) -> None:
    """Warn of waves that break or are too steep."""
    for system in systems:
        for text in system.doubts({}):
            progress(f"warning: {text}")


Clock = list[tuple[Number, Number]]
"""Cosine and sine of ω t + φ of each component; for a point, of θ = ω t + φ − k · place."""


def _clocks(recorder: Recorder, waves: RecordedWaves) -> Clock:
    angles = [w * recorder.time + p for w, p in zip(waves.omega, waves.phase, strict=True)]
    return [(cos(angle), sin(angle)) for angle in angles]


def _height(waves: RecordedWaves, clock: Clock) -> Number:
    total: Number = 0.0
    for amplitude, (cosine, _) in zip(waves.amplitude, clock, strict=True):
        total = total + amplitude * cosine
    return total


def record_place(
    recorder: Recorder, config: SeaConfig, point: str
) -> tuple[Number, Number, Number]:
    """(x, y, z) [m] of a point, parameters or inputs."""
    moves = point in config.moving_points
    start = config.moving_points[point] if moves else config.points[point]
    declare = recorder.input if moves else recorder.parameter
    axes = AXES if len(start) == 3 else ("x", "z")
    found: dict[str, Number] = {"y": 0.0}
    for axis, value in zip(axes, start, strict=True):
        text = f"{axis} of the point {point}"
        found[axis] = declare(Variable(f"{point}.{axis}", "m", text, start=value))
    return found["x"], found["y"], found["z"]


def _flow(
    config: SeaConfig,
    waves: Sequence[RecordedWaves],
    clocks: Sequence[Clock],
    place: tuple[Number, Number, Number],
) -> Flow:
    x, y, z = place
    here: list[Clock] = []
    elevation: Number = 0.0
    for own, clock in zip(waves, clocks, strict=True):
        moved: Clock = []
        for k, (cosine, sine) in enumerate(clock):
            along, across = own.along(k)
            way = own.number[k] * (x * along + y * across)
            c, s = cos(way), sin(way)
            moved.append((cosine * c + sine * s, sine * c - cosine * s))
        here.append(moved)
        elevation = elevation + own.ramp * _height(own, moved)
    level, above = _levels(config, z, elevation)
    velocity, acceleration, pressure = [0.0] * 3, [0.0] * 3, 0.0
    for own, moved in zip(waves, here, strict=True):
        parts = _sums(config.water, own, moved, level, above)
        velocity = [a + own.ramp * b for a, b in zip(velocity, parts[0:3], strict=True)]
        acceleration = [a + own.ramp * b for a, b in zip(acceleration, parts[3:6], strict=True)]
        pressure = pressure + own.ramp * parts[6]
    weight = config.water.density * config.water.gravity
    u, v, w = velocity
    a, b, c = acceleration
    return Flow(elevation, (u, v, w), (a, b, c), weight * pressure)


def _levels(config: SeaConfig, z: Number, elevation: Number) -> tuple[Number, Number]:
    """Level [m] ≤ 0 at which profiles count, and how far their tangents reach above it."""
    depth = config.water.depth
    if config.stretching == "wheeler":
        level = z - elevation
        if math.isfinite(depth):
            level = level * (depth / (depth + elevation))
        above: Number = 0.0
        level = minimum(level, 0.0)
    else:
        wet = minimum(z, maximum(elevation, 0.0))
        level = minimum(wet, 0.0)
        above = wet - level
    return (maximum(level, -depth) if math.isfinite(depth) else level), above


def _sums(
    water: Water, waves: RecordedWaves, clock: Clock, level: Number, above: Number
) -> list[Number]:
    """Velocity (3), acceleration (3) and pressure over ρ g of a system, without its ramp."""
    total: list[Number] = [0.0] * 7
    for k, (cosine, sine) in enumerate(clock):
        number, rate = waves.number[k], waves.omega[k] * waves.amplitude[k]
        up, down, over_sinh, over_cosh = _profile(water, number, level)
        along, upwards = (up + down) * over_sinh, (up - down) * over_sinh
        rise = number * above
        along, upwards = along + rise * upwards, upwards + rise * along
        c, s = waves.along(k)
        horizontal, faster = rate * along, waves.omega[k] * rate
        terms = (
            horizontal * c * cosine,
            horizontal * s * cosine,
            -(rate * upwards) * sine,
            -(faster * along) * c * sine,
            -(faster * along) * s * sine,
            -(faster * upwards) * cosine,
            waves.amplitude[k] * (up + down) * over_cosh * cosine,
        )
        total = [a + b for a, b in zip(total, terms, strict=True)]
    return total


def _profile(water: Water, number: Number, level: Number) -> tuple[Number, Number, Number, Number]:
    """e^{kz}, e^{−k(z + 2h)}, and what makes profiles of their sums, as in `kinematics`."""
    up = exp(number * level)
    if math.isinf(water.depth):
        return up, 0.0, 1.0, 1.0
    bed = exp(-2.0 * water.depth * number)
    return up, bed / up, 1.0 / (1.0 - bed), 1.0 / (1.0 + bed)


def record_outputs(
    recorder: Recorder, point: str, flow: Flow, z: Number, *, in_space: bool
) -> None:
    """Outputs of a point at the height `z` [m]."""

    def output(name: str, unit: str, text: str, value: Number) -> None:
        recorder.output(Variable(f"{point}.{name}", unit, text), value)

    output("elevation", "m", f"elevation of the undisturbed water at {point}", flow.elevation)
    text = f"depth of {point} below the surface, negative above it"
    output("submergence", "m", text, flow.elevation - z)
    for k, axis in enumerate(AXES):
        if axis != "y" or in_space:
            text = f"velocity of the water at {point}, along {axis}"
            output(f"velocity_{axis}", "m/s", text, flow.velocity[k])
    for k, axis in enumerate(AXES):
        if axis != "y" or in_space:
            text = f"acceleration of the water at {point}, along {axis}"
            output(f"acceleration_{axis}", "m/s2", text, flow.acceleration[k])
    text = f"pressure at {point} without that of the still water"
    output("dynamic_pressure", "Pa", text, flow.pressure)
