"""Joints with several coordinates, each along or about an axis."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount, turned
from m4e_fmi.joints.joint_type import Coordinate, JointType
from m4e_fmi.space import cross


class Universal(JointType):
    """Its coordinates are angles about `axis`, fixed in the parent, then `second_axis`."""

    name = "universal"
    coordinates = (Coordinate("Phi", "q1", "u1", "rad"), Coordinate("Psi", "q2", "u2", "rad"))
    other_names = ("cardan", "hooke", "u")
    symbol = "circle"
    axes = ("axis", "second_axis")

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin where the axes meet."""
        return turned(mount, [mount.axis("axis"), mount.axis("second_axis")])


class Cylindrical(JointType):
    """Its coordinates are the distance along its axis and the angle about it."""

    name = "cylindrical"
    coordinates = (Coordinate("S", "q1", "u1", "m"), Coordinate("Phi", "q2", "u2", "rad"))
    other_names = ("sliding_hinge", "c")
    symbol = "sleeve"
    axes = ("axis",)

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint, as far as it has slid."""
        axis = mount.axis("axis")
        return turned(mount, [axis], [axis])


class Planar(JointType):
    """It slides along `direction`, then at right angles to that and `axis`, and turns about `axis`.

    Both are fixed in the parent; the direction is at right angles to the axis.
    """

    name = "planar"
    coordinates = (
        Coordinate("S", "q1", "u1", "m"),
        Coordinate("R", "q2", "u2", "m"),
        Coordinate("Phi", "q3", "u3", "rad"),
    )
    other_names = ("plane", "point_in_plane")
    symbol = "sleeve"
    has_direction = True
    axes = ("axis",)

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint, as far as it has slid."""
        axis, first = mount.axis("axis"), mount.axis("direction")
        return turned(mount, [axis], [first, cross(axis, first)])
