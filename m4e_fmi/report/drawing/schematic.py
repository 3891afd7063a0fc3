"""A model at its start as a drawing: bodies, joints, points, springs, dampers, ground, names.

After figure 2 of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody".
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.model import BodyForce, JointEffort, Model, PointForce
from m4e_fmi.model.groups import gravity_of
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.report.animation.frames import Poses
from m4e_fmi.report.animation.of_model import CENTRE, Places, places_of, scene_of_model
from m4e_fmi.report.animation.scene import GROUND, Scene, Spot
from m4e_fmi.report.drawing.labels import Labels, shortened
from m4e_fmi.report.drawing.style import FORCE, GREY, GRID, INK, PAPER, save
from m4e_fmi.report.drawing.views import View, colour, draw_ground, limits, paint, start_poses

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
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    program = program or model_program(model)
    values = {v.name: v.start for v in program.parameters}
    scene, places = scene_of_model(model, values=values), places_of(model, values)
    poses = start_poses(scene, program)
    low, high = limits(scene, poses, 0.14)
    missing = np.maximum(0, (high - low).max() * LEAST_RATIO - (high - low)) / 2
    low, high = low - missing, high + missing
    sides = min(np.array(LARGEST) / (high - low)) * (high - low)
    figure = Figure(figsize=tuple(sides), layout="constrained")
    axis = figure.subplots()
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    _frame(axis, scene.planar)
    width = int(13 * sides[0])
    lines = textwrap.wrap(scene.description, width, max_lines=MOST_LINES, placeholder=" …")
    title = axis.set_title("\n".join(lines), fontsize=9, loc="left", color=GREY)
    title.set_linespacing(1.25)
    axis.annotate(
        shortened(scene.title), (0, 1), (0, 8 + 11.5 * len(lines)), xycoords=axis.transAxes,
        textcoords="offset points", fontsize=12, fontweight="bold", color=INK,
    )  # fmt: skip
    paint(axis, scene, poses)
    labels = Labels(axis)
    for drawn in axis.collections:
        if isinstance(drawn, LineCollection):
            for line in drawn.get_segments():
                labels.avoid(np.asarray(line))
    view = View.of(scene.planar)
    _joints(axis, view, places, poses)
    _names(axis, view, scene, poses, labels)
    for name, spot in places.points.items():
        at = view.flat(poses.of(spot))
        axis.plot(*at, "o", ms=2.6, color=INK, zorder=8)
        labels.add(shortened(name), at, GREY)
    for name, spot in _pushed(model, places):
        at = view.flat(poses.of(spot))
        axis.plot(*at, "o", ms=9, mfc="none", mec=FORCE, mew=1.6, zorder=9)
        labels.add(shortened(name), at, FORCE)
    _axes_and_gravity(axis, view, [float(g.evaluate(places.values)) for g in gravity_of(model)])
    labels.place()
    return figure


def _frame(axis: Axes, planar: bool) -> None:
    """The axes of a plane with their scale; in space there are none."""
    if not planar:
        axis.axis("off")
        return
    axis.grid(color=GRID, lw=0.6)
    axis.set_axisbelow(True)
    axis.tick_params(labelsize=8, colors=GREY, length=0)
    axis.set_xlabel("X [m]", fontsize=9, color=GREY)
    axis.set_ylabel("Z [m]", fontsize=9, color=GREY)
    axis.spines[:].set_visible(False)


def _joints(axis: Axes, view: View, places: Places, poses: Poses) -> None:
    """The ground under joints, and boxes where they slide, on a line along their direction."""
    for link, spot, base in places.joints:
        at = view.flat(poses.of(base))
        if not link.joint_type.has_direction:
            if base.body == GROUND:
                draw_ground(axis, at)
            continue
        ahead = Spot(base.body, tuple(np.add(base.at, places.numbers(link.joint, "direction"))))
        along = view.flat(poses.of(ahead)) - at
        along /= np.linalg.norm(along) or 1.0
        at = view.flat(poses.of(spot))
        if base.body == GROUND and along.any():
            draw_ground(axis, at, along)
        turn = float(np.degrees(np.arctan2(along[1], along[0])))
        reach = 0.06 * np.ptp(axis.get_xlim()) * along
        axis.plot(*np.transpose([at - reach, at + reach]), color=INK, lw=0.8, ls="-.", zorder=7)
        axis.plot(*at, marker=(4, 0, turn + 45), ms=10, mfc=PAPER, mec=INK, zorder=8)


def _names(axis: Axes, view: View, scene: Scene, poses: Poses, labels: Labels) -> None:
    """The names of bodies, and crosses in circles where their centres of gravity are."""
    for k, body in enumerate(scene.bodies):
        at, hue = view.flat(poses.places[0, k]), colour(k)
        axis.plot(*at, "o", ms=6, mfc=PAPER, mec=hue, mew=0.8, zorder=6)
        axis.plot(*at, "+", ms=6, color=hue, mew=1.2, zorder=6)
        name = f"{k + 1} {body.name}" if len(scene.bodies) <= MOST_NAMES else f"{k + 1}"
        labels.add(shortened(name), at, hue, bold=True)
        labels.avoid(view.flat(poses.all_of(k, body.surfaces[0].vertices)))


def _pushed(model: Model, places: Places) -> list[tuple[str, Spot]]:
    """Forces, moments and efforts, and where they act."""
    ends = {link.joint_name: spot for link, spot, _ in places.joints}
    found = []
    for name, load in model.loads.items():
        if isinstance(load, JointEffort):
            found.append((name, ends[load.joint]))
        elif isinstance(load, PointForce):
            found.append((name, places.points[load.point]))
        elif isinstance(load, BodyForce):
            found.append((name, Spot(places.tree.index(load.body), CENTRE)))
    return found


def _axes_and_gravity(axis: Axes, view: View, gravity: list[float]) -> None:
    """World axes in the lower left corner, and the direction of gravity in the upper right one."""
    low, high = np.transpose([axis.get_xlim(), axis.get_ylim()])
    reach = 0.07 * float(max(high - low))
    arrows = [(name, low + 0.5 * reach, end) for name, end in zip("XYZ", np.eye(3), strict=True)]
    if any(gravity):
        arrows.append(("g", high - 0.5 * reach, -np.array(gravity) / np.linalg.norm(gravity)))
    for name, start, end in arrows:
        way = reach * view.flat(end)
        if not np.allclose(way, 0.0):
            style = {"arrowstyle": "-|>", "color": INK, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
            axis.annotate("", start + way, start, arrowprops=style, zorder=9)
            axis.annotate(name, start + 1.25 * way, color=INK, fontsize=8, ha="center",
                          va="center")  # fmt: skip
