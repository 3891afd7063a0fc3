"""No joint: the body is free."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount
from m4e_fmi.joints.joint_type import Coordinate, JointType
from m4e_fmi.space import PLANE, SPACE, Component, Rotation, Y

PLANAR_FREEDOMS = tuple(Component(index) for index in PLANE)
FREEDOMS = tuple(Component(index) for index in SPACE)


class PlanarFloating(JointType):
    """Its coordinates are the place of the centre of gravity and the angle of the body."""

    name = "floating"
    coordinates = (
        Coordinate("X", "x", "vx", "m"),
        Coordinate("Z", "z", "vz", "m"),
        Coordinate("Theta", "theta", "omega", "rad"),
    )
    other_names = ("free", "6dof", "3dof", "freeflyer")
    is_free = True
    frees_rotation = True

    def frame(self, mount: Mount) -> Frame:
        """Frame at the centre of gravity, from the coordinates alone."""
        (x, z, angle), (vx, vz, omega) = mount.q, mount.u
        return Frame(
            origin=(x, 0, z),
            origin_velocity=(vx, 0, vz),
            omega=(0, omega, 0),
            rotation=Rotation.about_axis(Y, angle),
            rotates=True,
            freedoms=PLANAR_FREEDOMS,
        )


class Floating(JointType):
    """Its coordinates are the place of the centre of gravity and the attitude of the body."""

    name = "floating"
    coordinates = (
        Coordinate("X", "x", "vx", "m"),
        Coordinate("Y", "y", "vy", "m"),
        Coordinate("Z", "z", "vz", "m"),
    )
    other_names = PlanarFloating.other_names
    has_quaternion = True
    is_free = True
    frees_rotation = True

    def frame(self, mount: Mount) -> Frame:
        """Frame at the centre of gravity, from the coordinates alone."""
        x, y, z, *e = mount.q
        vx, vy, vz, *omega = mount.u
        return Frame(
            origin=(x, y, z),
            origin_velocity=(vx, vy, vz),
            omega=(omega[0], omega[1], omega[2]),
            rotation=Rotation.of_quaternion(e),
            rotates=True,
            freedoms=FREEDOMS,
        )
