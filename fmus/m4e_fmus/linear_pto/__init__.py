"""The linear power take-off FMU; what it computes is said in README.md.

Imports the control adapter, which records the program.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from m4e_adapters.control import LinearPtoConfig as Config
from m4e_adapters.control import linear_pto
from m4e_fmi.program import Program
from m4e_fmi.report.animation.shown import Shown, ShownRope

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


def scene(config: Config, *, folder: Path, values: Mapping[str, float]) -> Shown:  # noqa: ARG001
    """A spring and a damper between the anchor and the point; neither depends on `values`."""
    *level, z = config.anchor
    x, y = level if len(level) == 2 else (*level, 0.0)
    kinds = {"tension_damper": config.damping, "tension_spring": config.stiffness}
    ends = ((x, y, z), config.point)
    return Shown(ropes=tuple(ShownRope(kind, ends) for kind, law in kinds.items() if law))
