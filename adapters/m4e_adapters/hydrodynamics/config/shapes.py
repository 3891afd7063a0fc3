"""Shapes of bodies: built-in ones and mesh files."""

from __future__ import annotations

from itertools import pairwise

from pydantic import model_validator

from m4e_adapters.hydrodynamics.config.numbers import Coordinate, NotNegative, Place, Positive
from m4e_fmi.files.document import Section, rejected

SHAPES = ("cylinder", "sphere", "box", "revolved", "mesh")


class Cylinder(Section):
    """Vertical circular cylinder of `radius` [m], flat bottom at z = −`draft` [m], axis at
    (`center_x`, `center_y`) [m].
    """

    radius: Positive
    draft: Positive
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0


class Sphere(Section):
    """Sphere of `radius` [m] about (`center_x`, `center_y`, `center_z`) [m]; half immersed by
    default.
    """

    radius: Positive
    center_z: Coordinate = 0.0
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0

    @model_validator(mode="after")
    def _in_water(self) -> Sphere:
        if self.center_z >= self.radius:
            raise rejected(
                f"the sphere (center_z {self.center_z:g} m, radius {self.radius:g} m) does not "
                "touch the water",
                "center_z is the height above the still-water level; it must be below the radius",
            )
        return self


class Box(Section):
    """Rectangular box: `length` [m] along X, `width` [m] along Y, flat bottom at z = −`draft` [m],
    middle at (`center_x`, `center_y`) [m].
    """

    length: Positive
    width: Positive
    draft: Positive
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0


class Revolved(Section):
    """Body of revolution: a `profile` [[radius, z], …] [m] turned about the upright axis at
    (`center_x`, `center_y`) [m].

    The profile goes upwards in straight lines; between two points of the same z it makes a step.
    Its ends are closed by flat discs if their radius is not 0. What is above the water is cut off.
    """

    profile: tuple[tuple[NotNegative, Coordinate], ...]
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0

    @model_validator(mode="after")
    def _upwards(self) -> Revolved:
        order = "write [[radius, z], ...] from the lowest point to the highest"
        if len(self.profile) < 2:
            raise rejected(f"the profile has {len(self.profile)} of at least two points", order)
        radii, heights = zip(*self.profile, strict=True)
        if any(above < below for below, above in pairwise(heights)):
            raise rejected("the profile goes down", order)
        if len(set(self.profile)) < len(self.profile):
            raise rejected("the profile has a point twice", "remove one of them")
        if heights[0] >= 0:
            text = f"the profile is above the water (lowest point at z = {heights[0]:g} m)"
            raise rejected(text, f"z = 0 is the still-water level; {order}")
        if heights[0] == heights[-1]:
            raise rejected("the profile has no height", order)
        if 0.0 in radii[1:-1]:
            raise rejected(
                "the profile has a radius of 0 between its ends",
                "leave the point out if it closes a flat end, which is closed anyway; two parts "
                "that do not touch are two bodies",
            )
        if max(radii) == 0:
            raise rejected("the profile has no radius above 0", order)
        return self


class Shape(Section):
    """Exactly one of the built-in shapes, or the name of a mesh file.

    A mesh file is in m, in the reference pose, z = 0 the still-water level, normals into the
    water; what is above the water is cut off. The name is relative to the system file's folder.
    `mesh_origin` [x, z] is where the origin of the file lies in the reference pose: that of the
    body's frame for a mesh drawn in it. Default [0, 0]: world coordinates. In space [x, y, z].
    """

    cylinder: Cylinder | None = None
    sphere: Sphere | None = None
    box: Box | None = None
    revolved: Revolved | None = None
    mesh: str | None = None
    mesh_origin: Place | None = None

    @property
    def kind(self) -> str:
        """The key that says which shape it is; "" of `NO_SHAPE`."""
        return next((name for name in SHAPES if getattr(self, name) is not None), "")

    @property
    def axis(self) -> tuple[float, float] | None:
        """(x, y) [m] of the upright axis of a body of revolution, None of others."""
        turned = self.cylinder or self.sphere or self.revolved
        return None if turned is None else (turned.center_x, turned.center_y)

    @model_validator(mode="after")
    def _exactly_one(self) -> Shape:
        given = [name for name in SHAPES if getattr(self, name) is not None]
        if len(given) != 1:
            raise rejected(
                f"a body has one shape, got {' and '.join(given) or 'none'}",
                "write one of cylinder: {radius, draft}, sphere: {radius}, "
                "box: {length, width, draft}, revolved: {profile}, mesh: FILE",
            )
        if self.mesh_origin is not None and self.mesh is None:
            raise rejected("'mesh_origin' is for mesh files", "give the shape a center_x")
        return self


NO_SHAPE = Shape.model_construct()
"""Of a body whose coefficients are those of a file."""
