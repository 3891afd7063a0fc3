"""A slide: the child moves along a direction that is fixed in its parent."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount, carried
from m4e_fmi.joints.joint_type import Coordinate, JointType
from m4e_fmi.space import Twist, added, scaled, unit


class Prismatic(JointType):
    """Its coordinate is the distance slid along the direction, whose length does not matter."""

    name = "prismatic"
    coordinates = (Coordinate("S", "q", "u", "m"),)
    other_names = ("slider", "sliding", "translational", "translation", "linear")
    symbol = "sleeve"
    has_direction = True

    def frame(self, mount: Mount) -> Frame:
        """Frame that slides along the direction in the parent."""
        parent, (s,), (speed,) = mount.parent, mount.q, mount.u
        local_direction = unit(mount.vector("direction"))
        direction = parent.rotation(local_direction)
        return carried(
            parent,
            added(mount.offset(), scaled(s, local_direction)),
            slides=((direction, speed),),
            freedoms=(Twist(direction, parent.omega),),
        )
