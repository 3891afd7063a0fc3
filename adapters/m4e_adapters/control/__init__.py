"""Power take-offs and controllers, each recorded as a Program.

Imports m4e_fmi's document, errors and program. One device is one module; start with `linear_pto`.
"""

from m4e_adapters.control.joint_pid import JointPidConfig, joint_pid
from m4e_adapters.control.linear_pto import LinearPtoConfig, linear_pto

__all__ = ["JointPidConfig", "LinearPtoConfig", "joint_pid", "linear_pto", "requirements"]


def requirements() -> list[tuple[str, bool, str]]:
    """Nothing beyond m4e_fmi itself is needed."""
    return [("control", True, "no further requirements")]
