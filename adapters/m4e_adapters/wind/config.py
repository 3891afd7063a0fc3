"""Keys of a `kind: wind` component of a system file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic_core import InitErrorDetails, ValidationError

from m4e_adapters.hydrodynamics.config.numbers import Finite, NotNegative, Place, Positive
from m4e_adapters.hydrodynamics.config.sections import NAME
from m4e_fmi.files.document import Section, rejected_at


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
