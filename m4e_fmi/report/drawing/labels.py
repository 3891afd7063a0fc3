"""Names in a drawing, put where they cover as little as possible."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Box = tuple[np.ndarray, np.ndarray]
HALO = 2.4  # points of white around a name
DISTANCES = (7.0, 13.0, 21.0, 25.0)  # points from the place to the name
LONGEST = 40  # characters of a name that are drawn


def shortened(name: str) -> str:
    """`name` without its middle if it is longer than `LONGEST`: pictures have no room for it."""
    half = LONGEST // 2 - 1
    return name if len(name) <= LONGEST else f"{name[:half]}…{name[-half:]}"


@dataclass(frozen=True)
class _Name:
    text: str
    at: tuple[float, float]
    colour: str
    bold: bool


class Labels:
    """Collects names and what they must not cover, then places them one after the other."""

    def __init__(self, axis: Any) -> None:
        self.axis = axis
        self.names: list[_Name] = []
        self.outlines: list[np.ndarray] = []

    def add(self, text: str, at: np.ndarray, colour: str, *, bold: bool = False) -> None:
        """Write `text` near `at` (2,) [m]."""
        self.names.append(_Name(text, (float(at[0]), float(at[1])), colour, bold))

    def avoid(self, outline: np.ndarray) -> None:
        """Do not cover `outline` (n, 2) [m], if there is another place."""
        self.outlines.append(outline)

    def place(self) -> None:
        """Write all names, bold ones first."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.patheffects import withStroke

        figure = self.axis.figure
        renderer = FigureCanvasAgg(figure).get_renderer()
        figure.draw_without_rendering()  # the layout settles, so that points become pixels
        pixels = figure.dpi / 72
        lines = [_dense(self.axis.transData.transform(o), 6 * pixels) for o in self.outlines]
        places = self.axis.transData.transform(np.reshape([n.at for n in self.names], (-1, 2)))
        obstacles = np.vstack([*lines, places])
        inside = self.axis.get_window_extent(renderer)
        taken: list[Box] = []
        for name in sorted(self.names, key=lambda n: not n.bold):
            written = self.axis.annotate(
                name.text, name.at, (0, 0), textcoords="offset points", color=name.colour,
                fontsize=8.5 if name.bold else 6.5, fontweight="bold" if name.bold else "normal",
                zorder=12 if name.bold else 11, annotation_clip=False,
                path_effects=[withStroke(linewidth=HALO, foreground="white")],
            )  # fmt: skip
            extent = written.get_window_extent(renderer)
            half = np.array([extent.width, extent.height]) / 2
            centre = self.axis.transData.transform(name.at)
            best, least = (0.0, 0.0), np.inf
            for far, distance in enumerate(DISTANCES):
                for angle in np.arange(0, 2 * np.pi, np.pi / 6):
                    way = np.array([np.cos(angle), np.sin(angle)])
                    middle = centre + pixels * distance * way + half * way
                    low, high = middle - half, middle + half
                    cost = 0.8 * far + covering(low, high, obstacles, taken)
                    cost += 50 * (low < inside.min).any() + 50 * (high > inside.max).any()
                    cost += 4 * _is_nearer_to_another(middle, centre, places)
                    if cost < least - 1e-9:
                        best, least = tuple((low - centre) / pixels), cost
            written.set_position(best)
            taken.append(
                (centre + pixels * np.array(best), centre + pixels * np.array(best) + 2 * half)
            )


def covering(low: np.ndarray, high: np.ndarray, obstacles: np.ndarray, taken: list[Box]) -> float:
    """How much a box covers: names count most, points of lines less.

    `low` and `high` are the box's corners (2,), `obstacles` the points (n, 2), and `taken` the
    corners (2,) of each name, all in pixel units.
    """
    covered = ((obstacles > low - 2) & (obstacles < high + 2)).all(axis=1).sum()
    overlaps = sum(bool((low < b + 1).all() and (high > a - 1).all()) for a, b in taken)
    return 1.2 * min(float(covered), 12) + 25 * overlaps


def _is_nearer_to_another(middle: np.ndarray, own: np.ndarray, places: np.ndarray) -> bool:
    apart = np.hypot(*(places - own).T) > 1
    distances = np.hypot(*(places[apart] - middle).T)
    return bool(len(distances) and distances.min() < np.hypot(*(own - middle)))


def _dense(outline: np.ndarray, step: float) -> np.ndarray:
    """Points along a closed line, at most `step` apart."""
    ends = np.roll(outline, -1, axis=0)
    pieces = [
        a
        + np.linspace(0, 1, max(1, int(np.hypot(*(b - a)) / step)), endpoint=False)[:, None]
        * (b - a)
        for a, b in zip(outline, ends, strict=True)
    ]
    return np.vstack(pieces)
