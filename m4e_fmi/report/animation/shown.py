"""All that one component shows in an animation, in names of its own variables.

A kind may have a ``scene(config, *, folder, values) -> Shown``; `values` are those of
its parameters at the start, by name. See docs/adapters.md.
"""

from __future__ import annotations

from dataclasses import dataclass

from m4e_fmi.report.animation.scene import Triple, Water
from m4e_fmi.report.drawing.hulls import Hull

End = str | Triple
"""A point that moves, with variables ``name.x`` …, or a fixed place [m]."""


@dataclass(frozen=True)
class ShownHull:
    """The surface of the body `name` in its own axes; if it is `fixed`, in world axes.

    A moving one has the variables ``name.x``, ``name.theta`` ….
    """

    name: str
    surface: Hull
    fixed: bool = False


@dataclass(frozen=True)
class ShownCable:
    """A line between two ends, through nodes ``name.node_x[1]`` … to ``[count]``; none if 0."""

    name: str
    ends: tuple[End, End]
    count: int = 0


@dataclass(frozen=True)
class ShownRope:
    """A load between two ends."""

    kind: str
    ends: tuple[End, End]


@dataclass(frozen=True)
class Shown:
    """Hulls, cables and ropes of a component, the water that it is in, and z of the bed [m]."""

    hulls: tuple[ShownHull, ...] = ()
    cables: tuple[ShownCable, ...] = ()
    ropes: tuple[ShownRope, ...] = ()
    water: Water | None = None
    floor: float | None = None
