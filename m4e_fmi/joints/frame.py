"""Position and velocity of a body, and how a joint makes them of the parent's.

    v = v_parent + ω_parent × reach + ṡ direction
    a = a_parent + α_parent × reach + s̈ direction − inward

of the body's origin, which is where its joint holds it; `inward` has an angular part, too, where an
axis about which the body turns moves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from m4e_fmi.program import AnyScalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Freedom,
    MotionComponent,
    Rotation,
    Twist,
    Vector,
    Wrench,
    added,
    coordinate_axis,
    cross,
    outward,
    scaled,
    subtracted,
    swung,
    unit,
)


@dataclass(frozen=True)
class Frame:
    """Motion of one body, or of the ground. Vectors are in world axes if nothing else is said.

    `position` and `velocity` are those of the centre of gravity [m, m/s], `rotation` and `omega`
    are absolute [rad/s]. `arm` leads from the origin to the centre of gravity, `local_arm` is the
    same in body axes. `reach` leads from the parent's origin to this one, `local_reach` is the same
    in the parent's axes; `inward` is defined above [m/s², rad/s²]. `rotates` is False of a body
    that never rotates. `freedoms` are the columns of the joint's motion subspace, one for each
    coordinate.
    """

    origin: Vector
    origin_velocity: Vector
    omega: Vector
    rotation: Rotation
    rotates: bool
    freedoms: Sequence[Freedom] = ()
    local_arm: Vector = ZERO
    local_reach: Vector = ZERO
    reach: Vector = ZERO
    inward: Wrench = (*ZERO, *ZERO)
    arm: Vector = ZERO

    @property
    def angle(self) -> AnyScalar:
        """The angle about +Y [rad] of a body that turns about no other axis."""
        return self.rotation.angle

    @cached_property
    def position(self) -> Vector:
        """Of the centre of gravity [m]."""
        return added(self.origin, self.arm)

    @cached_property
    def velocity(self) -> Vector:
        """Of the centre of gravity [m/s]."""
        return self.velocity_at(self.arm)

    def velocity_at(self, arm: Vector) -> Vector:
        """Velocity [m/s] of the body's point at `arm` [m] from the origin."""
        return swung(self.origin_velocity, self.omega, arm)

    def acceleration_at(self, arm: Vector, origin: Vector, alpha: Vector) -> Vector:
        """Acceleration [m/s²] of the point at `arm` for those of the origin and of turning."""
        return subtracted(swung(origin, alpha, arm), outward(self.omega, arm))

    def place(self, at: Vector) -> PointMotion:
        """The point fixed at `at` [m] (body axes, from the centre of gravity)."""
        arm = self.rotation(added(self.local_arm, at))
        return PointMotion(arm, added(self.origin, arm), self.velocity_at(arm))


@dataclass(frozen=True)
class PointMotion:
    """A point of a body: its arm from the body's origin in world axes, and its motion."""

    arm: Vector
    position: Vector
    velocity: Vector


GROUND_FRAME = Frame(ZERO, ZERO, ZERO, Rotation(), rotates=False)


@dataclass(frozen=True)
class Mount:
    """A joint of a model in some state, for `JointType.frame`.

    `parent` is the frame of the parent, `q` and `u` are the joint's own coordinates and velocities.
    `vector` evaluates a vector of the author's: parent_to_joint, joint_to_child, direction, axis,
    second_axis. `is_relative`: the angle among `q` is the child's less the
    parent's.
    """

    parent: Frame
    q: Sequence[AnyScalar]
    u: Sequence[AnyScalar]
    vector: Callable[[str], Vector]
    is_relative: bool

    def axis(self, name: str) -> Vector:
        """An axis or direction of the author's, of length 1."""
        return unit(self.vector(name))

    def offset(self) -> Vector:
        """From the parent's origin to the child's centre of gravity [m], in the parent's axes.

        Of a child that does not rotate against its parent, at q = 0.
        """
        apart = added(self.vector("parent_to_joint"), self.vector("joint_to_child"))
        return added(self.parent.local_arm, apart)

    def to_joint(self) -> Vector:
        """From the parent's origin to the joint [m], in the parent's axes."""
        return added(self.parent.local_arm, self.vector("parent_to_joint"))


def carried(
    parent: Frame,
    local_reach: Vector,
    *,
    turn: tuple[Vector, Rotation] | None = None,
    local_arm: Vector = ZERO,
    slides: Sequence[tuple[Vector, AnyScalar]] = (),
    turning: Vector = ZERO,
    freedoms: Sequence[Freedom] = (),
) -> Frame:
    """Frame of a body with its origin at `local_reach` [m] from the parent's, in the parent's axes.

    `turn` is the body's own angular velocity [rad/s] and its rotation; None: the parent's.
    `slides` are the directions along which the origin moves in the parent (world axes), each with
    its speed [m/s]. `turning` [rad/s²] is the angular acceleration at which axes that move turn the
    body while no rate of its joint changes.
    """
    reach = parent.rotation(local_reach)
    origin, velocity = added(parent.origin, reach), parent.velocity_at(reach)
    inward = outward(parent.omega, reach)
    for direction, speed in slides:
        velocity = added(velocity, scaled(speed, direction))
        if parent.rotates:
            coriolis = cross(scaled(speed, scaled(2, parent.omega)), direction)
            inward = subtracted(inward, coriolis)
    omega, rotation = turn or (parent.omega, parent.rotation)
    return Frame(
        origin=origin,
        origin_velocity=velocity,
        omega=omega,
        rotation=rotation,
        rotates=turn is not None or parent.rotates,
        freedoms=freedoms,
        local_arm=local_arm,
        local_reach=local_reach,
        reach=reach,
        inward=(*inward, *scaled(-1, turning)),
        arm=rotation(local_arm) if local_arm is not ZERO else ZERO,
    )


def turned(mount: Mount, axes: Sequence[Vector], slides: Sequence[Vector] = ()) -> Frame:
    """Frame with its origin at the joint, which slides along `slides` and turns about `axes`.

    Unit vectors: those of `slides` in the parent's axes, each of `axes` in those of what the axes
    before it have turned. The joint's coordinates are the distances, then the angles.
    """
    parent, reach = mount.parent, mount.to_joint()
    moving: list[tuple[Vector, object]] = []
    freedoms: list[Freedom] = []
    for local, distance, speed in zip(slides, mount.q, mount.u, strict=False):
        direction = parent.rotation(local)
        reach = added(reach, scaled(distance, local))
        moving.append((direction, speed))
        freedoms.append(Twist(direction, parent.omega))
    omega, rotation, turning = parent.omega, parent.rotation, ZERO
    angles = zip(axes, mount.q[len(slides) :], mount.u[len(slides) :], strict=True)
    for number, (local, angle, rate) in enumerate(angles, start=1):
        axis = rotation(local)
        along = coordinate_axis(axis)
        if along and along[1] > 0 and number == len(axes):
            freedoms.append(MotionComponent(TURN + along[0]))
        else:
            freedoms.append(Twist(ZERO, omega, axis))
        turning = added(turning, scaled(rate, cross(omega, axis)))
        omega = added(omega, scaled(rate, axis))
        rotation = rotation.turned(local, angle)
    return carried(
        parent,
        reach,
        turn=(omega, rotation),
        local_arm=mount.vector("joint_to_child"),
        slides=moving,
        turning=turning,
        freedoms=tuple(freedoms),
    )
