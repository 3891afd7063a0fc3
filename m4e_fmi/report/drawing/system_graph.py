"""A coupled system as a picture: components, what flows between them, how late, and loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import Labels, shortened
from m4e_fmi.report.drawing.style import COLOURS, GREY, INK, pale, save
from m4e_fmi.report.graph import TIMINGS, Arrow, Graph, GraphComponent, graph_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from m4e_fmi.cosim import Prepared

SPACE = (4.0, 2.2)  # inches between neighbours
BOX = (1.5, 0.62)  # inches
LEAST_ROW = 16.0  # inches that a row of parts takes before another one begins under it
WIDE = 1.6  # width over height of all such rows
BEND = 0.16
BEND_BESIDE = 0.42  # of an arrow beside another from and to the same components
BEND_OWN = -1.46  # in addition, of an arrow from a component to itself
POINTS = 200  # of an arc
LOOP = COLOURS[4]
OF_TIMING = {
    "KNOWN": INK, "SOLVED": INK, "CORRECTED": INK, "PREDICTED": COLOURS[0],
    "TAKEN": COLOURS[2], "HELD": COLOURS[2], "EXTRAPOLATED": COLOURS[3], "LATE": COLOURS[1],
    "DELAYED": COLOURS[1], "SWITCHED": COLOURS[2],
}  # fmt: skip


def draw_system(prepared: Prepared, picture: str | Path) -> Path:
    """Draw a prepared system to `picture` (PNG, SVG or PDF, by its suffix)."""
    return save(system_figure(prepared), picture, margin=0.15)


def system_figure(prepared: Prepared) -> Figure:
    """The same as a figure of matplotlib, to be shown or changed."""
    return graph_figure(graph_of(prepared))


def graph_figure(graph: Graph) -> Figure:
    """The graph of a system as a figure of matplotlib."""
    from matplotlib.figure import Figure

    neighbours = [(a.source, a.target) for a in graph.arrows if a.source != a.target]
    places = layout([component.name for component in graph.components], neighbours)
    corners = np.array(list(places.values()))
    low, high = corners.min(axis=0) - BOX, corners.max(axis=0) + BOX
    size = np.maximum(high - low, (4.0, 2.0))
    low = (low + high - size) / 2
    figure = Figure(figsize=tuple(size))
    axis = figure.add_axes((0, 0, 1, 1))
    axis.set_axis_off()
    axis.set_xlim(low[0], low[0] + size[0])
    axis.set_ylim(low[1], low[1] + size[1])
    pairs = {(arrow.source, arrow.target, arrow.once) for arrow in graph.arrows}
    labels = Labels(axis)
    for arrow in graph.arrows:
        beside = arrow.once and (arrow.source, arrow.target, False) in pairs
        ends = (places[arrow.source], places[arrow.target])
        _arrow(axis, arrow, ends, BEND_BESIDE if beside else BEND, labels)
    for component in graph.components:
        place = places[component.name]
        _box(axis, component, place)
        labels.avoid(np.array([place + np.array(BOX) * (0, y) for y in (-0.5, 0.0, 0.5)]))
        labels.avoid(place + np.array(BOX) / 2 * [[-1, -1], [1, -1], [1, 1], [-1, 1]])
    labels.place()
    _legend(axis, graph)
    axis.set_title(shortened(graph.title), fontsize=12, fontweight="bold", color=INK, pad=12)
    return figure


def layout(names: Sequence[str], pairs: Iterable[tuple[str, str]]) -> dict[str, np.ndarray]:
    """Centres of components (2,) [inches]: neighbours near one another, none on top of another.

    `pairs` are the neighbours. Parts that nothing connects stand side by side, in several rows
    where one would be long.
    """
    import networkx as nx

    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(names)
    graph.add_edges_from(pairs)
    parts = list[dict[str, np.ndarray]]()
    groups: list[set[str]] = sorted(nx.connected_components(graph), key=len, reverse=True)
    for part in groups:
        members = graph.subgraph([name for name in names if name in part])
        raw = nx.kamada_kawai_layout(members)
        points = np.array([raw[name] for name in members])
        points = _turned(points - points.mean(axis=0))
        points *= _spread(points)
        parts.append(dict(zip(members, points, strict=True)))
    found: dict[str, np.ndarray] = {}
    for part, corner in zip(
        parts, _corners([np.ptp(list(part.values()), axis=0) for part in parts]), strict=True
    ):
        low = np.min(list(part.values()), axis=0)
        found |= {name: place - low + corner for name, place in part.items()}
    return found


def _corners(extents: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Lower left corners (2,) [inches] of parts of these widths and heights, row under row."""
    sizes = np.array([extent + SPACE for extent in extents])
    widest = max(LEAST_ROW, *sizes[:, 0], float(np.sqrt(WIDE * sizes.prod(axis=1).sum())))
    found, left, top, height = [], 0.0, 0.0, 0.0
    for width, tall in sizes:
        if left > 0.0 and left + width > widest:
            left, top, height = 0.0, top - height, 0.0
        found.append(np.array([left, top - tall]))
        left, height = left + width, max(height, tall)
    return found


