"""A model in space as a schematic, and as the frames of a film, seen from ahead, above, the right.

Parallel projection; what is nearer covers what is farther away.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.drawing.labels import Labels, shortened
from m4e_fmi.report.drawing.space.solids import FACES, Floats, Poses, Solids
from m4e_fmi.report.drawing.style import BODY_COLOURS, FORCE, GREY, INK, PAPER, pale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TURN, RISE = np.radians(-60.0), np.radians(22.0)
"""Where the eye is: about Z from +X, and above the X–Y plane."""
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

    def depth(self, points: Floats) -> float:
        """How far away `points` (…, 3) [m] are, on average [m]."""
        return float(np.mean(points @ self.ahead))


def colour(body: int) -> str:
    """The colour of a body by its index."""
    return BODY_COLOURS[body % len(BODY_COLOURS)]


def extent(shown: Solids, poses: Poses) -> tuple[Floats, Floats]:
    """Lower and upper corner, (3,) each [m], of all that is ever seen."""
    ground = [np.zeros((1, 3)), *(np.array([s.at]) for s in shown.points.values() if s.body < 0)]
    seen = [np.concatenate(ground)]
    for frame in range(0, len(poses.places), max(1, len(poses.places) // 200)):
        for body, box in enumerate(shown.boxes):
            corners = np.vstack([box, *(np.array([end]) for end in shown.sticks[body])])
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
    _prepare(axis, low, high)
    _paint(axis, shown, poses, 0, view)
    if named:
        figure.suptitle(shortened(shown.title), x=0.02, ha="left", fontsize=11, color=INK,
                        fontweight="bold")  # fmt: skip
        _axes(axis, view, low, high)
        labels = Labels(axis)
        for body, name in list(enumerate(shown.bodies))[:MOST_NAMES]:
            at = view.flat(poses.places[0, body])
            labels.add(f"{body + 1} {name}", at, colour(body), bold=True)
            labels.avoid(view.flat(poses.all_of(body, shown.boxes[body])))
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
        _prepare(axis, low, high)
        _paint(axis, shown, poses, frame, view)
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


def _prepare(axis: Axes, low: Floats, high: Floats) -> None:
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axis.axis("off")


def _paint(axis: Axes, shown: Solids, poses: Poses, frame: int, view: View) -> None:
    """All bodies, joints and loads, the farthest first."""
    from matplotlib.patches import Polygon

    parts: list[tuple[float, str, Floats, str]] = []
    for body, box in enumerate(shown.boxes):
        corners = poses.all_of(body, box, frame)
        for face in FACES:
            side = corners[list(face)]
            parts.append((view.depth(side), "face", side, colour(body)))
        for end in shown.sticks[body]:
            line = np.array(
                [poses.places[frame, body], poses.all_of(body, np.array([end]), frame)[0]]
            )
            parts.append((view.depth(line), "stick", line, colour(body)))
    for rope in shown.ropes:
        line = np.array([poses.of(spot, frame) for spot in rope.ends])
        parts.append((view.depth(line), "rope", line, FORCE))
    for hinge in shown.hinges:
        at = poses.of(hinge.spot, frame)[None]
        parts.append((-np.inf, "hinge", at, INK))  # never covered
    for k, (_, kind, points, hue) in enumerate(sorted(parts, key=lambda part: -part[0])):
        order = 5 + 5 * k / len(parts)  # below the names
        flat = view.flat(points)
        if kind == "face":
            axis.add_patch(Polygon(flat, facecolor=pale(hue), edgecolor=hue, lw=0.8, alpha=0.85,
                                   zorder=order))  # fmt: skip
        elif kind == "hinge":
            axis.plot(*flat.T, "o", ms=5, mfc=PAPER, mec=INK, mew=1.0, zorder=order)
        else:
            axis.plot(*flat.T, color=hue, lw=2.2 if kind == "stick" else 1.2,
                      zorder=order)  # fmt: skip


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
