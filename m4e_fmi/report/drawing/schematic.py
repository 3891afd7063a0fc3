"""A model at its start as a drawing: bodies, joints, points, springs, dampers, forces, ground.

After figure 2 of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody".
"""

from __future__ import annotations

import textwrap
from collections.abc import Hashable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from m4e_fmi.model import Model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.report.drawing import symbols
from m4e_fmi.report.drawing.labels import Labels, shortened
from m4e_fmi.report.drawing.parts import (
    JOINT,
    colour_of,
    direction_of,
    ground_lines,
    guides,
    ranks,
    tie_lines,
)
from m4e_fmi.report.drawing.scene import PlanarScene, placed, planar_scene
from m4e_fmi.report.drawing.style import BODY_COLOURS, FORCE, GREY, GRID, INK, PAPER, pale, save
from m4e_fmi.report.drawing.views import space_figure, start_poses

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LARGEST = (8.5, 7.0)  # inches
MOST_LINES = 6  # of the description
MOST_NAMES = 24  # bodies that are named; of more, only the numbers are written
LEAST_RATIO = 0.62  # of the shorter to the longer side


def draw_model(model: Model, picture: str | Path, *, program: Program | None = None) -> Path:
    """Draw `model` in its start pose to `picture` (PNG, SVG or PDF, by its suffix).

    The start pose is that of `program`, the model's own if none is given.
    """
    return save(model_figure(model, program=program), picture, margin=0.15)


def model_figure(model: Model, *, program: Program | None = None) -> Figure:
    """The same as a figure of matplotlib, to be shown or changed."""
    from matplotlib.figure import Figure

    if model.dimensions == 3:
        from m4e_fmi.report.animation.of_model import scene_of_model

        scene = scene_of_model(model)
        poses = start_poses(scene, program or model_program(model))
        return space_figure(scene, poses, inches=LARGEST[1])
    shown = planar_scene(model, program)
    low, high = _limits(shown)
    scale = min(np.array(LARGEST) / (high - low))
    figure = Figure(figsize=tuple(scale * (high - low)), layout="constrained")
    axis = figure.subplots()
    axis.set_aspect("equal")
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    _frame(axis)
    width = int(13 * scale * (high - low)[0])
    lines = textwrap.wrap(shown.description, width, max_lines=MOST_LINES, placeholder=" …")
    title = axis.set_title("\n".join(lines), fontsize=9, loc="left", color=GREY)
    title.set_linespacing(1.25)
    axis.annotate(
        shortened(shown.title), (0, 1), (0, 8 + 11.5 * len(lines)), xycoords=axis.transAxes,
        textcoords="offset points", fontsize=12, fontweight="bold", color=INK,
    )  # fmt: skip
    labels = Labels(axis)
    Drawing(axis, shown, labels).everything()
    labels.place()
    return figure


