"""The joint controller FMU; what it computes is said in README.md.

Imports the control adapter, which records the program.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_adapters.control import JointPidConfig as Config
from m4e_adapters.control import joint_pid
from m4e_fmi.program import Program

__all__ = ["Config", "make"]


def make(
    config: Config,
    *,
    name: str,
    folder: Path,  # noqa: ARG001  part of the interface of every kind of FMU
    progress: Callable[[str], None] = print,  # noqa: ARG001
) -> Program:
    """The program of the controller called `name`; it reads no files and takes no time."""
    return joint_pid(config, name=name)
