"""A type of joint that the package does not have: a screw, all of it in this file."""

from __future__ import annotations

from m4e_fmi.joints import Coordinate, Frame, JointType, Mount, carried
from m4e_fmi.space import ABOUT_Y, Rotation, Twist, Y, added, scaled


class Screw(JointType):
    """The child turns about the joint, and slides along `direction` per radian: a rack and pinion.

    The length of the direction is the pitch [m/rad]; the angle is that against the parent [rad].
    """

    name = "screw"
    coordinates = (Coordinate("Phi", "q", "u", "rad"),)
    symbol = "circle"
    has_direction = True

    def frame(self, mount: Mount) -> Frame:
        parent, (angle,), (rate,) = mount.parent, mount.q, mount.u
        own_angle, local_pitch = parent.angle + angle, mount.vector("direction")
        pitch = parent.rotation(local_pitch)
        return carried(
            parent,
            added(mount.to_joint(), scaled(angle, local_pitch)),
            turn=((0, parent.omega[Y] + rate, 0), Rotation.about_axis(Y, own_angle)),
            local_arm=mount.vector("joint_to_child"),
            slides=((pitch, rate),),
            freedoms=(Twist(pitch, parent.omega, turning=ABOUT_Y),),
        )