def _limits(shown: PlanarScene) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the picture [m]: room for names, and neither side much longer than the other."""
    low, high = shown.extent
    margin = 0.14 * shown.diagonal
    low, high = low - margin, high + margin
    sides = high - low
    missing = np.maximum(0, sides.max() * LEAST_RATIO - sides) / 2
    return low - missing, high + missing


def _frame(axis: Axes) -> None:
    axis.grid(color=GRID, lw=0.6)
    axis.set_axisbelow(True)
    axis.tick_params(labelsize=8, colors=GREY, length=0)
    axis.set_xlabel("X [m]", fontsize=9, color=GREY)
    axis.set_ylabel("Z [m]", fontsize=9, color=GREY)
    for side in axis.spines.values():
        side.set_visible(False)


class Drawing:
    """The parts of a scene on an axis; `size` is the length that symbols are scaled by [m]."""

    def __init__(self, axis: Any, shown: PlanarScene, labels: Labels) -> None:
        self.axis, self.scene, self.labels, self.size = axis, shown, labels, shown.size
        self.body_radius = 0.02 * self.size
        self.joint_radius = JOINT * self.size

    def everything(self) -> None:
        """Bodies, joints, loads, forces, points, axes and gravity."""
        self._ground()
        self._ties()
        self._bodies()
        self._joints()
        self._pushes()  # before points, because fewer places are near an arrow's tip
        self._points()
        self._axes_and_gravity()

    def _line(self, points: np.ndarray, colour: str, width: float = 1.2, **more: Any) -> None:
        self.axis.plot(*points.T, color=colour, lw=width, solid_capstyle="round", **more)

    def _fill(
        self, points: np.ndarray, face: object, edge: str, order: float, lw: float = 1.2
    ) -> None:
        from matplotlib.patches import Polygon

        self.axis.add_patch(Polygon(points, closed=True, fc=face, ec=edge, lw=lw, zorder=order))

    def _ground(self) -> None:
        for line in ground_lines(self.scene, self.size):
            self._line(line, GREY, 1.0, zorder=1)
            self.labels.avoid(line)

    def _bodies(self) -> None:
        for k, name in enumerate(self.scene.bodies):
            colour = BODY_COLOURS[k % len(BODY_COLOURS)]
            outline = placed(self.scene.outline(k, self.body_radius), self.scene.start[k])
            order = 3 + 0.1 * self.scene.depths[k]
            self._fill(outline, (*pale(colour), 0.9), colour, order)
            centre = self.scene.start[k, :2]
            self._centre(centre, colour)
            label = f"{k + 1} {name}" if len(self.scene.bodies) <= MOST_NAMES else f"{k + 1}"
            self.labels.add(label, centre, colour, bold=True)
            self.labels.avoid(outline)

    def _centre(self, at: np.ndarray, colour: str) -> None:
        """The mark of a centre of gravity: a disc with two dark quarters."""
        radius = 0.75 * self.joint_radius
        self._fill(symbols.circle(at, radius), PAPER, colour, 6, lw=0.8)
        for first in (0.0, np.pi):
            quarter = symbols.arc(at, radius, first, first + np.pi / 2)
            self._fill(np.vstack([quarter, np.asarray(at)[None]]), colour, colour, 6, lw=0.3)

    def _joints(self) -> None:
        for joint in self.scene.joints:
            at = self.scene.place(joint.child)
            if joint.type.symbol == "circle":
                self._fill(symbols.circle(at, self.joint_radius), PAPER, INK, 7)
            elif joint.type.symbol == "square":
                side = 1.7 * self.joint_radius
                self._fill(symbols.box(at, side, side, (1, 0)), INK, INK, 7)
            elif joint.type.symbol == "sleeve":
                direction = direction_of(joint, self.scene)
                reach = 0.06 * self.size * direction
                self._line(np.array([at - reach, at + reach]), INK, 0.9, ls=(0, (5, 2, 1, 2)),
                           zorder=6)  # fmt: skip
                sleeve = symbols.box(at, 4.2 * self.joint_radius, 2 * self.joint_radius, direction)
                self._fill(sleeve, PAPER, INK, 7)
        for line in guides(self.scene):
            self._line(line, INK, 0.8, ls=":", zorder=2)

    def _points(self) -> None:
        for name, anchor in self.scene.points.items():
            at = self.scene.place(anchor)
            self.axis.plot([at[0]], [at[1]], "o", ms=2.6, color=INK, zorder=8)
            self.labels.add(name, at, GREY)

    def _ties(self) -> None:
        ties = [(tie.kind, frozenset[Hashable](tie.ends)) for tie in self.scene.ties]
        for tie, rank in zip(self.scene.ties, ranks(ties), strict=True):
            ends = sorted(tie.ends, key=lambda end: (end.body, end.at))
            places = np.array([self.scene.place(end) for end in ends])
            for line in tie_lines(tie.kind, places, rank, self.size):
                self._line(line, colour_of(tie.kind), 1.1, zorder=5)
                self.labels.avoid(line)

    def _pushes(self) -> None:
        for push in self.scene.pushes:
            at = self.scene.place(push.at)
            if push.direction is None:
                line = symbols.arc(at, 2.6 * self.joint_radius, -0.6, 3.6)[::-1]
                self._line(line, FORCE, 1.6, zorder=9)
                self._arrow(line[-2], line[-1], FORCE)
                self.labels.add(push.name, line[20], FORCE)
                self.labels.avoid(line)
                continue
            tip = at + 0.11 * self.scene.diagonal * np.array(push.direction)
            self._arrow(at, tip, FORCE)
            self.labels.add(push.name, tip, FORCE)
            self.labels.avoid(np.array([at, tip]))

    def _arrow(self, start: np.ndarray, end: np.ndarray, colour: str, width: float = 1.8) -> None:
        style = {"arrowstyle": "-|>,head_width=0.22,head_length=0.45", "color": colour,
                 "lw": width, "shrinkA": 0, "shrinkB": 0}  # fmt: skip
        self.axis.annotate("", end, start, arrowprops=style, zorder=9, annotation_clip=False)

    def _axes_and_gravity(self) -> None:
        """World axes at the origin if it is in sight, in the lower left corner else; gravity."""
        (left, right), (low, high) = self.axis.get_xlim(), self.axis.get_ylim()
        reach = 0.07 * self.scene.diagonal
        origin = np.array([left + 0.03 * (right - left), low + 0.03 * (high - low)])
        for direction, name in (((1, 0), "X"), ((0, 1), "Z")):
            tip = origin + reach * np.array(direction)
            self._arrow(origin, tip, INK, 1.2)
            place = tip + 0.018 * self.scene.diagonal * np.array(direction)
            self.axis.annotate(name, place, color=INK, fontsize=8, ha="center", va="center")
        if self.scene.gravity:
            down = np.array([0, -np.sign(self.scene.gravity)])
            top = np.array([right - 0.04 * (right - left), high - 0.03 * (high - low)])
            self._arrow(top, top + reach * down, INK, 1.6)
            self.axis.annotate("g", top + 1.35 * reach * down, color=INK, fontsize=9,
                               style="italic", ha="center", va="center")  # fmt: skip
