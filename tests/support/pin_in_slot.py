"""A type of joint with two coordinates: a pin that slides in a slot of the parent and turns."""

from __future__ import annotations

from m4e_fmi.joints import Coordinate, Frame, JointType, Mount, carried
from m4e_fmi.space import TURN, MotionComponent, Rotation, Twist, Y, added, scaled, unit


class PinInSlot(JointType):
    """The slot lies along `direction`; the angle is the child's absolute one, or relative."""

    name = "pin_in_slot"
    coordinates = (Coordinate("S", "s", "vs", "m"), Coordinate("Theta", "theta", "omega", "rad"))
    symbol = "sleeve"
    has_direction = True
    frees_rotation = True

    def frame(self, mount: Mount) -> Frame:
        parent, (s, angle), (speed, omega) = mount.parent, mount.q, mount.u
        if mount.is_relative:
            angle, omega = parent.angle + angle, parent.omega[Y] + omega
        local_direction = unit(mount.vector("direction"))
        direction = parent.rotation(local_direction)
        return carried(
            parent,
            added(mount.to_joint(), scaled(s, local_direction)),
            turn=((0, omega, 0), Rotation.about_axis(Y, angle)),
            local_arm=mount.vector("joint_to_child"),
            slides=((direction, speed),),
            freedoms=(
                Twist(direction, parent.omega),
                MotionComponent(TURN + Y, relative=mount.is_relative),
            ),
        )
