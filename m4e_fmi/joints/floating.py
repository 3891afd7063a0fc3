"""No joint: the body is free in the plane."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame
from m4e_fmi.joints.joint_type import Coordinate, JointType, Mount
from m4e_fmi.space import TURN, Component, Rotation, X, Z

FREEDOMS = (Component(X), Component(Z), Component(TURN))


class Floating(JointType):
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
        *place, angle = mount.q
        *velocity, omega = mount.u
        return Frame(
            origin=(place[X], place[Z]),
            origin_velocity=(velocity[X], velocity[Z]),
            angle=angle,
            omega=omega,
            rotation=Rotation.by(angle),
            rotates=True,
            freedoms=FREEDOMS,
        )
