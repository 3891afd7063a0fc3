"""Shapes of bodies: built-in ones and mesh files."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, TypeVar

from pydantic import Field, model_validator

from m4e_adapters.hydrodynamics.config.numbers import (
    Coordinate,
    Finite,
    NotNegative,
    Place,
    Positive,
)
from m4e_fmi.files.document import Section, rejected

SHAPES = ("cylinder", "horizontal_cylinder", "sphere", "box", "revolved", "mesh")
REVOLVED = ("cylinder", "sphere", "revolved")
"""Those that are turned about an upright axis."""
KEYS_OF_SHAPES = (
    "write one of cylinder: {radius, draft}, horizontal_cylinder: {radius, length}, "
    "sphere: {radius}, box: {length, width, draft}, revolved: {profile}, mesh: FILE"
)

SMALLEST = 1e-4
"""Least length [m] of built-in shapes: panels of any smaller ones are none, or very many."""
Length = Annotated[Finite, Field(ge=SMALLEST)]
Top = Annotated[Coordinate, Field(le=0)]
"""Height z [m] of a flat top; 0: the body pierces the water."""


Upright = TypeVar("Upright", "Cylinder", "Box")
Round = TypeVar("Round", "HorizontalCylinder", "Sphere")


def _below_its_top(shape: Upright) -> Upright:
    name, top_z, draft = type(shape).__name__.lower(), shape.top_z, shape.draft
    if top_z < 0 and shape.freeboard is not None:
        raise rejected(
            f"the {name} has a 'freeboard' and its top at z = {top_z:g} m, below the water",
            "remove one of them",
        )
    if top_z <= -draft:
        raise rejected(
            f"the {name} has its top at z = {top_z:g} m, its bottom at z = {-draft:g} m",
            "top_z is a height, below 0 for a submerged body; it must be above -draft",
        )
    return shape


def _in_water(shape: Round) -> Round:
    name, center_z, radius = type(shape).__name__, shape.center_z, shape.radius
    if center_z >= radius:
        raise rejected(
            f"the {name.removeprefix('Horizontal').lower()} (center_z {center_z:g} m, radius "
            f"{radius:g} m) does not touch the water",
            "center_z is the height above the still-water level; it must be below the radius",
        )
    return shape


class Cylinder(Section):
    """Vertical circular cylinder of `radius` [m], flat bottom at z = −`draft` [m], axis at
    (`center_x`, `center_y`) [m]; submerged with a flat top at z = `top_z` [m].

    `freeboard` [m] is the height of its deck above the still water: the pressure on whole
    hulls needs it.
    """

    radius: Length
    draft: Length
    freeboard: Positive | None = None
    top_z: Top = 0.0
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0

    _has_a_height = model_validator(mode="after")(_below_its_top)


class HorizontalCylinder(Section):
    """Circular cylinder of `radius` and `length` [m] along `axis` x or y, flat ends, its middle at
    (`center_x`, `center_y`, `center_z`) [m]; half immersed by default.
    """

    radius: Length
    length: Length
    axis: Literal["x", "y"] = "x"
    center_z: Coordinate = 0.0
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0

    _touches_the_water = model_validator(mode="after")(_in_water)


class Sphere(Section):
    """Sphere of `radius` [m] about (`center_x`, `center_y`, `center_z`) [m]; half immersed by
    default.
    """

    radius: Length
    center_z: Coordinate = 0.0
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0

    _touches_the_water = model_validator(mode="after")(_in_water)


class Box(Section):
    """Rectangular box: `length` [m] along X, `width` [m] along Y, flat bottom at z = −`draft` [m],
    middle at (`center_x`, `center_y`) [m]; submerged with a flat top at z = `top_z` [m].

    `freeboard` [m] is the height of its deck above the still water: the pressure on whole
    hulls needs it.
    """

    length: Length
    width: Length
    draft: Length
    freeboard: Positive | None = None
    top_z: Top = 0.0
    center_x: Coordinate = 0.0
    center_y: Coordinate = 0.0

    _has_a_height = model_validator(mode="after")(_below_its_top)


class Revolved(Section):
    """Body of revolution: a `profile` [[radius, z], …] [m] turned about the upright axis at
    (`center_x`, `center_y`) [m].

    The profile goes upwards in straight lines; between two points of the same z it makes a step.
    Its ends are closed by flat discs if their radius is not 0. What is above the water is cut off.
    A `hole` of that radius [m] goes through it along the axis.
    """

    profile: tuple[tuple[NotNegative, Coordinate], ...]
    hole: Positive | None = None
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
        if heights[0] > -SMALLEST:
            text = f"the profile is not in the water (lowest point at z = {heights[0]:g} m)"
            raise rejected(text, f"z = 0 is the still-water level; {order}")
        if heights[0] == heights[-1]:
            raise rejected("the profile has no height", order)
        if 0.0 in radii[1:-1]:
            raise rejected(
                "the profile has a radius of 0 between its ends",
                "leave the point out if it closes a flat end, which is closed anyway; two parts "
                "that do not touch are two bodies",
            )
        if max(radii) < SMALLEST:
            raise rejected(f"the profile has no radius of {SMALLEST} m or more", order)
        if self.hole is not None and (radii[0] < self.hole or min(radii[1:]) <= self.hole):
            text = f"the profile has a radius of {min(radii):g} m, in the hole of {self.hole:g} m"
            raise rejected(text, "write the outer surface only; flat ends are closed to the hole")
        return self


class Part(Section):
    """Exactly one of the built-in shapes, or the name of a mesh file.

    A mesh file is in the reference pose, z = 0 the still-water level, normals into the water; what
    is above the water is cut off. Its name is relative to the system file's folder. Its numbers
    times `scale` [1] are lengths in m: 0.001 for a mesh in mm. `mesh_origin` [x, z] [m], in space
    [x, y, z], is where the origin of the file lies. With `frame: world` (default) that is a place
    in the reference pose; with `frame: body` it is counted from the centre of gravity, for a mesh
    drawn in the body's frame. Default: 0.
    """

    cylinder: Cylinder | None = None
    horizontal_cylinder: HorizontalCylinder | None = None
    sphere: Sphere | None = None
    box: Box | None = None
    revolved: Revolved | None = None
    mesh: str | None = None
    mesh_origin: Place | None = None
    scale: Positive = 1.0
    frame: Literal["world", "body"] = "world"

    @property
    def kind(self) -> str:
        """The key that says which shape it is; "" of `NO_SHAPE`."""
        return next((name for name in self.kinds() if getattr(self, name) is not None), "")

    @property
    def axis(self) -> tuple[float, float] | None:
        """(x, y) [m] of the upright axis of a body of revolution, None of others."""
        turned = getattr(self, self.kind) if self.kind in REVOLVED else None
        return None if turned is None else (turned.center_x, turned.center_y)

    @classmethod
    def kinds(cls) -> tuple[str, ...]:
        """The keys of which there is one."""
        return tuple(name for name in (*SHAPES, "union") if name in cls.model_fields)

    @model_validator(mode="after")
    def _exactly_one(self) -> Part:
        given = [name for name in self.kinds() if getattr(self, name) is not None]
        if len(given) != 1:
            more = ", or union: [{...}, {...}]" if "union" in self.kinds() else ""
            what = "body" if more else "part of a union"
            told = " and ".join(given) or "none"
            raise rejected(f"a {what} has one shape, got {told}", KEYS_OF_SHAPES + more)
        for key in ("mesh_origin", "scale", "frame"):
            if key in self.model_fields_set and self.mesh is None:
                raise rejected(f"'{key}' is for mesh files", f"remove it from the {given[0]}")
        return self


class Shape(Part):
    """Exactly one of the built-in shapes, the name of a mesh file, or a `union` of such parts.

    A mesh file is in the reference pose, z = 0 the still-water level, normals into the water; what
    is above the water is cut off. Its name is relative to the system file's folder. Its numbers
    times `scale` [1] are lengths in m: 0.001 for a mesh in mm. `mesh_origin` [x, z] [m], in space
    [x, y, z], is where the origin of the file lies. With `frame: world` (default) that is a place
    in the reference pose; with `frame: body` it is counted from the centre of gravity, for a mesh
    drawn in the body's frame. Default: 0.

    Parts of a union overlap, touch or stand apart; its surface is that around all of them.
    """

    union: tuple[Part, ...] | None = None

    @model_validator(mode="after")
    def _of_several(self) -> Shape:
        if self.union is not None and len(self.union) < 2:
            raise rejected(
                f"the union has {len(self.union)} of at least two parts",
                "write union: [{...}, {...}], or the shape itself",
            )
        return self

    @property
    def parts(self) -> tuple[Part, ...]:
        """Those of a union; else the shape itself."""
        return self.union or (self,)

    @property
    def axis(self) -> tuple[float, float] | None:
        """(x, y) [m] of the upright axis of a body of revolution, None of others."""
        if self.union is None:
            return super().axis
        axes = {part.axis for part in self.union}
        return axes.pop() if len(axes) == 1 else None


NO_SHAPE = Shape.model_construct()
"""Of a body whose coefficients are those of a file."""
