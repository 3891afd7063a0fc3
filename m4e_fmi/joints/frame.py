"""Position and velocity of a body, and how a joint makes them of the parent's.

    v = v_parent + ω_parent × reach + ṡ direction
    a = a_parent + α_parent × reach + s̈ direction − inward

of the body's origin, which is where its joint holds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.program import AnyScalar
from m4e_fmi.space import (
    ZERO,
    Freedom,
    Rotation,
    Vector,
    added,
    cross,
    outward,
    scaled,
    subtracted,
    swung,
)


@dataclass(frozen=True)
class Frame:
    """Motion of one body, or of the ground. Vectors are in world axes if nothing else is said.

    `position` and `velocity` are those of the centre of gravity [m, m/s], `angle` (about +Y) and
    `omega` are absolute [rad, rad/s]. `arm` leads from the origin to the centre of gravity,
    `local_arm` is the same in body axes. `reach` leads from the parent's origin to this one,
    `local_reach` is the same in the parent's axes; `inward` is defined above [m/s²]. `rotates` is
    False of a body that never rotates. `freedoms` are the columns of the joint's motion subspace,
    one for each coordinate.
    """

    origin: Vector
    origin_velocity: Vector
    angle: AnyScalar
    omega: Vector
    rotation: Rotation
    rotates: bool
    freedoms: Sequence[Freedom] = ()
    local_arm: Vector = ZERO
    local_reach: Vector = ZERO
    reach: Vector = ZERO
    inward: Vector = ZERO
    arm: Vector = ZERO

    @property
    def position(self) -> Vector:
        """Of the centre of gravity [m]."""
        return added(self.origin, self.arm)

    @property
    def velocity(self) -> Vector:
        """Of the centre of gravity [m/s]."""
        return self.velocity_at(self.arm)

    def velocity_at(self, arm: Vector) -> Vector:
        """Velocity [m/s] of the body's point at `arm` [m] from the origin."""
        return swung(self.origin_velocity, self.omega, arm)

    def acceleration_at(self, arm: Vector, origin: Vector, alpha: Vector) -> Vector:
        """Acceleration [m/s²] of the point at `arm` for those of the origin and of turning."""
        return subtracted(swung(origin, alpha, arm), outward(self.omega, arm))

    def place(self, at: Vector) -> Place:
        """The point fixed at `at` [m] (body axes, from the centre of gravity)."""
        arm = self.rotation(added(self.local_arm, at))
        return Place(arm, added(self.origin, arm), self.velocity_at(arm))


@dataclass(frozen=True)
class Place:
    """A point of a body: its arm from the body's origin in world axes, and its motion."""

    arm: Vector
    position: Vector
    velocity: Vector


GROUND_FRAME = Frame(ZERO, ZERO, 0, ZERO, Rotation(), rotates=False)


def carried(
    parent: Frame,
    local_reach: Vector,
    *,
    angle: tuple[AnyScalar, Vector, Rotation] | None = None,
    local_arm: Vector = ZERO,
    slide: tuple[Vector, AnyScalar] | None = None,
    freedoms: Sequence[Freedom] = (),
) -> Frame:
    """Frame of a body with its origin at `local_reach` [m] from the parent's, in the parent's axes.

    `angle` is the body's own absolute angle [rad], its angular velocity [rad/s] and its rotation;
    None: the parent's. `slide` is the direction along which the origin moves in the parent (world
    axes), and its speed [m/s].
    """
    reach = parent.rotation(local_reach)
    coriolis = ZERO
    if slide and parent.rotates:
        direction, speed = slide
        coriolis = cross(scaled(speed, scaled(2, parent.omega)), direction)
    origin, velocity = added(parent.origin, reach), parent.velocity_at(reach)
    if slide:
        velocity = added(velocity, scaled(slide[1], slide[0]))
    inward = outward(parent.omega, reach)
    own_angle, omega, rotation = angle or (parent.angle, parent.omega, parent.rotation)
    return Frame(
        origin=origin,
        origin_velocity=velocity,
        angle=own_angle,
        omega=omega,
        rotation=rotation,
        rotates=angle is not None or parent.rotates,
        freedoms=freedoms,
        local_arm=local_arm,
        local_reach=local_reach,
        reach=reach,
        inward=subtracted(inward, coriolis) if slide else inward,
        arm=rotation(local_arm) if local_arm is not ZERO else ZERO,
    )
