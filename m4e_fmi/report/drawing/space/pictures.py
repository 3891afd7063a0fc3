"""A model in space as a schematic, and as the frames of a film, seen from ahead, above, the right.

Parallel projection; what is nearer covers what is farther away.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import Labels, shortened
from m4e_fmi.report.drawing.space.hinges import GROUND
from m4e_fmi.report.drawing.space.solids import Floats, Poses, Solids
from m4e_fmi.report.drawing.style import BODY_COLOURS, FORCE, GREY, INK, PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TURN, RISE = np.radians(-60.0), np.radians(22.0)
"""Where the eye is: about Z from +X, and above the X–Y plane."""
PALEST, DARKEST = 0.28, 0.65
"""Share of a body's colour, the rest being white, in faces seen from ahead and from the side."""
NONE = np.zeros(4)  # no colour
MOST_NAMES = 24  # bodies that are named


@dataclass(frozen=True)
class View:
    """A parallel projection: `right` and `up` on the paper and `ahead` into it, in world axes."""

    right: Floats
    up: Floats
    ahead: Floats

    @classmethod
    def of(cls, turn: float = TURN, rise: float = RISE) -> View:
        """From an eye `turn` about Z from +X and `rise` above the X–Y plane [rad]."""
        eye = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        return cls(right, np.cross(eye, right), -eye)

    def flat(self, points: Floats) -> Floats:
        """On the paper, (…, 2) [m], what are `points` (…, 3) [m] in the world."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)

    def facing(self, sides: Floats) -> Floats:
        """Cosines (F,) [1] between the line of sight and the normals of `sides` (F, k, 3) [m]."""
        last = -1 if sides.shape[1] > 3 else 0
        normals = np.cross(sides[:, 2] - sides[:, 0], sides[:, last] - sides[:, 1])
        sizes = np.linalg.norm(normals, axis=1)
        return np.abs(normals @ self.ahead) / np.where(sizes > 0, sizes, 1.0)


def colour(body: int) -> str:
    """The colour of a body by its index."""
    return BODY_COLOURS[body % len(BODY_COLOURS)]


def shaded(hue: Floats, facing: Floats) -> Floats:
    """Colours (F, 4) [1] of faces of `hue` (4,) [1]; darker where `facing` (F,) [1] is small."""
    shares = PALEST + (DARKEST - PALEST) * (1.0 - facing)
    return 1.0 - shares[:, None] * (1.0 - hue)


def extent(shown: Solids, poses: Poses) -> tuple[Floats, Floats]:
    """Lower and upper corner, (3,) each [m], of all that is ever seen."""
    ground = [np.zeros((1, 3)), *(np.array([s.at]) for s in shown.points.values() if s.body < 0)]
    seen = [np.concatenate(ground)]
    for frame in range(0, len(poses.places), max(1, len(poses.places) // 200)):
        for body, hull in enumerate(shown.hulls):
            corners = np.vstack([hull.vertices, *(np.array([end]) for end in shown.sticks[body])])
            seen.append(poses.all_of(body, corners, frame))
    everything = np.concatenate(seen)
    return everything.min(axis=0), everything.max(axis=0)


def space_figure(shown: Solids, poses: Poses, *, inches: float, named: bool) -> Figure:
    """The model in one pose, its longer side `inches` long; with names, or as an icon."""
    from matplotlib.figure import Figure

    view = View.of()
    low, high = _limits(shown, poses, view)
    sides = np.maximum((high - low) / max(high - low), 0.4 if named else 1.0) * inches
    figure = Figure(figsize=(sides[0], sides[1]), facecolor=PAPER)
    axis = figure.add_axes((0, 0, 1, 1))
    prepare(axis, low, high)
    paint(axis, shown, poses, 0, view)
    if named:
        figure.suptitle(shortened(shown.title), x=0.02, ha="left", fontsize=11, color=INK,
                        fontweight="bold")  # fmt: skip
        _axes(axis, view, low, high)
        labels = Labels(axis)
        for body, name in list(enumerate(shown.bodies))[:MOST_NAMES]:
            at = view.flat(poses.places[0, body])
            labels.add(f"{body + 1} {name}", at, colour(body), bold=True)
            labels.avoid(view.flat(poses.all_of(body, shown.hulls[body].vertices)))
        labels.place()
    return figure


def space_frames(shown: Solids, times: Floats, poses: Poses, pixels: int) -> Iterator[np.ndarray]:
    """Every frame, at `times` (T,) [s], as an array of bytes (height, width, 3) [1]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    view = View.of()
    low, high = _limits(shown, poses, view)
    inches = np.maximum((high - low) / max(high - low), 0.4) * pixels / 100 + (0.0, 0.35)
    figure = Figure(figsize=(inches[0], inches[1]), dpi=100, facecolor=PAPER)
    canvas = FigureCanvasAgg(figure)
    axis = figure.add_axes((0, 0, 1, 1 - 0.35 / inches[1]))
    top = 1 - 0.2 / inches[1]
    figure.text(0.02, top, shortened(shown.title), fontsize=11, va="center", color=INK)
    clock = figure.text(0.98, top, "", fontsize=10, ha="right", va="center", color=GREY)
    for frame, time in enumerate(times):
        axis.clear()
        prepare(axis, low, high)
        paint(axis, shown, poses, frame, view)
        _axes(axis, view, low, high)
        clock.set_text(f"{time:.2f} s")
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _limits(shown: Solids, poses: Poses, view: View) -> tuple[Floats, Floats]:
    low, high = extent(shown, poses)
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                        for z in (low[2], high[2])])  # fmt: skip
    flat = view.flat(corners)
    margin = 0.1 * float(np.ptp(flat, axis=0).max() or 1.0)
    return flat.min(axis=0) - margin, flat.max(axis=0) + margin


