"""A weld: the child moves with its parent."""

from __future__ import annotations

from m4e_fmi.joints.frame import Frame, Mount, carried
from m4e_fmi.joints.joint_type import JointType


class Fixed(JointType):
    """It has no coordinate."""

    name = "fixed"
    other_names = ("weld", "welded", "rigid", "lock")
    symbol = "square"

    def frame(self, mount: Mount) -> Frame:
        """The parent's frame, moved to the child's origin."""
        return carried(mount.parent, mount.offset())
