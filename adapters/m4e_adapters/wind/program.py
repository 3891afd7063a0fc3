"""Forces of steady wind on points of bodies as a Program.

    F = ½ ρ C A |w| w,   w = U(z) (cos β, sin β, 0) − v

v is the velocity of the point, all of it: the air above a heaving deck resists, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic_core import InitErrorDetails, ValidationError

from m4e_adapters.hydrodynamics.config.numbers import Finite, NotNegative, Place, Positive
from m4e_adapters.hydrodynamics.config.sections import NAME
from m4e_fmi.files.document import Section, rejected_at
from m4e_fmi.program import Program, Recorder, Scalar, Variable, cos, maximum, sin, sqrt

Number = Scalar | float
LOWEST = 1.0  # m, height below which the wind is that of this height
NONE = 1e-9  # m/s, so that the root has a slope in air at rest


class WindArea(Section):
    """A point of a body in the wind: `area` [m2] and drag `coefficient` [1], the same
    from all sides. `at` [x, z] [m], in space [x, y, z], is where the point is before it is
    connected.
    """

    area: Positive
    coefficient: Positive
    at: Place


class WindConfig(Section):
    """Steady wind, horizontal, on points of bodies.

    `speed` [m/s] is that at the `height` [m] above still water, default 10; with an `exponent` p
    [1] (0.14 at sea is usual) it is speed·(z/height)^p at a point's own height z, not below 1 m;
    default 0: the same everywhere. `direction` [deg] is where the wind blows to: 0 is +X, in space
    the angle from +X towards +Y, in the plane 0 or 180. `density` [kg/m3] is that of the air.
    """

    dimensions: Literal[2, 3] = 2
    speed: NotNegative
    direction: Finite = 0.0
    height: Annotated[float, Field(ge=1, allow_inf_nan=False)] = 10.0
    exponent: Annotated[float, Field(ge=0, le=1)] = 0.0
    density: Positive = 1.225
    points: Annotated[dict[Annotated[str, Field(pattern=NAME)], WindArea], Field(min_length=1)]

    @model_validator(mode="after")
    def _of_its_dimensions(self) -> WindConfig:
        if wrong := [*self._wrong()]:
            raise ValidationError.from_exception_data("wind", wrong)
        return self

    def _wrong(self) -> Iterator[InitErrorDetails]:
        if self.dimensions == 2 and self.direction not in (0.0, 180.0):
            text = f"wind direction {self.direction:g} deg leaves the X-Z plane"
            remedy = "write 0 (it blows to +X), 180 (to -X), or 'dimensions: 3' on top"
            yield rejected_at(("direction",), text, remedy)
        axes = "[x, z]" if self.dimensions == 2 else "[x, y, z]"
        for name, point in self.points.items():
            if name == "wind":
                text = "'wind' is the name of the wind"
                yield rejected_at(("points", name), text, "give the point another name")
            if len(point.at) != self.dimensions:
                text = f"'at' has {len(point.at)} coordinates, expected {axes}"
                remedy = f"write {axes}, or change 'dimensions'"
                yield rejected_at(("points", name, "at"), text, remedy)


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
