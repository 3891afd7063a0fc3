"""The sea with what waves do at its points as inputs, for the response to any wave.

In place of the waves the program has the inputs `wave.elevation_input` and
`<point>.wave_elevation`, `.wave_velocity_x` …; `PointWaves` has what they are for waves of any
frequency and direction: those of linear waves at the place of the point, of moving ones at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import ELEVATION_INPUT, record_elevation_input
from m4e_adapters.hydrodynamics.seas.system_seas import FlowWaves
from m4e_adapters.hydrodynamics.seas.water.current import record_current
from m4e_adapters.hydrodynamics.seas.water.kinematics import (
    depth_profiles,
    velocity_per_amplitude,
    wavenumber,
)
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Flow
from m4e_adapters.sea.config import SeaConfig
from m4e_adapters.sea.program import AXES, record_outputs, record_place, tell_doubts
from m4e_fmi.program import Program, Recorder, Scalar, Variable


@dataclass(frozen=True)
class PointWaves(FlowWaves):
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
    tell_doubts(systems, config.current, progress)
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
    return recorder.program(), PointWaves(config, systems)


def point_inputs(config: SeaConfig, point: str) -> Iterator[Variable]:
    """The inputs that stand for the waves at a point, in order of `PointWaves.per_amplitude`."""
    axes = AXES if config.dimensions == 3 else ("x", "z")
    text = f"of linear waves at {point}"
    yield Variable(f"{point}.wave_elevation", "m", f"elevation {text}")
    for what, unit in (("velocity", "m/s"), ("acceleration", "m/s2")):
        for axis in axes:
            yield Variable(f"{point}.wave_{what}_{axis}", unit, f"{what} {text}, along {axis}")
    yield Variable(f"{point}.wave_dynamic_pressure", "Pa", f"dynamic pressure {text}")


def _vector(
    given: Mapping[str, Scalar], name: str
) -> tuple[Scalar | float, Scalar | float, Scalar | float]:
    x, y, z = (given.get(f"{name}_{axis}", 0.0) for axis in AXES)
    return x, y, z
