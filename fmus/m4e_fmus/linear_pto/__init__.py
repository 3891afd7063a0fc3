"""The linear power take-off FMU; what it computes is said in README.md.

Imports the control adapter, which records the program.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_adapters.control import LinearPtoConfig as Config
from m4e_adapters.control import linear_pto
from m4e_fmi.program import Program

__all__ = ["Config", "make"]


def make(
    config: Config,
    *,
    name: str,
    folder: Path,  # noqa: ARG001  part of the interface of every kind of FMU
    progress: Callable[[str], None] = print,  # noqa: ARG001
) -> Program:
    """The program of the power take-off called `name`; it reads no files and takes no time."""
    return linear_pto(config, name=name)
