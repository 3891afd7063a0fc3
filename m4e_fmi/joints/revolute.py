"""A hinge: the child turns about the joint."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount, carried, turned
from m4e_fmi.joints.joint_type import Coordinate, JointType
from m4e_fmi.space import ABOUT_Y, TURN, Component, Rotation, Y, scaled

OWN_ANGLE = Component(TURN + Y, relative=False)


class Revolute(JointType):
    """Its coordinate is the angle of the child against its parent, about the axis."""

    name = "revolute"
    coordinates = (Coordinate("Phi", "q", "u", "rad"),)
    other_names = ("hinge", "pin", "pivot", "rotational", "rotation", "rotary")
    symbol = "circle"
    axes = ("axis",)

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint."""
        return turned(mount, [mount.axis("axis")])


class PlanarRevolute(Revolute):
    """Its coordinate is the absolute angle of the child, or that less the parent's."""

    coordinates = (Coordinate("Theta", "q", "u", "rad"),)
    frees_rotation = True
    axes = ()

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint, and an angle of its own unless that is relative."""
        if mount.is_relative:
            return turned(mount, [ABOUT_Y])
        return carried(
            mount.parent,
            mount.to_joint(),
            turn=(scaled(mount.u[0], ABOUT_Y), Rotation.about_axis(Y, mount.q[0])),
            local_arm=mount.vector("joint_to_child"),
            freedoms=(OWN_ANGLE,),
        )
