"""The interface of a type of joint, and attitudes as quaternions and as angles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

from m4e_fmi.joints.frame import Frame, Mount
from m4e_fmi.program import AnyScalar, atan2, cos, sin, sqrt
from m4e_fmi.space import Rotation, Vector, added, cross, dot, scaled

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
    def effort_unit(self) -> str:
        """Unit of an effort along it."""
        return "N.m" if self.is_angle else "N"

    @property
    def is_angle(self) -> bool:
        """True of an angle, False of a distance."""
        return self.unit == "rad"


QUATERNION = ("e0", "e1", "e2", "e3")
"""States of a body's attitude: body axes → world axes, scalar part first."""
ATTITUDE = ("phi", "theta", "psi")
"""Roll, pitch, yaw [rad]: turns about the body's X axis, after its Y, after its Z."""
TURNING = ("omega_x", "omega", "omega_z")
"""The angular velocity in world axes [rad/s]; omega is that about +Y, as in the plane."""
ATTRACTION = 1.0
"""Rate [1/s] at which the length of a quaternion returns to 1."""


class JointType(ABC):
    """A type of joint: facts for authors and checks, and the motion that it allows.

    Angles come last among the `coordinates`.
    """

    name: ClassVar[str]
    coordinates: ClassVar[tuple[Coordinate, ...]] = ()
    symbol: ClassVar[Symbol] = ""

    has_direction: ClassVar[bool] = False
    """The author gives a `direction`, fixed in the parent."""

    axes: ClassVar[tuple[str, ...]] = ()
    """Axes that the author gives in space: the first is fixed in the parent."""

    has_quaternion: ClassVar[bool] = False
    """After its `coordinates` it has the child's attitude against the world as a quaternion e, and
    the child's angular velocity ω in world axes: ė = ½ ω e + κ (1 − |e|²) e."""

    is_free: ClassVar[bool] = False
    """It holds nothing: always to the ground, without geometry, its states named after the body."""

    frees_rotation: ClassVar[bool] = False
    """It exerts no moment but its effort; its angle may be the child's absolute one.

    Its last freedoms are the angular `Component`s of all that bodies of the model can have.
    """

    @abstractmethod
    def frame(self, mount: Mount) -> Frame:
        """The child's frame, with a freedom for each coordinate."""

    @cached_property
    def vectors(self) -> tuple[str, ...]:
        """Fields of a joint that its author has to give: a direction, axes."""
        return (*(("direction",) if self.has_direction else ()), *self.axes)

    @cached_property
    def positions(self) -> tuple[str, ...]:
        """Names of the states that are coordinates."""
        own = tuple(c.position for c in self.coordinates)
        return own + QUATERNION if self.has_quaternion else own

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Names of the states that are velocities, one for each freedom."""
        own = tuple(c.velocity for c in self.coordinates)
        return own + TURNING if self.has_quaternion else own

    @cached_property
    def turns(self) -> tuple[bool, ...]:
        """For each velocity, whether it turns the child."""
        own = tuple(c.is_angle for c in self.coordinates)
        return own + (True,) * len(TURNING) if self.has_quaternion else own

    def rates(self, q: Sequence[AnyScalar], u: Sequence[AnyScalar]) -> list[AnyScalar]:
        """q̇ of the joint's own coordinates."""
        found = list(u[: len(self.coordinates)])
        return found + quaternion_rates(q[-4:], u[-3:]) if self.has_quaternion else found

    @cached_property
    def start_keys(self) -> tuple[str, ...]:
        """Keys of the start values: positions, then velocities."""
        positions = tuple(c.position for c in self.coordinates)
        return (*positions, *(ATTITUDE if self.has_quaternion else ()), *self.velocities)

    @cached_property
    def start_units(self) -> dict[str, str]:
        """Unit of each start value by its key."""
        positions = {c.position: c.unit for c in self.coordinates}
        velocities = {c.velocity: f"{c.unit}/s" for c in self.coordinates}
        if self.has_quaternion:
            positions |= dict.fromkeys(ATTITUDE, "rad")
            velocities |= dict.fromkeys(TURNING, "rad/s")
        return positions | velocities

    @cached_property
    def rotates(self) -> bool:
        """The child can rotate against its parent."""
        return self.has_quaternion or any(c.is_angle for c in self.coordinates)

    @property
    def chooses_angle(self) -> bool:
        """The author may choose between an absolute and a relative angle."""
        return self.frees_rotation and not self.is_free and not self.has_quaternion

    @cached_property
    def efforts(self) -> dict[str, Coordinate]:
        """The coordinates along which efforts may act, by the names of these: effort, or effort1, …

        None of a joint to the ground that holds nothing, nor of one without coordinates.
        """
        own = () if self.is_free else self.coordinates
        return {f"effort{c.position.removeprefix('q')}": c for c in own}

    def number_of(self, position: str) -> int:
        """The place among the coordinates of the one with this name; of the only one for ""."""
        return [c.position for c in self.coordinates].index(position) if position else 0


