"""Keys of a `kind: hull_pressure` component of a system file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic_core import ValidationError

from m4e_adapters.hydrodynamics.config.component import misplaced, out_of_plane
from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.sections import NAME, Water
from m4e_adapters.hydrodynamics.config.shapes import Shape
from m4e_adapters.hydrodynamics.config.waves import Still, Waves, flow_problems
from m4e_fmi.files.document import Section, rejected

DRAWN = ("box", "cylinder", "sphere", "revolved", "mesh")
"""Shapes that have a part above the water."""


class HullBody(Section):
    """A rigid body: `shape`, `center_of_gravity` [x, z] [m] in the reference pose, [x, y, z] in
    space.

    The shape includes the part above the water: a mesh file is closed, up to the deck, and the
    profile of a body of revolution goes up to its top; a box or a cylinder has a `freeboard`. Parts
    of a union may be submerged.
    `panels` is about how many panels the whole surface of a built-in shape gets.
    """

    shape: Shape
    center_of_gravity: Place
    panels: Annotated[int, Field(ge=48, le=20000)] = 1000

    @model_validator(mode="after")
    def _of_its_shape(self) -> HullBody:
        kind = self.shape.kind
        if kind not in (*DRAWN, "union"):
            raise rejected(
                f"a {kind.replace('_', ' ')} is not drawn above the water",
                f"give a mesh of the whole hull, or one of {', '.join(DRAWN[:-1])}",
            )
        if getattr(getattr(self.shape, kind), "top_z", 0.0):
            raise rejected(
                "'top_z' is of a submerged shape, which is not drawn here",
                "give a mesh of the whole body, closed",
            )
        for part in self.shape.parts:
            end = part.cylinder or part.box
            if end is not None and end.freeboard is None and end.top_z == 0.0:
                raise rejected(
                    f"a {part.kind} needs a 'freeboard': its pressure is taken over the whole hull",
                    "give the height [m] of its top above the still water: freeboard: 2.5",
                )
        if self.shape.mesh is not None and "panels" in self.model_fields_set:
            raise rejected(
                "'panels' has no effect on a mesh file", "remove it, or refine the mesh itself"
            )
        return self


class HullPressureConfig(Section):
    """Hydrostatic and incident wave pressure on hulls at their true pose, up to the instantaneous
    surface.

    `dimensions: 2` (default) is the X-Z plane, `dimensions: 3` has all six motions and waves in any
    direction. The waves are those of `kind: hydrodynamics`: the same keys make the same sea.
    """

    dimensions: Literal[2, 3] = 2
    water: Water = Water()
    bodies: Annotated[dict[Annotated[str, Field(pattern=NAME)], HullBody], Field(min_length=1)]
    waves: Waves = Still(spectrum="still")

    @model_validator(mode="after")
    def _of_its_dimensions(self) -> HullPressureConfig:
        wrong = [*misplaced(self.bodies, self.dimensions)]
        wrong += flow_problems(self.waves, None, depth=self.water.depth, dimensions=self.dimensions)
        if self.dimensions == 2:
            wrong += out_of_plane(self.bodies)
        if wrong:
            raise ValidationError.from_exception_data("hull_pressure", wrong)
        return self
