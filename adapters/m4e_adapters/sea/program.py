"""The undisturbed sea as a Program: Airy waves at fixed and moving points.

The equations are those of `m4e_adapters.hydrodynamics.seas.water.recorded_flow`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from m4e_adapters.hydrodynamics.config import Current
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.sea import elevation_at_origin
from m4e_adapters.hydrodynamics.seas.system_seas import lines_on
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.current import current_doubts, record_current
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
    tell_doubts(systems, config.current, progress)
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


def tell_doubts(
    systems: Sequence[WaveSystem], current: Current | None, progress: Callable[[str], object]
) -> None:
    """Tell of records, of waves that break or are too steep, and of waves on a current."""
    for line in lines_on(systems):
        progress(line)
    for text in current_doubts(current, has_waves=bool(systems)):
        progress(f"warning: {text}")


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
