"""Keys of a `kind: hydrodynamics` component of a system file.

Lengths in m, angles in degrees where said, everything else SI. The reference pose of a body is the
one it floats in at rest: world frame, z = 0 the still-water level.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, model_validator

from m4e_fmi.files.document import Section, rejected

NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
SHAPES = ("cylinder", "sphere", "box", "mesh")
PEAK_ENHANCEMENT = (1.0, 10.0)
DEEP = "deep"
AUTO = "auto"


def _depth(value: object) -> object:
    return math.inf if value == DEEP else value


def _order(value: object) -> object:
    return None if value == AUTO else value


def _planar_direction(value: float) -> float:
    if value not in (0.0, 180.0):
        raise rejected(
            f"wave direction {value:g} deg leaves the X-Z plane",
            "write 0 (waves travel towards +X) or 180 (towards -X)",
        )
    return value


Finite = Annotated[float, Field(allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
"""A place [m]; the squares of such numbers are finite."""
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Depth = Annotated[Annotated[float, Field(gt=0)], BeforeValidator(_depth)]
Order = Annotated[Annotated[int, Field(ge=1, le=16)] | None, BeforeValidator(_order)]
Direction = Annotated[float, AfterValidator(_planar_direction)]


class Water(Section):
    """`density` [kg/m3], `depth` [m] or `deep` (default), `gravity` [m/s2]."""

    density: Positive = 1025.0
    depth: Depth = math.inf
    gravity: Positive = 9.81


class Cylinder(Section):
    """Vertical circular cylinder of `radius` [m], flat bottom at z = −`draft` [m], axis at
    x = `center_x` [m].
    """

    radius: Positive
    draft: Positive
    center_x: Coordinate = 0.0


class Sphere(Section):
    """Sphere of `radius` [m] about (`center_x`, `center_z`) [m]; half immersed by default."""

    radius: Positive
    center_z: Coordinate = 0.0
    center_x: Coordinate = 0.0

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
    middle at x = `center_x` [m].
    """

    length: Positive
    width: Positive
    draft: Positive
    center_x: Coordinate = 0.0


