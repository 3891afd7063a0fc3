"""The linear power take-off FMU; what it computes is said in README.md.

Imports the control adapter, which records the program.
"""

from __future__ import annotations

from m4e_adapters.control import LinearPtoConfig, linear_pto
from m4e_fmi.fmu import FmuKind
from m4e_fmi.report.animation.shown import Shown, ShownRope


def _scene(config: LinearPtoConfig, **_: object) -> Shown:
    """A spring and a damper between the anchor and the point."""
    *level, z = config.anchor
    x, y = level if len(level) == 2 else (*level, 0.0)
    kinds = {"tension_damper": config.damping, "tension_spring": config.stiffness}
    ends = ((x, y, z), config.point)
    return Shown(ropes=tuple(ShownRope(kind, ends) for kind, law in kinds.items() if law))


KIND = FmuKind(
    LinearPtoConfig,
    build=lambda config, name, **_: linear_pto(config, name=name),
    scene=_scene,
)
