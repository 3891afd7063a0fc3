"""Components and what leads from one to another, as a small SVG in the colours of the notebook."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from m4e_fmi.notebook.sheet import text
from m4e_fmi.report.drawing.system_graph import layout

SCALE = (58.0, 46.0)
"""Pixels of an inch of the layout."""
HEIGHT = 30.0
LETTER, LONGEST = 7.4, 22
"""Width of a letter [pixels], and the most letters of a name."""
MOST_NODES = 40
HEAD, HALF = 9.0, 3.6
"""Length and half the width of an arrow's head."""


def graph(names: Sequence[str], edges: Mapping[tuple[str, str], int]) -> str:
    """The SVG of the components `names`; an arrow of an edge says how many connections it has."""
    if not names:
        return ""
    found = layout(names, [pair for pair in edges if pair[0] != pair[1]])
    widths = {name: LETTER * min(len(name), LONGEST) + 18 for name in names}
    places = {name: (x * SCALE[0], -y * SCALE[1]) for name, (x, y) in found.items()}
    left = min(x - widths[name] / 2 for name, (x, _) in places.items()) - 4
    right = max(x + widths[name] / 2 for name, (x, _) in places.items()) + 4
    top = min(y for _, y in places.values()) - HEIGHT / 2 - 4
    bottom = max(y for _, y in places.values()) + HEIGHT / 2 + 4
    drawn = [_edge(a, b, edges, places, widths) for a, b in edges if a != b]
    boxes = [_box(name, *places[name], widths[name]) for name in names]
    width, height = right - left, bottom - top
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" width="{width:.0f}" '
        f'height="{height:.0f}" viewBox="{left:.1f} {top:.1f} {width:.1f} {height:.1f}" '
        f'fill="none" stroke="currentColor">{"".join(drawn)}{"".join(boxes)}</svg>'
    )


def _box(name: str, x: float, y: float, width: float) -> str:
    shown = name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"
    return (
        f'<g><title>{text(name)}</title><rect x="{x - width / 2:.1f}" y="{y - HEIGHT / 2:.1f}" '
        f'width="{width:.1f}" height="{HEIGHT:.0f}" rx="5" fill="rgba(128,128,128,.15)"/>'
        f'<text x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle" font-size="12" '
        f'font-family="sans-serif" fill="currentColor" stroke="none">{text(shown)}</text></g>'
    )


def _edge(
    a: str,
    b: str,
    edges: Mapping[tuple[str, str], int],
    places: Mapping[str, tuple[float, float]],
    widths: Mapping[str, float],
) -> str:
    """An arrow from the box of `a` to that of `b`, beside that which leads back."""
    (x0, y0), (x1, y1) = places[a], places[b]
    length = math.hypot(x1 - x0, y1 - y0) or 1.0
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    aside = 4.0 if (b, a) in edges else 0.0
    x0, y0, x1, y1 = x0 - aside * uy, y0 + aside * ux, x1 - aside * uy, y1 + aside * ux
    out, into = _inside(ux, uy, widths[a]), _inside(ux, uy, widths[b])
    x0, y0, x1, y1 = x0 + out * ux, y0 + out * uy, x1 - into * ux, y1 - into * uy
    bx, by = x1 - HEAD * ux, y1 - HEAD * uy
    head = " ".join(
        f"{x:.1f},{y:.1f}"
        for x, y in ((x1, y1), (bx - HALF * uy, by + HALF * ux), (bx + HALF * uy, by - HALF * ux))
    )
    count = edges[(a, b)]
    told = f"{a} → {b}: {count} connection{'s' * (count > 1)}"
    return (
        f'<g opacity=".7"><title>{text(told)}</title>'
        f'<path d="M{x0:.1f} {y0:.1f}L{bx:.1f} {by:.1f}"/>'
        f'<polygon points="{head}" fill="currentColor" stroke="none"/></g>'
    )


def _inside(ux: float, uy: float, width: float) -> float:
    """Length of a ray from the middle of a box to its edge, in pixels."""
    across = width / 2 / abs(ux) if abs(ux) > 1e-9 else math.inf
    down = HEIGHT / 2 / abs(uy) if abs(uy) > 1e-9 else math.inf
    return min(across, down) + 2.0
