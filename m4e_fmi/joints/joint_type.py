"""The interface of a type of joint."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

from m4e_fmi.joints.frame import Frame
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import Vector, added

Symbol = Literal["circle", "sleeve", "square", ""]
"""How a joint is drawn; a sleeve lies along the joint's direction."""


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a joint: its letter in equations, names of its states, unit (m or rad).

    Letter "S" makes the coordinate S_3 of body 3 with the velocity SD_3; `position` and `velocity`
    are keys of start values and, after the name of the joint or body, names of the states.
    """

    letter: str
    position: str
    velocity: str
    unit: Literal["m", "rad"]

    @property
    def is_angle(self) -> bool:
        """True of an angle, False of a distance."""
        return self.unit == "rad"


@dataclass(frozen=True)
class Mount:
    """A joint of a model in some state, for `JointType.frame`.

    `parent` is the frame of the parent, `q` (n,) and `u` (n,) are the joint's own coordinates and
    velocities. `vector` evaluates a vector of the author's: parent_to_joint, joint_to_child,
    direction. `is_relative`: the angle among `q` is the child's less the parent's.
    """

    parent: Frame
    q: Sequence[AnyScalar]
    u: Sequence[AnyScalar]
    vector: Callable[[str], Vector]
    is_relative: bool

    def offset(self) -> Vector:
        """From the parent's origin to the child's centre of gravity [m], in the parent's axes.

        Of a child that does not rotate against its parent, at q = 0.
        """
        apart = added(self.vector("parent_to_joint"), self.vector("joint_to_child"))
        return added(self.parent.local_arm, apart)

    def to_joint(self) -> Vector:
        """From the parent's origin to the joint [m], in the parent's axes."""
        return added(self.parent.local_arm, self.vector("parent_to_joint"))


class JointType(ABC):
    """A type of joint: facts for authors and checks, and the motion that it allows.

    The only angle among the `coordinates` is the last one. `other_names` are those that other
    programs have for the type.
    """

    name: ClassVar[str]
    coordinates: ClassVar[tuple[Coordinate, ...]] = ()
    other_names: ClassVar[tuple[str, ...]] = ()
    symbol: ClassVar[Symbol] = ""

    has_direction: ClassVar[bool] = False
    """The author gives a `direction`, fixed in the parent."""

    is_free: ClassVar[bool] = False
    """It holds nothing: always to the ground, without geometry, its states named after the body."""

    frees_rotation: ClassVar[bool] = False
    """It exerts no moment but its effort; its angle may be the child's absolute one.

    Its last freedom is the `Component` TURN + Y.
    """

    @abstractmethod
    def frame(self, mount: Mount) -> Frame:
        """The child's frame, with a freedom for each coordinate."""

    @cached_property
    def start_keys(self) -> tuple[str, ...]:
        """Keys of the start values: positions, then velocities."""
        positions = (c.position for c in self.coordinates)
        return (*positions, *(c.velocity for c in self.coordinates))

    @cached_property
    def start_units(self) -> dict[str, str]:
        """Unit of each start value by its key."""
        positions = {c.position: c.unit for c in self.coordinates}
        return positions | {c.velocity: f"{c.unit}/s" for c in self.coordinates}

    @cached_property
    def rotates(self) -> bool:
        """The child can rotate against its parent."""
        return any(c.is_angle for c in self.coordinates)

    @property
    def chooses_angle(self) -> bool:
        """The author may choose between an absolute and a relative angle."""
        return self.frees_rotation and not self.is_free

    @property
    def has_effort(self) -> bool:
        """It has one coordinate, q with the rate u, along which an effort may act."""
        return len(self.coordinates) == 1

    @property
    def effort_unit(self) -> str:
        """Unit of the effort."""
        return "N.m" if self.coordinates[0].is_angle else "N"