def _turned(points: np.ndarray) -> np.ndarray:
    """The same points with their longest extent from left to right."""
    if len(points) < 2:
        return points
    axes = np.linalg.svd(points, full_matrices=False)[2]
    turned = points @ axes.T
    return turned * np.where(turned[0] > 0, -1.0, 1.0)  # the first to step at the left


def _spread(points: np.ndarray) -> float:
    """The factor that keeps all boxes apart."""
    factor = 1.0
    for k, one in enumerate(points):
        for other in points[k + 1 :]:
            apart = np.abs(one - other) / SPACE
            factor = max(factor, 1.0 / max(float(np.hypot(*apart)), 1e-3))
    return factor


def _box(axis: Axes, component: GraphComponent, place: np.ndarray) -> None:
    from matplotlib.patches import FancyBboxPatch

    name, colour = component.name, LOOP if component.looped else COLOURS[0]
    corner = place - np.array(BOX) / 2
    axis.add_patch(
        FancyBboxPatch(
            tuple(corner), *BOX, boxstyle="round,pad=0,rounding_size=0.08", lw=1.4, ec=colour,
            fc=pale(colour), zorder=4,
        )
    )  # fmt: skip
    width = 9 if len(name) < 16 else 6.5
    axis.text(place[0], place[1] + 0.09, shortened(name), ha="center", va="center", color=INK,
              fontsize=width, fontweight="bold", zorder=5)  # fmt: skip
    axis.text(place[0], place[1] - 0.14, shortened(component.below), ha="center", va="center",
              color=GREY, fontsize=6.5, zorder=5)  # fmt: skip


def _arrow(
    axis: Axes, arrow: Arrow, ends: tuple[np.ndarray, np.ndarray], rad: float, labels: Labels
) -> None:
    """One arrow for all that flows from a component to another, in the colour of the latest."""
    colour = LOOP if arrow.knotted else OF_TIMING.get(arrow.timing, GREY)
    first, last = ends
    if np.allclose(first, last):
        first, last = first + np.array([-0.3, 0.3]), last + np.array([0.3, 0.3])
        rad += BEND_OWN
    arc = _arc(first, last, rad)
    axis.plot(*arc.T, color=colour, lw=2.4 if arrow.knotted else 1.2,
              ls="-" if arrow.timing else "--", zorder=3 if arrow.knotted else 2)  # fmt: skip
    _head(axis, arc, colour)
    labels.add(arrow.label, arc[POINTS // 2], colour)
    labels.avoid(np.vstack([arc[::5], arc[::-5]]))  # there and back: outlines are closed


def _arc(first: np.ndarray, last: np.ndarray, rad: float) -> np.ndarray:
    """Points of a parabola (n, 2), whose control point stands off by `rad` times its length."""
    way = last - first
    control = (first + last) / 2 + rad * np.array([way[1], -way[0]])
    s = np.linspace(0, 1, POINTS)[:, None]
    return (1 - s) ** 2 * first + 2 * s * (1 - s) * control + s**2 * last


def _head(axis: Axes, arc: np.ndarray, colour: str) -> None:
    """An arrow's head where the arc meets the box of its target."""
    outside = (np.abs(arc - arc[-1]) > np.array(BOX) / 2 + 0.02).any(axis=1)
    if not outside.any():
        return
    tip = int(np.flatnonzero(outside)[-1])
    style = {"arrowstyle": "-|>,head_width=0.22,head_length=0.5", "color": colour, "lw": 1.0,
             "shrinkA": 0, "shrinkB": 0}  # fmt: skip
    axis.annotate("", arc[tip], arc[max(tip - 8, 0)], arrowprops=style, zorder=5)


def _legend(axis: Axes, graph: Graph) -> None:
    """The colours that occur."""
    from matplotlib.lines import Line2D

    rows = [
        (OF_TIMING[name], "-", graph.timings[name]) for name in TIMINGS if name in graph.timings
    ]
    if any(arrow.once for arrow in graph.arrows):
        rows.append((GREY, "--", "transferred once, at initialisation"))
    if any(component.looped for component in graph.components):
        rows.append((LOOP, "-", "algebraic loop, to be solved"))
    handles = [Line2D([], [], color=c, ls=ls, lw=1.6, label=text) for c, ls, text in rows]
    if handles:
        title = f"inputs during a step, algorithm {graph.algorithm}"
        axis.legend(handles=handles, title=title, loc="upper center", bbox_to_anchor=(0.5, 0.0),
                    frameon=False, fontsize=7.5, title_fontsize=7.5, labelcolor=INK)  # fmt: skip
