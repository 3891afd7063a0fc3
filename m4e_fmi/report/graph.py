"""A coupled system as a graph in texts: components, what flows between them, how late, loops."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from m4e_fmi.report.drawing.labels import shortened

if TYPE_CHECKING:
    from m4e_fmi.cosim.wiring.links import Link
    from m4e_fmi.cosim.wiring.prepared import Prepared

MOST_NAMES = 4
"""Variables named at an arrow."""
TIMINGS = (
    "KNOWN", "SOLVED", "CORRECTED", "PREDICTED", "TAKEN", "HELD", "EXTRAPOLATED", "LATE",
    "DELAYED", "SWITCHED",
)  # fmt: skip
"""Names of the timings of inputs, the earliest first."""


@dataclass(frozen=True)
class GraphComponent:
    """A component with a line about it (`below`); `looped` in an algebraic loop."""

    name: str
    below: str
    looped: bool = False


@dataclass(frozen=True)
class Arrow:
    """All that flows from one component to another, or flows `once`, at initialisation.

    `timing` is the latest of its inputs, "" if there is none; `knotted` ones are in a loop.
    """

    source: str
    target: str
    label: str
    once: bool = False
    timing: str = ""
    knotted: bool = False


@dataclass(frozen=True)
class Graph:
    """A system: its components in the order of their steps, and the arrows between them.

    `timings` are those that occur, with what they mean.
    """

    title: str
    algorithm: str
    components: tuple[GraphComponent, ...]
    arrows: tuple[Arrow, ...]
    timings: dict[str, str] = field(default_factory=dict)

    @property
    def is_whole(self) -> bool:
        """True if there are components, no two of a name, and all arrows are between them."""
        names = [component.name for component in self.components]
        ends = {end for arrow in self.arrows for end in (arrow.source, arrow.target)}
        return bool(names) and len(set(names)) == len(names) and ends <= set(names)


def graph_of(prepared: Prepared) -> Graph:
    """The graph of a prepared system."""
    looped = {port.component for loop in prepared.structure.loops for port in loop}
    timings, loops = prepared.timings, prepared.structure.loops
    in_loop = {pair for loop in loops for pair in zip(loop, (*loop[1:], loop[0]), strict=True)}
    arrows = []
    bundles: dict[tuple[str, str, bool], list[Link]] = {}
    for once, links in ((False, prepared.wiring.links), (True, prepared.wiring.initial_links)):
        for link in links:
            ends = link.source.component, link.target.component, once
            bundles.setdefault(ends, []).append(link)
    for (source, target, once), links in bundles.items():
        ranks = [TIMINGS.index(timings[link].name) for link in links if link in timings]
        latest = TIMINGS[max(ranks)] if ranks else ""
        knotted = any((link.source, link.target) in in_loop for link in links)
        arrows.append(Arrow(source, target, _label(links), once, latest, knotted))
    return Graph(
        title=prepared.system.name,
        algorithm=prepared.system.simulation.algorithm,
        components=tuple(
            GraphComponent(name, _below(prepared, name), name in looped)
            for name in prepared.structure.execution_order
        ),
        arrows=tuple(arrows),
        timings={timing.name: timing.value for timing in timings.values()},
    )


def _below(prepared: Prepared, name: str) -> str:
    """How many inputs of a component are not connected, else the name of its FMU."""
    loose = sum(port.component == name for port in prepared.wiring.unconnected)
    if loose:
        return f"{loose} input{'s' * (loose > 1)} unconnected"
    return prepared.descriptions[name].path.name


def _label(links: list[Link]) -> str:
    """Connector and variables at the source's end, as ``body.float: x, vx``."""
    groups: dict[str, dict[str, None]] = {}
    for link in links:
        name = link.source.variable.partition("[")[0]
        group, _, last = name.rpartition(".")
        groups.setdefault(group, {}).setdefault(last if link.is_plain else f"{last} (converted)")
    lines = []
    for group, names in groups.items():
        shown = list(map(shortened, names))
        if len(shown) > MOST_NAMES:
            shown = [*shown[: MOST_NAMES - 1], f"{len(shown) - MOST_NAMES + 1} more"]
        lines.append(f"{shortened(group)}: {', '.join(shown)}" if group else ", ".join(shown))
    return "\n".join(lines[:3])
