"""Forces of steady wind on points of bodies as a Program.

    F = ½ ρ C A |w| w,   w = U(z) (cos β, sin β, 0) − v

v is the velocity of the point, all of it: the air above a heaving deck resists, too.
"""

from __future__ import annotations

import math

from m4e_adapters.wind.config import WindArea, WindConfig
from m4e_fmi.program import Program, Recorder, Scalar, Variable, cos, maximum, sin, sqrt

Number = Scalar | float
LOWEST = 1.0  # m, height below which the wind is that of this height
NONE = 1e-9  # m/s, so that the root has a slope in air at rest


def wind_program(config: WindConfig, *, name: str) -> Program:
    """The program of the wind, called `name`.

    Inputs `wind.speed`, in space `wind.direction`, and `<point>.{x,z,vx,vz}` (`.y`, `.vy`);
    outputs `<point>.{force_x,force_z}` (`.force_y`).
    """
    recorder = Recorder(name, "wind on points of bodies")
    in_space = config.dimensions == 3
    text = f"speed of the wind at {config.height:g} m above still water"
    speed = recorder.input(Variable("wind.speed", "m/s", text, start=config.speed))
    given = math.radians(config.direction)
    angle: Number = given
    if in_space:
        text = "direction that the wind blows to, from +X towards +Y"
        variable = Variable("wind.direction", "rad", text, start=given, display_unit="deg")
        angle = recorder.input(variable)
    along = (cos(angle), sin(angle) if in_space else 0.0)
    for point, section in config.points.items():
        _record_point(recorder, config, point, section, speed, along)
    return recorder.program()


def _record_point(
    recorder: Recorder,
    config: WindConfig,
    point: str,
    section: WindArea,
    speed: Number,
    along: tuple[Number, Number],
) -> None:
    axes = "xz" if config.dimensions == 2 else "xyz"
    starts = dict(zip(axes, section.at, strict=True))
    place: dict[str, Number] = {"y": 0.0}
    for axis in axes:
        text = f"{axis} of the point {point}, world frame"
        variable = Variable(f"{point}.{axis}", "m", text, start=starts[axis])
        place[axis] = recorder.input(variable)
    velocity: dict[str, Number] = {"y": 0.0}
    for axis in axes:
        text = f"rate of {point}.{axis}"
        velocity[axis] = recorder.input(Variable(f"{point}.v{axis}", "m/s", text))
    text = f"drag coefficient of {point} times its area"
    area = recorder.parameter(
        Variable(
            f"{point}.drag_area", "m2", text, start=section.area * section.coefficient,
            minimum=0.0, tunable=True,
        )
    )  # fmt: skip
    if config.exponent:
        speed = speed * (maximum(place["z"], LOWEST) / config.height) ** config.exponent
    wind = {"x": speed * along[0], "y": speed * along[1], "z": 0.0}
    relative = {axis: wind[axis] - velocity[axis] for axis in axes}
    size = sqrt(sum((r * r for r in relative.values()), NONE**2))
    for axis in axes:
        force = 0.5 * config.density * area * size * relative[axis]
        text = f"force of the wind on {point}, along {axis}"
        recorder.output(Variable(f"{point}.force_{axis}", "N", text), force)
