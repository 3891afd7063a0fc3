"""Keys of a `kind: morison` component of a system file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic_core import InitErrorDetails, ValidationError

from m4e_adapters.hydrodynamics.config import Current, Still, Water, Waves
from m4e_adapters.hydrodynamics.config.numbers import NotNegative, Place, Positive
from m4e_adapters.hydrodynamics.config.sections import NAME
from m4e_adapters.hydrodynamics.config.waves import flow_problems
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_fmi.files.document import Section, rejected_at

FIXED = "fixed"
TAKEN = ("wave", "current", FIXED)
Name = Annotated[str, Field(pattern=NAME)]


class MemberBody(Section):
    """A rigid body that carries members: `center_of_gravity` [x, z] [m] in the reference pose,
    [x, y, z] in space.
    """

    center_of_gravity: Place


class Member(Section):
    """A straight circular cylinder between two `ends` [x, z] [m] in the reference pose, [x, y, z]
    in space; without a `body` it is fixed.

    `diameter` [m] is that of the outer surface. Coefficients [1]: `drag` C_D of the flow across the
    member; `tangential_drag` C_T of that along it, on the circumference; `added_mass` C_A;
    `inertia` C_M, 1 + C_A if it is left out. A member that only has drag, beside potential flow,
    has `added_mass: 0, inertia: 0`. `segments` are the parts over which forces are integrated, each
    up to the surface with three points.

    `buoyancy`: closed ends, on which the pressure of the water acts; members of a body have it if
    they have inertia, others not. `flooded`: open to the water inside, without buoyancy.
    `end_drag` and `end_added_mass` [1] are those of each end, as of a heave plate: the drag along
    the axis over ρ/2 π D²/4, and the added mass along the axis over ρ π D³/12, which is 0.637 on
    each side of a thin disc.
    """

    ends: tuple[Place, Place]
    diameter: Positive
    drag: NotNegative
    tangential_drag: NotNegative = 0.0
    added_mass: NotNegative = 1.0
    inertia: NotNegative | None = None
    body: str | None = None
    buoyancy: bool | None = None
    flooded: bool = False
    end_drag: NotNegative = 0.0
    end_added_mass: NotNegative = 0.0
    segments: Annotated[int, Field(ge=1, le=200)] = 10

    @property
    def inertia_coefficient(self) -> float:
        """C_M [1]."""
        return 1.0 + self.added_mass if self.inertia is None else self.inertia

    @property
    def is_buoyant(self) -> bool:
        """True if the pressure of the water acts on its ends, too."""
        if self.buoyancy is None:
            return self.body is not None and self.inertia_coefficient > 0.0 and not self.flooded
        return self.buoyancy

    @property
    def length(self) -> float:
        """Between the ends [m]."""
        return math.dist(*map(point_in_space, self.ends))


class MorisonConfig(Section):
    """Slender members in waves and a current: drag and inertia by Morison's equation.

    `dimensions: 2` (default) is the X-Z plane; `dimensions: 3` has waves in any direction and all
    motions of `bodies`. `stretching` chooses how velocities are continued up to the surface:
    `wheeler` or `linear`. `reference_point` [x, z] [m], in space [x, y, z], is where the moments on
    members that are fixed are about (default: the origin).
    """

    dimensions: Literal[2, 3] = 2
    water: Water = Water()
    waves: Waves = Still(spectrum="still")
    current: Current | None = None
    stretching: Literal["wheeler", "linear"] = "wheeler"
    bodies: dict[Name, MemberBody] = Field(default_factory=dict)
    members: Annotated[dict[Name, Member], Field(min_length=1)]
    reference_point: Place | None = None

    @model_validator(mode="after")
    def _consistent(self) -> MorisonConfig:
        wrong = [*self._names(), *self._places()]
        wrong += flow_problems(
            self.waves, self.current, depth=self.water.depth, dimensions=self.dimensions
        )
        if wrong:
            raise ValidationError.from_exception_data("morison", wrong)
        return self

    def of_body(self, body: str | None) -> dict[str, Member]:
        """The members of a body, or the fixed ones."""
        return {name: member for name, member in self.members.items() if member.body == body}

    def _names(self) -> Iterator[InitErrorDetails]:
        for key, names in (("bodies", self.bodies), ("members", self.members)):
            for name in names:
                if name in TAKEN or (key == "members" and name in self.bodies):
                    text = f"{name!r} is the name of something else here"
                    yield rejected_at((key, name), text, "give it another name")
        for name, member in self.members.items():
            if member.body is not None and member.body not in self.bodies:
                text = f"there is no body {member.body!r}"
                known = ", ".join(self.bodies) or "none"
                remedy = f"add it under 'bodies' (there: {known}), or leave out 'body': fixed"
                yield rejected_at(("members", name, "body"), text, remedy)
            if member.flooded and member.buoyancy:
                text = "a flooded member has no buoyancy"
                yield rejected_at(("members", name, "buoyancy"), text, "remove one of the two")
        for body in self.bodies:
            if not self.of_body(body):
                text = f"{body!r} has no members"
                yield rejected_at(("bodies", body), text, "remove it, or name it at its members")
        if self.reference_point is not None and not self.of_body(None):
            text = "'reference_point' has no effect: no member is fixed"
            yield rejected_at(("reference_point",), text, "remove it")

    def _places(self) -> Iterator[InitErrorDetails]:
        axes = "[x, z]" if self.dimensions == 2 else "[x, y, z]"
        given: dict[tuple[str | int, ...], Place] = {
            ("bodies", name, "center_of_gravity"): body.center_of_gravity
            for name, body in self.bodies.items()
        }
        for name, member in self.members.items():
            given |= {("members", name, "ends", k): end for k, end in enumerate(member.ends)}
        if self.reference_point is not None:
            given["reference_point",] = self.reference_point
        wrong = {keys for keys, place in given.items() if len(place) != self.dimensions}
        for keys in wrong:
            text = f"{len(given[keys])} coordinates, expected {axes}"
            yield rejected_at(keys, text, f"write {axes}, or change 'dimensions'")
        for name, member in self.members.items():
            ends = [("members", name, "ends", k) for k in range(2)]
            if wrong & {*ends}:
                continue
            if member.length < 1e-6:
                yield rejected_at(ends[0][:3], "both ends are at one place", "give another place")
            for keys, end in zip(ends, member.ends, strict=True):
                if end[-1] < -self.water.depth - 1e-9:
                    text = f"the end is {-self.water.depth - end[-1]:g} m below the sea bed"
                    remedy = "z = 0 is the still-water level, the bed is water.depth below it"
                    yield rejected_at(keys, text, remedy)