def quaternion_rates(e: Sequence[AnyScalar], omega: Sequence[AnyScalar]) -> list[AnyScalar]:
    """ė (4,) [1/s] for the angular velocity `omega` (3,) [rad/s] in world axes.

    The rotation does not depend on the length of e: what rounding and steps of an integrator do to
    it decays, and no one who integrates has to know of quaternions.
    """
    e0, v = e[0], (e[1], e[2], e[3])
    w = (omega[0], omega[1], omega[2])
    drift = ATTRACTION * (1 - (e0 * e0 + dot(v, v)))
    turned = added(scaled(e0, w), cross(w, v))
    return [
        drift * e0 - 0.5 * dot(w, v),
        *(0.5 * part + drift * own for part, own in zip(turned, v, strict=True)),
    ]


def quaternion_of(phi: float, theta: float, psi: float) -> tuple[float, float, float, float]:
    """The quaternion of roll, pitch and yaw [rad]."""
    (cx, sx), (cy, sy), (cz, sz) = ((cos(a / 2), sin(a / 2)) for a in (phi, theta, psi))
    return (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )


def attitude(rotation: Rotation) -> Vector:
    """Roll, pitch and yaw [rad] of a rotation.

    At a pitch of ±90° yaw is any, and roll is such that the three are the rotation. The angle of a
    turn about one coordinate axis is that itself, beyond ±180°, too.
    """
    if rotation.about is not None:
        parts: list[AnyScalar] = [0, 0, 0]
        parts[rotation.about] = rotation.angle
        return parts[0], parts[1], parts[2]
    (xx, xy, xz), (yx, yy, yz), (zx, _, _) = rotation.rows
    across, psi = sqrt(xx * xx + yx * yx), atan2(yx, xx)
    c, s = cos(psi), sin(psi)
    return atan2(s * xz - c * yz, c * yy - s * xy), atan2(-zx, across), psi


def angles_of_attitudes(names: Iterable[str], known: Collection[str]) -> list[str]:
    """Those of `names` that are an angle, as body.hull.theta, of a quaternion that is `known`."""
    split = ((name, *name.rpartition(".")[::2]) for name in names)
    return [
        name
        for name, owner, part in split
        if part in ATTITUDE and all(f"{owner}.{e}" in known for e in QUATERNION)
    ]


def with_quaternions(values: Mapping[str, float], starts: Mapping[str, float]) -> dict[str, float]:
    """`values` with quaternions in place of angles [rad]; other parts of an attitude stay.

    `starts` has the present values of the quaternions. ValueError names an attitude that is given
    in both ways.
    """
    given = angles_of_attitudes(values, starts)
    result = {name: value for name, value in values.items() if name not in given}
    for owner in dict.fromkeys(name.rpartition(".")[0] for name in given):
        quaternion = [f"{owner}.{part}" for part in QUATERNION]
        both = [name for name in quaternion if name in values]
        if both:
            raise ValueError(f"{both[0]} is given, too; give either angles or all of e0 … e3")
        present = attitude(Rotation.of_quaternion([starts[name] for name in quaternion]))
        angles = (
            values.get(f"{owner}.{part}", now) for part, now in zip(ATTITUDE, present, strict=True)
        )
        result |= zip(quaternion, quaternion_of(*angles), strict=True)
    return result


def no_attitudes(values: Mapping[str, float]) -> list[str]:
    """Owners of quaternions among `values` that are zero, and so no attitude."""
    owners = (name.removesuffix(".e0") for name in values if name.endswith(".e0"))
    parts = ((owner, [values.get(f"{owner}.{e}", 1.0) for e in QUATERNION]) for owner in owners)
    return [owner for owner, quaternion in parts if not any(quaternion)]
