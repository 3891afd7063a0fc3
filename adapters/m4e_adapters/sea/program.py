"""The undisturbed sea as a Program: Airy waves at fixed and moving points.

The equations are those of `m4e_adapters.hydrodynamics.seas.water.recorded_flow`.

For the response to any wave, what waves do at the points is in inputs, `wave.elevation_input` and
`<point>.wave_elevation`, `.wave_velocity_x` …, in place of the waves; `PointWaves` has what they
are for waves of any frequency and direction: those of linear waves at the place of the point, of
moving ones at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import (
    ELEVATION_INPUT,
    elevation_at_origin,
    record_elevation_input,
)
from m4e_adapters.hydrodynamics.seas.system_seas import SystemWaves, lines_on
from m4e_adapters.hydrodynamics.seas.water.current import record_current
from m4e_adapters.hydrodynamics.seas.water.kinematics import (
    depth_profiles,
    velocity_per_amplitude,
    wavenumber,
)
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Flow, RecordedFlow
from m4e_adapters.sea.config import SeaConfig
from m4e_fmi.program import (
    Program,
    Recorder,
    Scalar,
    Variable,
)

Number = Scalar | float
AXES = ("x", "y", "z")


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
    for line in lines_on(systems):
        progress(line)
    flow = RecordedFlow(
        water=water,
        time=recorder.time,
        waves=[system.record(recorder, in_space=in_space) for system in systems],
        current=record_current(recorder, config.current, depth=water.depth, in_space=in_space),
        stretching=config.stretching,
    )
    recorder.output(elevation_at_origin(config.dimensions), flow.elevation_at_origin())
    for point in (*config.points, *config.moving_points):
        place = record_place(recorder, config, point)
        record_outputs(recorder, point, flow.at(place), place[2], in_space=in_space)
    return recorder.program()


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


@dataclass(kw_only=True)
class PointWaves(SystemWaves):
    """Waves at the points of `config`: `m4e_fmi.analysis.response.WaveForces`."""

    config: SeaConfig

    @property
    def inputs(self) -> list[str]:
        """The elevation at x = y = 0, and what the water does at each point."""
        points = (*self.config.points, *self.config.moving_points)
        return [
            ELEVATION_INPUT,
            *(v.name for point in points for v in point_inputs(self.config, point)),
        ]

    def per_amplitude(
        self, omega: np.ndarray, directions: np.ndarray, values: Mapping[str, float]
    ) -> np.ndarray:
        """Each input per amplitude, (k, m) [SI], for waves of `omega` (k,) [rad/s].

        They travel to `directions` (k,) [rad].
        """
        config, water = self.config, self.config.water
        number = wavenumber(omega, depth=water.depth, gravity=water.gravity)
        columns = [np.ones(len(omega), dtype=complex)]
        for point, start in {**config.points, **config.moving_points}.items():
            axes = AXES if config.dimensions == 3 else ("x", "z")
            at = {
                axis: values.get(f"{point}.{axis}", value)
                for axis, value in zip(axes, start, strict=True)
            }
            way = at["x"] * np.cos(directions) + at.get("y", 0.0) * np.sin(directions)
            crest = np.exp(1j * number * way)
            level = max(min(at["z"], 0.0), -water.depth)
            _, _, pressing = depth_profiles(number, level, water.depth)
            here = (at["x"], at.get("y", 0.0), at["z"])
            flow = velocity_per_amplitude(
                omega, directions, here, depth=water.depth, number=number
            ).T
            kept = [k for k, axis in enumerate(AXES) if axis in axes]
            columns.append(crest)
            columns += [flow[k] for k in kept]
            columns += [-1j * omega * flow[k] for k in kept]
            columns.append(water.density * water.gravity * pressing * crest)
        return np.stack(columns, axis=1)


def sea_in_waves(
    config: SeaConfig, *, name: str, folder: Path, progress: Callable[[str], object], **__: object
) -> tuple[Program, PointWaves]:
    """The program of the sea called `name` with such inputs, and what they are in any wave."""
    recorder = Recorder(name, "undisturbed sea")
    water, in_space = config.water, config.dimensions == 3
    systems = wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)
    for line in lines_on(systems):
        progress(line)
    for system in systems:
        system.record(recorder, in_space=in_space)
    current = record_current(recorder, config.current, depth=water.depth, in_space=in_space)
    record_elevation_input(recorder, config.dimensions)
    for point in (*config.points, *config.moving_points):
        _, _, z = record_place(recorder, config, point)
        given = {v.name: recorder.input(v) for v in point_inputs(config, point)}
        u, v, w = _vector(given, f"{point}.wave_velocity")
        along_x, along_y = current.velocity(z)
        flow = Flow(
            given[f"{point}.wave_elevation"],
            (u + along_x, v + along_y, w),
            _vector(given, f"{point}.wave_acceleration"),
            given[f"{point}.wave_dynamic_pressure"],
        )
        record_outputs(recorder, point, flow, z, in_space=in_space)
    return recorder.program(), PointWaves(config=config, systems=systems, water=water)


def point_inputs(config: SeaConfig, point: str) -> Iterator[Variable]:
    """The inputs that stand for the waves at a point, in order of `PointWaves.per_amplitude`."""
    axes = AXES if config.dimensions == 3 else ("x", "z")
    text = f"of linear waves at {point}"
    yield Variable(f"{point}.wave_elevation", "m", f"elevation {text}")
    for what, unit in (("velocity", "m/s"), ("acceleration", "m/s2")):
        for axis in axes:
            yield Variable(f"{point}.wave_{what}_{axis}", unit, f"{what} {text}, along {axis}")
    yield Variable(f"{point}.wave_dynamic_pressure", "Pa", f"dynamic pressure {text}")


def _vector(given: Mapping[str, Scalar], name: str) -> tuple[Number, Number, Number]:
    x, y, z = (given.get(f"{name}_{axis}", 0.0) for axis in AXES)
    return x, y, z