class Shape(Section):
    """Exactly one of the built-in shapes, or the name of a mesh file.

    A mesh file is in m, in the reference pose, z = 0 the still-water level, normals into the
    water; what is above the water is cut off. The name is relative to the system file's folder.
    `mesh_origin` [x, z] is where the origin of the file lies in the reference pose: that of the
    body's frame for a mesh drawn in it. Default [0, 0]: world coordinates.
    """

    cylinder: Cylinder | None = None
    sphere: Sphere | None = None
    box: Box | None = None
    mesh: str | None = None
    mesh_origin: tuple[Coordinate, Coordinate] | None = None

    @property
    def kind(self) -> str:
        """The key that says which shape it is."""
        return next(name for name in SHAPES if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _exactly_one(self) -> Shape:
        given = [name for name in SHAPES if getattr(self, name) is not None]
        if len(given) != 1:
            raise rejected(
                f"a body has one shape, got {' and '.join(given) or 'none'}",
                "write one of cylinder: {radius, draft}, sphere: {radius}, "
                "box: {length, width, draft}, mesh: FILE",
            )
        if self.mesh_origin is not None and self.mesh is None:
            raise rejected("'mesh_origin' is for mesh files", "give the shape a center_x")
        return self


class Drag(Section):
    """Quadratic drag F = −c |v| v at the centre of gravity, in still water.

    `surge` and `heave` in N/(m/s)2, `pitch` in N.m/(rad/s)2. Default 0: none.
    """

    surge: NotNegative = 0.0
    heave: NotNegative = 0.0
    pitch: NotNegative = 0.0


class Body(Section):
    """A floating rigid body: `shape`, `center_of_gravity` [x, z] [m] in the reference pose.

    `panels` is about how many panels the wetted surface of a built-in shape gets; `drag` is
    quadratic.
    """

    shape: Shape
    center_of_gravity: tuple[Coordinate, Coordinate]
    panels: Annotated[int, Field(ge=48, le=20000)] = 600
    drag: Drag = Drag()

    @model_validator(mode="after")
    def _panels_of_a_file(self) -> Body:
        if self.shape.mesh is not None and "panels" in self.model_fields_set:
            raise rejected(
                "'panels' has no effect on a mesh file", "remove it, or refine the mesh itself"
            )
        return self


class Frequencies(Section):
    """Angular frequencies at which the potential flow is solved: `count`, equally spaced, from
    `minimum` to `maximum` [rad/s].

    Defaults: `count` 40; `maximum` sqrt(4.5 g / a), above which radiation is negligible: a is the
    radius of the half-ball of the smallest displacement or of its waterplane, for a submerged body
    plus the depth of its highest point; `minimum` = maximum / count, more in shallow water. Where
    the waves need more (regular: their frequency; irregular: 2.5 peak frequencies), frequencies at
    twice the spacing follow. Above the last one excitation falls as 1/omega^3.
    """

    minimum: Positive | None = None
    maximum: Positive | None = None
    count: Annotated[int, Field(ge=12, le=400)] = 40

    @model_validator(mode="after")
    def _increasing(self) -> Frequencies:
        if self.minimum and self.maximum and self.minimum >= self.maximum:
            raise rejected(
                f"minimum {self.minimum:g} is not below maximum {self.maximum:g} rad/s",
                "exchange them",
            )
        return self


class Radiation(Section):
    """Number of poles of the radiation memory of each group of coupled motions.

    `order: auto` (default) takes the smallest of 4 to 16 that reaches the accuracy.
    """

    order: Order = None


class _Waves(Section):
    """Direction and ramp, which all waves have."""

    direction: Direction = 0.0
    ramp_time: NotNegative | None = None


class _Irregular(_Waves):
    significant_height: Positive
    peak_period: Positive
    seed: Annotated[int, Field(ge=0)] = 0
    components: Annotated[int, Field(ge=10, le=1000)] = 300


class Jonswap(_Irregular):
    """JONSWAP sea: `significant_height` [m], `peak_period` [s], `peak_enhancement` γ [1].

    `seed` chooses frequencies and phases, of which `components` there are so many. `direction`
    [deg] is 0 (waves travel towards +X) or 180. The sea grows smoothly from nothing within
    `ramp_time` [s], default two peak periods.
    """

    spectrum: Literal["jonswap"]
    peak_enhancement: Annotated[float, Field(ge=PEAK_ENHANCEMENT[0], le=PEAK_ENHANCEMENT[1])] = 3.3


class PiersonMoskowitz(_Irregular):
    """Pierson-Moskowitz (Bretschneider) sea: `significant_height` [m], `peak_period` [s].

    `seed`, `components`, `direction` [deg] and `ramp_time` [s] as of JONSWAP.
    """

    spectrum: Literal["pierson_moskowitz"]


class Regular(_Waves):
    """One wave: elevation at x = 0 is `height`/2·cos(2π t/`period` + `phase`), in m, s, rad.

    `direction` [deg] is 0 or 180; `ramp_time` [s] is two periods by default.
    """

    spectrum: Literal["regular"]
    height: Positive
    period: Positive
    phase: Finite = 0.0


class Still(Section):
    """No waves."""

    spectrum: Literal["still"] = "still"


Waves = Annotated[Jonswap | PiersonMoskowitz | Regular | Still, Discriminator("spectrum")]


class HydrodynamicsConfig(Section):
    """Floating bodies in water: linear potential flow, quadratic drag, waves in one direction."""

    water: Water = Water()
    bodies: Annotated[dict[Annotated[str, Field(pattern=NAME)], Body], Field(min_length=1)]
    frequencies: Frequencies = Frequencies()
    radiation: Radiation = Radiation()
    waves: Waves = Still()
