"""A ball joint: the child turns about the joint in any way."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount, carried
from m4e_fmi.joints.joint_type import JointType
from m4e_fmi.space import TURN, Component, Rotation

FREEDOMS = tuple(Component(TURN + axis, relative=False) for axis in range(TURN))


class Spherical(JointType):
    """It has the child's attitude and angular velocity against the world."""

    name = "spherical"
    other_names = ("ball", "ball_joint", "s")
    symbol = "circle"
    has_quaternion = True
    frees_rotation = True

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint."""
        omega = (mount.u[0], mount.u[1], mount.u[2])
        return carried(
            mount.parent,
            mount.to_joint(),
            turn=(omega, Rotation.of_quaternion(mount.q)),
            local_arm=mount.vector("joint_to_child"),
            freedoms=FREEDOMS,
        )
