"""A model at its start as a drawing: bodies, joints, points, springs, dampers, forces, ground.

After figure 2 of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody".
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.model import Model
from m4e_fmi.program import Program
from m4e_fmi.report import symbols
from m4e_fmi.report.figures import COLOURS, DOTS_PER_INCH
from m4e_fmi.report.labels import Labels
from m4e_fmi.report.scene import GROUND_INDEX, Scene, Tie, scene, turned

INK, GREY, PAPER = "#22303c", "#7b8794", "#ffffff"
SPRING, DAMPER, FORCE = "#2a7f62", "#7a4fa3", "#c8322b"
LARGEST = (9.0, 7.5)  # inches


def draw_model(model: Model, picture: Path, *, program: Program | None = None) -> Path:
    """Draw `model` in its start pose to `picture` (PNG, SVG or PDF, by its suffix).

    The start pose is that of `program`, the model's own if none is given.
    """
    from matplotlib.figure import Figure

    shown = scene(model, program)
    poses = shown.start
    low, high = shown.extent(poses[None])
    size = shown.size(poses[None])
    margin = 0.14 * size
    low, high = low - margin, high + margin
    width, height = high - low
    scale = min(LARGEST[0] / width, LARGEST[1] / height)
    figure = Figure(figsize=(max(4.5, scale * width), max(3.2, scale * height) + 0.4),
                    layout="constrained")  # fmt: skip
    axis = figure.subplots()
    axis.set_aspect("equal")
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    axis.set_title(shown.title, fontsize=11, loc="left", fontweight="bold", color=INK)
    _frame(axis)
    labels = Labels(axis)
    Drawing(axis, shown, poses, size, labels).everything()
    labels.place()
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=DOTS_PER_INCH)
    return picture


def _frame(axis: Any) -> None:
    axis.grid(color="#eceff2", lw=0.6)
    axis.set_axisbelow(True)
    axis.tick_params(labelsize=8, colors=GREY, length=0)
    axis.set_xlabel("X [m]", fontsize=9, color=GREY)
    axis.set_ylabel("Z [m]", fontsize=9, color=GREY)
    for side in axis.spines.values():
        side.set_visible(False)


class Drawing:
    """The parts of a scene on an axis; `size` is the length that symbols are scaled by [m]."""

    def __init__(
        self, axis: Any, shown: Scene, poses: np.ndarray, size: float, labels: Labels
    ) -> None:
        self.axis, self.scene, self.poses, self.labels = axis, shown, poses, labels
        self.size = size
        self.body_radius = 0.02 * size
        self.joint_radius = 0.0085 * size

    def everything(self) -> None:
        self._ground()
        self._ties()
        self._bodies()
        self._joints()
        self._points()
        self._pushes()
        self._axes_and_gravity()

    def _line(self, points: np.ndarray, colour: str, width: float = 1.2, **more: Any) -> None:
        self.axis.plot(*points.T, color=colour, lw=width, solid_capstyle="round", **more)

    def _fill(
        self, points: np.ndarray, face: Any, edge: str, order: float, lw: float = 1.2
    ) -> None:
        from matplotlib.patches import Polygon

        self.axis.add_patch(Polygon(points, closed=True, fc=face, ec=edge, lw=lw, zorder=order))

    def _ground(self) -> None:
        rails = {j.parent.at: j.direction for j in self.scene.joints
                 if j.type == "prismatic" and j.parent.body == GROUND_INDEX}  # fmt: skip
        for at in self.scene.fixed:
            direction = rails.get(at) or (1.0, 0.0)
            width = 0.3 * self.size if at in rails else 0.075 * self.size
            for line in symbols.ground(at, width, direction=direction):
                self._line(line, GREY, 1.0, zorder=1)

    def _bodies(self) -> None:
        from matplotlib.colors import to_rgb

        for k, (name, attached) in enumerate(
            zip(self.scene.bodies, self.scene.attachments, strict=True)
        ):
            colour = COLOURS[k % len(COLOURS)]
            outline = symbols.rounded_hull(attached, self.body_radius)
            x, z, theta = self.poses[k]
            placed = np.array([turned(tuple(p), theta) for p in outline]) + (x, z)
            pale = tuple(0.28 * c + 0.72 for c in to_rgb(colour))
            self._fill(placed, (*pale, 0.92), colour, 3)
            self._centre((x, z), colour)
            self.labels.add(f"{k + 1} {name}", (x, z), colour, bold=True)
            self.labels.avoid(placed)

    def _centre(self, at: Any, colour: str) -> None:
        """The mark of a centre of gravity: a disc with two dark quarters."""
        radius = 0.75 * self.joint_radius
        self._fill(symbols.circle(at, radius), PAPER, colour, 6, lw=0.8)
        for first in (0.0, np.pi):
            quarter = symbols.arc(at, radius, first, first + np.pi / 2)
            self._fill(np.vstack([quarter, np.asarray(at)[None]]), colour, colour, 6, lw=0.3)

    def _joints(self) -> None:
        for joint in self.scene.joints:
            at = self.scene.place(joint.child, self.poses)
            base = self.scene.place(joint.parent, self.poses)
            if joint.type == "revolute":
                self._fill(symbols.circle(at, self.joint_radius), PAPER, INK, 7)
            elif joint.type == "fixed":
                side = 1.7 * self.joint_radius
                self._fill(symbols.box(at, side, side, (1, 0)), INK, INK, 7)
            elif joint.type == "prismatic":
                turn = self.poses[joint.parent.body, 2] if joint.parent.body >= 0 else 0.0
                direction = turned(joint.direction or (1.0, 0.0), turn)
                reach = 0.06 * self.size * direction
                self._line(np.array([at - reach, at + reach]), INK, 0.9, ls=(0, (5, 2, 1, 2)),
                           zorder=6)  # fmt: skip
                sleeve = symbols.box(at, 4.2 * self.joint_radius, 2 * self.joint_radius, direction)
                self._fill(sleeve, PAPER, INK, 7)
                if np.linalg.norm(at - base) > 1e-9 * self.size:
                    self._line(np.array([base, at]), INK, 0.8, ls=":", zorder=2)

    def _points(self) -> None:
        for name, anchor in self.scene.points.items():
            at = self.scene.place(anchor, self.poses)
            self.axis.plot(*at, "o", ms=2.6, color=INK, zorder=8)
            self.labels.add(name, at, GREY)

    def _ties(self) -> None:
        beside: dict[tuple, int] = {}
        for tie in self.scene.ties:
            ends = tuple(tuple(self.scene.place(end, self.poses).round(9)) for end in tie.ends)
            key = tuple(sorted(ends))
            order = beside.get(key, 0)
            beside[key] = order + 1
            if tie.kind.startswith("torsion") or ends[0] == ends[1]:
                self._torsion(tie, np.array(ends), order)
            else:
                self._tension(tie, np.array(ends), order)

    def _tension(self, tie: Tie, ends: np.ndarray, order: int) -> None:
        width = 0.024 * self.size
        aside = (0, 1.4, -1.4, 2.8, -2.8)[order % 5] * width
        start, end = symbols.moved_aside(*ends, aside)
        for a, b in ((ends[0], start), (end, ends[1])):
            self._line(np.array([a, b]), GREY, 0.7, zorder=2)
        if tie.kind == "tension_spring":
            self._line(symbols.spring(start, end, width), SPRING, 1.1, zorder=4)
        elif tie.kind == "tension_damper":
            for line in symbols.damper(start, end, width):
                self._line(line, DAMPER, 1.1, zorder=4)
        else:
            self._line(np.array([start, end]), GREY, 1.1, ls="--", zorder=4)

    def _torsion(self, tie: Tie, ends: np.ndarray, order: int) -> None:
        if not np.allclose(*ends):
            self._line(ends, SPRING if "spring" in tie.kind else DAMPER, 0.8, ls=":", zorder=4)
        centre = ends.mean(axis=0)
        inner = (1.5 + 1.1 * order) * self.joint_radius
        if tie.kind == "torsion_spring":
            self._line(symbols.spiral(centre, inner, inner + 1.3 * self.joint_radius), SPRING, 1.1,
                       zorder=5)  # fmt: skip
            return
        radius = inner + 0.9 * self.joint_radius
        self._line(symbols.arc(centre, radius, -2.6, -0.2), DAMPER, 1.1, zorder=5)
        tip = symbols.arc(centre, radius, -1.4, -1.4)[0]
        radial = (tip - centre) / radius
        w = 0.7 * self.joint_radius
        self._line(np.array([tip - w * radial, tip + w * radial]), DAMPER, 2.2, zorder=5)

    def _pushes(self) -> None:
        for push in self.scene.pushes:
            at = self.scene.place(push.at, self.poses)
            if push.direction is None:
                line = symbols.arc(at, 2.6 * self.joint_radius, -0.6, 3.6)[::-1]
                self._line(line, FORCE, 1.6, zorder=9)
                self._arrow(line[-2], line[-1], FORCE)
                self.labels.add(push.name, line[20], FORCE)
                continue
            tip = at + 0.11 * self.size * np.array(push.direction)
            self._arrow(at, tip, FORCE)
            self.labels.add(push.name, tip, FORCE)

    def _arrow(self, start: Any, end: Any, colour: str, width: float = 1.8) -> None:
        style = {"arrowstyle": "-|>,head_width=0.22,head_length=0.45", "color": colour,
                 "lw": width, "shrinkA": 0, "shrinkB": 0}  # fmt: skip
        self.axis.annotate("", end, start, arrowprops=style, zorder=9, annotation_clip=False)

    def _axes_and_gravity(self) -> None:
        """World axes at the origin if it is in sight, in the lower left corner else; gravity."""
        (left, right), (low, high) = self.axis.get_xlim(), self.axis.get_ylim()
        reach = 0.07 * self.size
        origin = np.array([left + 0.03 * (right - left), low + 0.03 * (high - low)])
        for direction, name in (((1, 0), "X"), ((0, 1), "Z")):
            tip = origin + reach * np.array(direction)
            self._arrow(origin, tip, INK, 1.2)
            self.axis.annotate(name, tip + 0.018 * self.size * np.array(direction), color=INK,
                               fontsize=8, ha="center", va="center")  # fmt: skip
        if self.scene.gravity:
            down = np.array([0, -np.sign(self.scene.gravity)])
            top = np.array([right - 0.04 * (right - left), high - 0.03 * (high - low)])
            self._arrow(top, top + reach * down, INK, 1.6)
            self.axis.annotate("g", top + 1.35 * reach * down, color=INK, fontsize=9,
                               style="italic", ha="center", va="center")  # fmt: skip