def prepare(axis: Axes, low: Floats, high: Floats) -> None:
    """Set an axis up for what lies between the corners `low` and `high`, (2,) each [m]."""
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axis.axis("off")


def paint(
    axis: Axes, shown: Solids, poses: Poses, frame: int, view: View, *, strength: float = 1.0
) -> None:
    """Draw all bodies, joints and loads, the farthest first; `strength` 1 covers what is behind."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba

    parts: list[_Part] = []
    for body, hull in enumerate(shown.hulls):
        hue = np.array(to_rgba(colour(body)))
        corners = poses.all_of(body, hull.vertices, frame)
        for faces in hull.alike:
            sides = corners[faces]
            shades = shaded(hue, view.facing(sides))
            shades[:, 3] = 0.85 if hull.edged else 1.0
            edges = np.broadcast_to(hue, shades.shape) if hull.edged else shades
            width = 0.6 if hull.edged else 0.3
            parts += [_Part(*of, width) for of in zip(sides, shades, edges, strict=True)]
        for end in shown.sticks[body]:
            tip = poses.all_of(body, np.array([end]), frame)[0]
            parts.append(_Part(np.array([poses.places[frame, body], tip]), NONE, hue, 2.2))
    for rope in shown.ropes:
        line = np.array([poses.of(spot, frame) for spot in rope.ends])
        parts.append(_Part(line, NONE, np.array(to_rgba(FORCE)), 1.2))
    parts.sort(key=lambda part: -float((part.points @ view.ahead).mean()))
    axis.add_collection(
        PolyCollection(
            [view.flat(part.points) for part in parts],
            facecolors=np.array([part.face for part in parts]),
            edgecolors=np.array([part.edge for part in parts]),
            linewidths=[part.width for part in parts],
            alpha=None if strength == 1.0 else strength,
            zorder=5,
        )
    )
    for ends, turns in shown.lines:
        line = view.flat(np.array([poses.of(end, frame) for end in ends]))
        axis.plot(*line.T, color=INK, lw=0.8, ls="-." if turns else "-", zorder=6,
                  alpha=strength)  # fmt: skip
    for hinge in shown.hinges:
        at = view.flat(poses.of(hinge.spot, frame))
        marker = "s" if hinge.symbol == "square" else "o"
        axis.plot(*at, marker, ms=5, mfc=PAPER, mec=INK, mew=1.0, zorder=7, alpha=strength)
    fixed = [spot for rope in shown.ropes for spot in rope.ends if spot.body == GROUND]
    for spot in fixed:
        axis.plot(*view.flat(np.array(spot.at)), "^", ms=5, mfc=GREY, mec=GREY, zorder=7)


@dataclass(frozen=True)
class _Part:
    """A polygon, or a line, of `points` (n, 3) [m]; colours (4,) of its face and its edges."""

    points: Floats
    face: Floats
    edge: Floats
    width: float


def _axes(axis: Axes, view: View, low: Floats, high: Floats) -> None:
    """The axes of the world, in the lower left corner."""
    reach = 0.07 * float(max(high - low))
    origin = low + 1.5 * reach
    for direction, name in zip(np.eye(3), "XYZ", strict=True):
        tip = origin + reach * view.flat(direction)
        axis.plot([origin[0], tip[0]], [origin[1], tip[1]], color=GREY, lw=1.0, zorder=5)
        axis.annotate(
            name,
            (float(tip[0]), float(tip[1])),
            xytext=(2, 2),
            textcoords="offset points",
            fontsize=7,
            color=GREY,
        )
