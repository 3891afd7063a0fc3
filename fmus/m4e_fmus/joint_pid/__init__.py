"""The joint controller FMU; what it computes is said in README.md.

Imports the control adapter, which records the program.
"""

from __future__ import annotations

from m4e_adapters.control import JointPidConfig, joint_pid
from m4e_fmi.fmu import FmuKind

KIND = FmuKind(JointPidConfig, build=lambda config, name, **_: joint_pid(config, name=name))
