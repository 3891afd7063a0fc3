"""A steady current."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from m4e_adapters.hydrodynamics.config.numbers import Coordinate, Finite, NotNegative
from m4e_fmi.files.document import Section, rejected

MOST_ROWS = 100

Rows = tuple[tuple[Coordinate, Finite], ...]
"""[z, speed] [m, m/s]."""


def _from_bed_to_surface(rows: Rows) -> Rows:
    if not 2 <= len(rows) <= MOST_ROWS:
        text = f"a table of {len(rows)} rows, expected 2 to {MOST_ROWS}"
        raise rejected(text, "write [[z, speed], …]; one speed for all z is 'profile: uniform'")
    heights = [z for z, _ in rows]
    if len(set(heights)) < len(heights):
        raise rejected("the table has two speeds at one z", "give each z [m] once")
    return tuple(sorted(rows))


def _kind(profile: object) -> str:
    if isinstance(profile, (list, tuple)):
        return "table"
    return "word" if isinstance(profile, str) else "exponent"


Profile = Annotated[
    Annotated[Literal["uniform"], Tag("word")]
    | Annotated[Annotated[float, Field(gt=0, le=1)], Tag("exponent")]
    | Annotated[Annotated[Rows, AfterValidator(_from_bed_to_surface)], Tag("table")],
    Discriminator(_kind),
]


class Current(Section):
    """A steady, horizontal current that flows to `direction` [deg]: 0 is +X, in space the angle
    from +X towards +Y, in the plane 0 or 180.

    `speed` [m/s] is that at the still-water level z = 0. `profile` is `uniform` (default); or the
    exponent of a power law, speed·((z + h)/h)^exponent in water of depth h (1/7 is usual for
    tides); or a table [[z, speed], …] [m, m/s] in place of `speed`, linear between its rows and
    constant beyond. Above z = 0 the current is that of z = 0.
    """

    speed: NotNegative | None = None
    direction: Finite = 0.0
    profile: Profile = "uniform"

    @model_validator(mode="after")
    def _one_speed(self) -> Current:
        if isinstance(self.profile, tuple) == (self.speed is not None):
            if self.speed is None:
                raise rejected("a current needs a 'speed' [m/s]", "add the speed at the surface")
            raise rejected("'speed' has no effect: the table has speeds", "remove one of the two")
        return self


def current_problems(
    current: Current | None, *, depth: float, dimensions: int
) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """Place, message and remedy of what does not suit water of `depth` [m], or the dimensions."""
    if current is None:
        return
    if dimensions == 2 and current.direction not in (0.0, 180.0):
        text = f"current direction {current.direction:g} deg leaves the X-Z plane"
        remedy = "write 0 (it flows to +X), 180 (to -X), or 'dimensions: 3' on top"
        yield ("current", "direction"), text, remedy
    if isinstance(current.profile, float) and math.isinf(depth):
        text = "a power law needs a depth: its speed is 0 at the bed"
        yield ("current", "profile"), text, "give water.depth, or a table [[z, speed], …]"
    if isinstance(current.profile, tuple) and (below := current.profile[0][0]) < -depth:
        text = f"the table begins {-depth - below:g} m below the sea bed"
        yield ("current", "profile"), text, "z = 0 is the still-water level"
