"""Frames of bodies that slide, and then turn about axes one after the other."""

from __future__ import annotations

from collections.abc import Sequence

from m4e_fmi.joints.frame import Frame, carried
from m4e_fmi.joints.joint_type import Mount
from m4e_fmi.space import (
    TURN,
    ZERO,
    Component,
    Freedom,
    Twist,
    Vector,
    added,
    coordinate_axis,
    cross,
    scaled,
)


def turned(mount: Mount, axes: Sequence[Vector], slides: Sequence[Vector] = ()) -> Frame:
    """Frame with its origin at the joint, which slides along `slides` and turns about `axes`.

    Unit vectors: those of `slides` in the parent's axes, each of `axes` in those of what the axes
    before it have turned. The joint's coordinates are the distances, then the angles.
    """
    parent, reach = mount.parent, mount.to_joint()
    moving: list[tuple[Vector, object]] = []
    freedoms: list[Freedom] = []
    for local, distance, speed in zip(slides, mount.q, mount.u, strict=False):
        direction = parent.rotation(local)
        reach = added(reach, scaled(distance, local))
        moving.append((direction, speed))
        freedoms.append(Twist(direction, parent.omega))
    omega, rotation, turning = parent.omega, parent.rotation, ZERO
    angles = zip(axes, mount.q[len(slides) :], mount.u[len(slides) :], strict=True)
    for number, (local, angle, rate) in enumerate(angles, start=1):
        axis = rotation(local)
        along = coordinate_axis(axis)
        if along and along[1] > 0 and number == len(axes):
            freedoms.append(Component(TURN + along[0]))
        else:
            freedoms.append(Twist(ZERO, omega, axis))
        turning = added(turning, scaled(rate, cross(omega, axis)))
        omega = added(omega, scaled(rate, axis))
        rotation = rotation.turned(local, angle)
    return carried(
        parent,
        reach,
        turn=(omega, rotation),
        local_arm=mount.vector("joint_to_child"),
        slides=moving,
        turning=turning,
        freedoms=tuple(freedoms),
    )
