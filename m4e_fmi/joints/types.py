"""The types of joints, from a weld to a free body."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount, carried, turned
from m4e_fmi.joints.joint_type import Coordinate, JointType
from m4e_fmi.space import (
    ABOUT_Y,
    PLANE,
    SPACE,
    TURN,
    MotionComponent,
    Rotation,
    Twist,
    Y,
    added,
    cross,
    scaled,
    unit,
)

OWN_ANGLE = MotionComponent(TURN + Y, relative=False)
TURNS = tuple(MotionComponent(TURN + axis, relative=False) for axis in range(TURN))
PLANAR_FREEDOMS = tuple(MotionComponent(index) for index in PLANE)
FREEDOMS = tuple(MotionComponent(index) for index in SPACE)


class Fixed(JointType):
    """A weld: the child moves with its parent, without any coordinate."""

    name = "fixed"
    symbol = "square"

    def frame(self, mount: Mount) -> Frame:
        """The parent's frame, moved to the child's origin."""
        return carried(mount.parent, mount.offset())


class Prismatic(JointType):
    """A slide: its coordinate is the distance along the direction, fixed in the parent.

    The direction's length does not matter.
    """

    name = "prismatic"
    coordinates = (Coordinate("S", "q", "u", "m"),)
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


class Revolute(JointType):
    """A hinge: its coordinate is the angle of the child against its parent, about the axis."""

    name = "revolute"
    coordinates = (Coordinate("Phi", "q", "u", "rad"),)
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


class Spherical(JointType):
    """A ball joint: it has the child's attitude and angular velocity against the world."""

    name = "spherical"
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
            freedoms=TURNS,
        )


class Universal(JointType):
    """Its coordinates are angles about `axis`, fixed in the parent, then `second_axis`."""

    name = "universal"
    coordinates = (Coordinate("Phi", "q1", "u1", "rad"), Coordinate("Psi", "q2", "u2", "rad"))
    symbol = "circle"
    axes = ("axis", "second_axis")

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin where the axes meet."""
        return turned(mount, [mount.axis("axis"), mount.axis("second_axis")])


class Cylindrical(JointType):
    """Its coordinates are the distance along its axis and the angle about it."""

    name = "cylindrical"
    coordinates = (Coordinate("S", "q1", "u1", "m"), Coordinate("Phi", "q2", "u2", "rad"))
    symbol = "sleeve"
    axes = ("axis",)

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint, displaced by its slide."""
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
    symbol = "sleeve"
    has_direction = True
    axes = ("axis",)

    def frame(self, mount: Mount) -> Frame:
        """Frame with its origin at the joint, displaced by its slide."""
        axis, first = mount.axis("axis"), mount.axis("direction")
        return turned(mount, [axis], [first, cross(axis, first)])


class PlanarFloating(JointType):
    """No joint in the plane: the coordinates are the centre of gravity and the body's angle."""

    name = "floating"
    coordinates = (
        Coordinate("X", "x", "vx", "m"),
        Coordinate("Z", "z", "vz", "m"),
        Coordinate("Theta", "theta", "omega", "rad"),
    )
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
    """No joint in space: the coordinates are the centre of gravity and the body's attitude."""

    name = "floating"
    coordinates = (
        Coordinate("X", "x", "vx", "m"),
        Coordinate("Y", "y", "vy", "m"),
        Coordinate("Z", "z", "vz", "m"),
    )
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
