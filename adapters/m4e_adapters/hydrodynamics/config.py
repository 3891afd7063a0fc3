"""Keys of a `kind: hydrodynamics` component of a system file.

Lengths in m, angles in degrees where said, everything else SI. The reference pose of a body is the
one it floats in at rest: world frame, z = 0 the still-water level.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import BeforeValidator, Discriminator, Field, model_validator
from pydantic_core import InitErrorDetails, ValidationError

from m4e_fmi.files.document import Section, rejected

NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
SHAPES = ("cylinder", "sphere", "box", "revolved", "mesh")
PEAK_ENHANCEMENT = (1.0, 10.0)
DEEP = "deep"
AUTO = "auto"


def _depth(value: object) -> object:
    return math.inf if value == DEEP else value


def _order(value: object) -> object:
    return None if value == AUTO else value


Finite = Annotated[float, Field(allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
"""A place [m]; the squares of such numbers are finite."""
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Depth = Annotated[Annotated[float, Field(gt=0)], BeforeValidator(_depth)]
Order = Annotated[Annotated[int, Field(ge=1, le=16)] | None, BeforeValidator(_order)]
Place = tuple[Coordinate, ...]
"""[x, z], or [x, y, z] where `dimensions` is 3."""


class Water(Section):
    """`density` [kg/m3], `depth` [m] or `deep` (default), `gravity` [m/s2]."""

    density: Positive = 1025.0
    depth: Depth = math.inf
    gravity: Positive = 9.81


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
        """The key that says which shape it is."""
        return next(name for name in SHAPES if getattr(self, name) is not None)

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


class Drag(Section):
    """Quadratic drag F = −c |v| v at the centre of gravity, in still water.

    `surge`, `sway`, `heave` in N/(m/s)2, `roll`, `pitch`, `yaw` in N.m/(rad/s)2. Default 0: none.
    Sway, roll and yaw are motions of space.
    """

    surge: NotNegative = 0.0
    sway: NotNegative = 0.0
    heave: NotNegative = 0.0
    roll: NotNegative = 0.0
    pitch: NotNegative = 0.0
    yaw: NotNegative = 0.0


class Body(Section):
    """A floating rigid body: `shape`, `center_of_gravity` [x, z] [m] in the reference pose,
    [x, y, z] in space.

    `panels` is about how many panels the wetted surface of a built-in shape gets; `drag` is
    quadratic.
    """

    shape: Shape
    center_of_gravity: Place
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

    direction: Finite = 0.0
    ramp_time: NotNegative | None = None


class _Irregular(_Waves):
    significant_height: Positive
    peak_period: Positive
    seed: Annotated[int, Field(ge=0)] = 0
    components: Annotated[int, Field(ge=10, le=1000)] = 300


class Jonswap(_Irregular):
    """JONSWAP sea: `significant_height` [m], `peak_period` [s], `peak_enhancement` γ [1].

    `seed` chooses frequencies and phases, of which `components` there are so many. `direction`
    [deg] is 0 (waves travel towards +X) or 180, in space any angle from +X towards +Y. The sea
    grows smoothly from nothing within `ramp_time` [s], default two peak periods.
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

    `direction` [deg] is 0 or 180, in space any; `ramp_time` [s] is two periods by default.
    """

    spectrum: Literal["regular"]
    height: Positive
    period: Positive
    phase: Finite = 0.0


class Still(Section):
    """No waves."""

    spectrum: Literal["still"]


Waves = Annotated[Jonswap | PiersonMoskowitz | Regular | Still, Discriminator("spectrum")]


class HydrodynamicsConfig(Section):
    """Floating bodies in water: linear potential flow, quadratic drag, waves in one direction.

    `dimensions: 2` (default) is the X-Z plane with surge, heave and pitch; `dimensions: 3` has all
    six motions and waves in any direction. There `heading` [deg] is the angle from +X, towards +Y,
    of the axis of the hulls that is drawn along +X: they are turned as one about the vertical
    through the middle of their centres of gravity. With a `heading_filter` [s] the heading follows
    the yaw of the body (one only) with this time constant.
    """

    dimensions: Literal[2, 3] = 2
    water: Water = Water()
    heading: Finite = 0.0
    heading_filter: Positive | None = None
    bodies: Annotated[dict[Annotated[str, Field(pattern=NAME)], Body], Field(min_length=1)]
    frequencies: Frequencies = Frequencies()
    radiation: Radiation = Radiation()
    waves: Waves = Still(spectrum="still")

    @model_validator(mode="after")
    def _of_its_dimensions(self) -> HydrodynamicsConfig:
        wrong = [*_places(self)]
        if self.dimensions == 2:
            wrong += _beyond_the_plane(self)
        elif self.heading_filter is not None and len(self.bodies) > 1:
            text = f"the heading cannot follow the yaw of {len(self.bodies)} bodies"
            remedy = "remove heading_filter, or give each body a hydrodynamics component of its own"
            wrong.append(_wrong(("heading_filter",), text, remedy))
        if wrong:
            raise ValidationError.from_exception_data("hydrodynamics", wrong)
        return self


def _wrong(place: tuple[str, ...], message: str, remedy: str) -> InitErrorDetails:
    return InitErrorDetails(type=rejected(message, remedy), loc=place, input=None)


def _places(config: HydrodynamicsConfig) -> Iterator[InitErrorDetails]:
    """Places that do not have as many coordinates as the component has dimensions."""
    axes = "[x, z]" if config.dimensions == 2 else "[x, y, z]"
    for name, body in config.bodies.items():
        given = {
            ("center_of_gravity",): body.center_of_gravity,
            ("shape", "mesh_origin"): body.shape.mesh_origin,
        }
        for keys, place in given.items():
            if place is None or len(place) == config.dimensions:
                continue
            text = f"'{keys[-1]}' has {len(place)} coordinates, expected {axes}"
            remedy = f"write {axes}; numbers have a decimal point"
            if config.dimensions == 2:
                remedy += ", and places in space need 'dimensions: 3'"
            yield _wrong(("bodies", name, *keys), text, remedy)


def _beyond_the_plane(config: HydrodynamicsConfig) -> Iterator[InitErrorDetails]:
    """Keys and values of space in a component of the X-Z plane."""
    remedy = "remove it, or write 'dimensions: 3' on top of the component"
    waves = config.waves
    if not isinstance(waves, Still) and waves.direction not in (0.0, 180.0):
        yield _wrong(
            ("waves", waves.spectrum, "direction"),
            f"wave direction {waves.direction:g} deg leaves the X-Z plane",
            "write 0 (waves travel towards +X), 180 (towards -X), or 'dimensions: 3' on top",
        )
    for key in {"heading", "heading_filter"} & config.model_fields_set:
        yield _wrong((key,), f"'{key}' is of space", remedy)
    for name, body in config.bodies.items():
        kind = body.shape.kind
        if getattr(getattr(body.shape, kind), "center_y", 0.0):
            place = ("bodies", name, "shape", kind, "center_y")
            yield _wrong(place, "'center_y' leaves the X-Z plane", remedy)
        for motion in ("sway", "roll", "yaw"):
            if motion in body.drag.model_fields_set:
                yield _wrong(("bodies", name, "drag", motion), f"'{motion}' is of space", remedy)
