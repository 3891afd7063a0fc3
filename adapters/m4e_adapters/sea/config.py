"""Keys of a `kind: sea` component of a system file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic_core import InitErrorDetails, ValidationError

from m4e_adapters.hydrodynamics.config import Current, Still, Water, Waves
from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.sections import NAME
from m4e_adapters.hydrodynamics.config.waves import flow_problems
from m4e_fmi.files.document import Section, rejected_at

Points = dict[Annotated[str, Field(pattern=NAME)], Place]
TAKEN = {"wave": "waves", "current": "current"}


class SeaConfig(Section):
    """Waves and a current without bodies: what the water does at points.

    `points` [x, z] [m] stay; `moving_points` have their place as an input, which begins at the
    given one. With `dimensions: 3` places are [x, y, z] and waves travel in any direction.
    `stretching` chooses how velocities are continued up to the surface: `wheeler` or `linear`.
    """

    dimensions: Literal[2, 3] = 2
    water: Water = Water()
    waves: Waves = Still(spectrum="still")
    current: Current | None = None
    points: Points = Field(default_factory=dict)
    moving_points: Points = Field(default_factory=dict)
    stretching: Literal["wheeler", "linear"] = "wheeler"

    @model_validator(mode="after")
    def _of_its_dimensions(self) -> SeaConfig:
        wrong = [*self._places()]
        wrong += flow_problems(
            self.waves, self.current, depth=self.water.depth, dimensions=self.dimensions
        )
        if wrong:
            raise ValidationError.from_exception_data("sea", wrong)
        return self

    def _places(self) -> Iterator[InitErrorDetails]:
        axes = "[x, z]" if self.dimensions == 2 else "[x, y, z]"
        for key, points in (("points", self.points), ("moving_points", self.moving_points)):
            for name, place in points.items():
                if name in TAKEN:
                    text = f"{name!r} is the name of the {TAKEN[name]}"
                    yield rejected_at((key, name), text, "give the point another name")
                if key == "moving_points" and name in self.points:
                    text = f"{name!r} stays and moves"
                    yield rejected_at((key, name), text, "give one of the two points another name")
                if len(place) != self.dimensions:
                    text = f"{name!r} has {len(place)} coordinates, expected {axes}"
                    yield rejected_at((key, name), text, f"write {axes}, or change 'dimensions'")
                elif place[-1] < -self.water.depth:
                    text = f"{name!r} is {-self.water.depth - place[-1]:g} m below the sea bed"
                    remedy = "z = 0 is the still-water level, the bed is water.depth below it"
                    yield rejected_at((key, name), text, remedy)
