"""A linear power take-off: spring, damper and pretension between a body point and an anchor."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, StringConstraints, model_validator

from m4e_fmi.files.document import Section, rejected
from m4e_fmi.program import Program, Recorder, Scalar, Variable, sqrt

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Coordinate = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Place = tuple[Coordinate, Coordinate]


class LinearPtoConfig(Section):
    """The keys of a component of `kind: linear_pto`, without `kind` and `start`.

    point: the name of the body point; anchor: (x, z) [m] of the fixed end, world frame;
    damping [N·s/m]; stiffness [N/m]; pretension [N], positive pulls the point to the anchor.
    The length without spring force is rest_length [m], or the distance from the anchor to
    point_at, the (x, z) [m] where the point is at rest.
    """

    point: Name
    anchor: Place
    damping: NonNegative
    stiffness: NonNegative = 0.0
    pretension: Coordinate = 0.0
    rest_length: Positive | None = None
    point_at: Place | None = None

    @model_validator(mode="after")
    def _one_length(self) -> LinearPtoConfig:
        if (self.rest_length is None) == (self.point_at is None):
            raise rejected(
                "the rest length must be given in one way",
                "drop one of 'rest_length' and 'point_at'"
                if self.point_at is not None
                else "add 'rest_length: …' in m, or 'point_at: [x, z]' where the point is at rest",
            )
        if self.point_at == self.anchor:
            raise rejected(
                f"'point_at' and 'anchor' are both {list(self.anchor)}",
                "a power take-off needs a length: move the anchor away from the point",
            )
        return self

    @property
    def place(self) -> Place:
        """Where the point is before anything is connected: at rest, above the anchor if unsaid."""
        if self.point_at is not None:
            return self.point_at
        return (self.anchor[0], self.anchor[1] + (self.rest_length or 0.0))

    @property
    def length(self) -> float:
        """The length without spring force [m]."""
        return self.rest_length or math.dist(self.place, self.anchor)


def linear_pto(config: LinearPtoConfig, *, name: str) -> Program:
    """The program of the power take-off called `name`.

    With r = point − anchor, l = |r|, u = r/l and l̇ = u·v, the force on the body is
    −(stiffness (l − rest_length) + damping l̇ + pretension) u; power = damping l̇² is absorbed.
    """
    r = Recorder(name, f"linear power take-off at {config.point}")
    damping, stiffness, rest, pretension, anchor = _parameters(r, config)
    place, velocity = _motion(r, config)
    arm = (place[0] - anchor[0], place[1] - anchor[1])
    length = sqrt(arm[0] * arm[0] + arm[1] * arm[1])
    along = (arm[0] / length, arm[1] / length)
    rate = along[0] * velocity[0] + along[1] * velocity[1]
    extension = length - rest
    tension = stiffness * extension + damping * rate + pretension
    power = damping * rate * rate
    for axis, direction in zip("xz", along, strict=True):
        text = f"force on the body at {config.point} along {axis}, world frame"
        r.output(Variable(f"{config.point}.force_{axis}", "N", text), -tension * direction)
    r.output(Variable("force", "N", "tension: positive pulls the point to the anchor"), tension)
    r.output(Variable("extension", "m", "distance to the anchor minus rest length"), extension)
    r.output(Variable("extension_rate", "m/s", "speed away from the anchor"), rate)
    r.output(Variable("power", "W", "mechanical power absorbed by the damper"), power)
    r.state(Variable("energy", "J", "mechanical energy absorbed by the damper since the start"))
    r.rate("energy", power)
    return r.program()


def _parameters(
    r: Recorder, config: LinearPtoConfig
) -> tuple[Scalar, Scalar, Scalar, Scalar, tuple[Scalar, Scalar]]:
    damping, stiffness = (
        Variable(key, unit, key, start=getattr(config, key), tunable=True, minimum=0.0)
        for key, unit in (("damping", "N.s/m"), ("stiffness", "N/m"))
    )
    text = "length without spring force"
    rest = Variable("rest_length", "m", text, start=config.length, minimum=0.0)
    text = "constant tension: positive pulls the point to the anchor"
    pretension = Variable("pretension", "N", text, start=config.pretension)
    anchor = [
        Variable(f"anchor.{axis}", "m", f"{axis} of the anchor, world frame", start=value)
        for axis, value in zip("xz", config.anchor, strict=True)
    ]
    scalars = [r.parameter(v) for v in (damping, stiffness, rest, pretension, *anchor)]
    return scalars[0], scalars[1], scalars[2], scalars[3], (scalars[4], scalars[5])


def _motion(
    r: Recorder, config: LinearPtoConfig
) -> tuple[tuple[Scalar, Scalar], tuple[Scalar, Scalar]]:
    point, places, velocities = config.point, [], []
    for axis, start in zip("xz", config.place, strict=True):
        where = f"{point}.{axis}"
        text = f"{axis} of {point}, world frame"
        places.append(r.input(Variable(where, "m", text, start=start)))
        text = f"velocity of {point} along {axis}, world frame"
        velocities.append(r.input(Variable(f"{point}.v{axis}", "m/s", text)))
    return (places[0], places[1]), (velocities[0], velocities[1])
