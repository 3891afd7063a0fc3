"""A hinge: the child turns about the joint."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, carried
from m4e_fmi.joints.joint_type import Coordinate, JointType, Mount
from m4e_fmi.space import TURN, Component, Rotation, Y, plus

OWN_ANGLE, RELATIVE_ANGLE = Component(TURN + Y, relative=False), Component(TURN + Y)


class Revolute(JointType):
    """Its coordinate is the absolute angle of the child, or that less the parent's."""

    name = "revolute"
    coordinates = (Coordinate("Theta", "q", "u", "rad"),)
    other_names = ("hinge", "pin", "pivot", "rotational", "rotation", "rotary")
    symbol = "circle"
    frees_rotation = True

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint and an angle of its own."""
        parent, (angle,), (omega,) = mount.parent, mount.q, mount.u
        if mount.is_relative:
            angle, omega = plus(parent.angle, angle), plus(parent.omega[Y], omega)
        rotation = Rotation.about_y(angle)
        local_arm = mount.vector("joint_to_child")
        return carried(
            parent,
            mount.to_joint(),
            angle=(angle, (0, omega, 0), rotation),
            local_arm=local_arm,
            freedoms=(RELATIVE_ANGLE if mount.is_relative else OWN_ANGLE,),
        )
