"""The types of joints: what an author may say of them, and how they move.

`JOINT_TYPES` is the table of all; no other module compares their names. A new type is a subclass of
`JointType` in `types`, and its entry in the tables. Imports `space`. Start with `joint_type`, then
`types`.
"""

from m4e_fmi.joints.frame import GROUND_FRAME, Frame, Mount, PointMotion, carried, turned
from m4e_fmi.joints.joint_type import (
    ATTITUDE,
    QUATERNION,
    TURNING,
    Coordinate,
    JointType,
    attitude,
    quaternion_of,
)
from m4e_fmi.joints.types import (
    Cylindrical,
    Fixed,
    Floating,
    Planar,
    PlanarFloating,
    PlanarRevolute,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)

REVOLUTE, PRISMATIC, FLOATING, FIXED = PlanarRevolute(), Prismatic(), PlanarFloating(), Fixed()


def _by_name(*joint_types: JointType) -> dict[str, JointType]:
    return {joint_type.name: joint_type for joint_type in joint_types}


JOINT_TYPES: dict[int, dict[str, JointType]] = {
    2: _by_name(REVOLUTE, PRISMATIC, FLOATING, FIXED),
    3: _by_name(
        *(Revolute(), PRISMATIC, Spherical(), Universal(), Cylindrical(), Planar()),
        *(Floating(), FIXED),
    ),
}
"""All types in the plane and in space, by the names that they have in files."""

__all__ = [
    "ATTITUDE",
    "FIXED",
    "FLOATING",
    "GROUND_FRAME",
    "JOINT_TYPES",
    "PRISMATIC",
    "QUATERNION",
    "REVOLUTE",
    "TURNING",
    "Coordinate",
    "Frame",
    "JointType",
    "Mount",
    "PointMotion",
    "attitude",
    "carried",
    "quaternion_of",
    "turned",
]
