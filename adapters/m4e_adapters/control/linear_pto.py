"""A linear power take-off: spring, damper and pretension between a body point and an anchor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field, StringConstraints, model_validator

from m4e_fmi.files.document import Section, rejected
from m4e_fmi.program import Program, Recorder, Scalar, Variable, sqrt

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Coordinate = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Place = tuple[Coordinate, Coordinate] | tuple[Coordinate, Coordinate, Coordinate]


class LinearPtoConfig(Section):
    """The keys of a component of `kind: linear_pto`, without `kind` and `start`.

    point: the name of the body point; anchor: (x, z) or in space (x, y, z) [m] of the fixed end,
    world frame;
    damping [N·s/m]; stiffness [N/m]; pretension [N], positive pulls the point to the anchor.
    The length without spring force is rest_length [m], or the distance from the anchor to
    point_at, where the point is at rest, given as the anchor is.
    """

    point: Name
    anchor: Place
    damping: NonNegative
    stiffness: NonNegative = 0.0
    pretension: Coordinate = 0.0
    rest_length: Positive | None = None
    point_at: Place | None = None

    @model_validator(mode="after")
    def _same_dimensions(self) -> LinearPtoConfig:
        if self.point_at is not None and len(self.point_at) != len(self.anchor):
            counts = f"{len(self.anchor)} and {len(self.point_at)}"
            raise rejected(
                f"'anchor' and 'point_at' have {counts} coordinates",
                "give both as [x, z], or both as [x, y, z]",
            )
        return self

    @model_validator(mode="after")
    def _one_length(self) -> LinearPtoConfig:
        if (self.rest_length is None) == (self.point_at is None):
            raise rejected(
                "the rest length must be given in one way",
                "drop one of 'rest_length' and 'point_at'"
                if self.point_at is not None
                else "add 'rest_length: …' in m, or 'point_at: […]' where the point is at rest",
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
        *level, height = self.anchor
        return (*level, height + (self.rest_length or 0.0))  # pyrefly: ignore[bad-return]

    @property
    def axes(self) -> str:
        """The axes of its vectors."""
        return "xz" if len(self.anchor) == 2 else "xyz"

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
    arm = [a - b for a, b in zip(place, anchor, strict=True)]
    length = sqrt(_dot(arm, arm))
    along = [part / length for part in arm]
    rate = _dot(along, velocity)
    extension = length - rest
    tension = stiffness * extension + damping * rate + pretension
    power = damping * rate * rate
    for axis, direction in zip(config.axes, along, strict=True):
        text = f"force on the body at {config.point} along {axis}, world frame"
        r.output(Variable(f"{config.point}.force_{axis}", "N", text), -tension * direction)
    r.output(Variable("force", "N", "tension: positive pulls the point to the anchor"), tension)
    r.output(Variable("extension", "m", "distance to the anchor minus rest length"), extension)
    r.output(Variable("extension_rate", "m/s", "speed away from the anchor"), rate)
    r.output(Variable("power", "W", "mechanical power absorbed by the damper"), power)
    r.state(Variable("energy", "J", "mechanical energy absorbed by the damper since the start"))
    r.rate("energy", power)
    return r.program()


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    first, *rest = (left * right for left, right in zip(a, b, strict=True))
    return sum(rest, start=first)


def _parameters(
    r: Recorder, config: LinearPtoConfig
) -> tuple[Scalar, Scalar, Scalar, Scalar, list[Scalar]]:
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
        for axis, value in zip(config.axes, config.anchor, strict=True)
    ]
    scalars = [r.parameter(v) for v in (damping, stiffness, rest, pretension, *anchor)]
    return scalars[0], scalars[1], scalars[2], scalars[3], scalars[4:]


def _motion(r: Recorder, config: LinearPtoConfig) -> tuple[list[Scalar], list[Scalar]]:
    point, places, velocities = config.point, [], []
    for axis, start in zip(config.axes, config.place, strict=True):
        where = f"{point}.{axis}"
        text = f"{axis} of {point}, world frame"
        places.append(r.input(Variable(where, "m", text, start=start)))
        text = f"velocity of {point} along {axis}, world frame"
        velocities.append(r.input(Variable(f"{point}.v{axis}", "m/s", text)))
    return places, velocities
