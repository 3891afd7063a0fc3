"""The types of joints, one module each: what an author may say of them, and how they move.

`JOINT_TYPES` is the table of all; no other module compares their names. A new type is a module here
with a subclass of `JointType`, and its entry in the table. Imports `space`. Start with
`joint_type`, then `prismatic`.
"""

from m4e_fmi.joints.fixed import Fixed
from m4e_fmi.joints.floating import Floating
from m4e_fmi.joints.frame import GROUND_FRAME, Frame, Place, carried
from m4e_fmi.joints.joint_type import Coordinate, JointType, Mount
from m4e_fmi.joints.prismatic import Prismatic
from m4e_fmi.joints.revolute import Revolute

REVOLUTE, PRISMATIC, FLOATING, FIXED = Revolute(), Prismatic(), Floating(), Fixed()

JOINT_TYPES: dict[str, JointType] = {
    joint_type.name: joint_type for joint_type in (REVOLUTE, PRISMATIC, FLOATING, FIXED)
}
"""All types by the names that they have in files."""

__all__ = [
    "FIXED",
    "FLOATING",
    "GROUND_FRAME",
    "JOINT_TYPES",
    "PRISMATIC",
    "REVOLUTE",
    "Coordinate",
    "Frame",
    "JointType",
    "Mount",
    "Place",
    "carried",
]
