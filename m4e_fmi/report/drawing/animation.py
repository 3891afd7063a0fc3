"""A simulation as an animation: a GIF, or one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.files.writing import check_suffix, written
from m4e_fmi.model import Model
from m4e_fmi.report.animation.frames import frames_of, packed
from m4e_fmi.report.animation.of_model import scene_of_simulation, simulated_parameters
from m4e_fmi.report.animation.page import LONGEST, page, part, scene_part, times_of
from m4e_fmi.report.animation.scene_text import short
from m4e_fmi.report.drawing.film import Film, film
from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.parts import (
    SPACING,
    WIDTH,
    colour_of,
    ground_lines,
    guides,
    joint_outlines,
    placed,
    ranks,
    tie_lines,
)
from m4e_fmi.report.drawing.space.pictures import space_frames
from m4e_fmi.report.drawing.space.solids import check_simulated, film_poses, solids
from m4e_fmi.report.drawing.style import BODY_COLOURS, GREY, INK, PAPER, pale
from m4e_fmi.simulate import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    from m4e_fmi.report.drawing.scene import Anchor

SUFFIXES = (".html", ".gif")
HTML_FRAMES, HTML_POSES = 1200, 14_000  # frames at most, and poses of bodies: 8 bytes each
GIF_FRAMES, GIF_RATE = 160, 20.0  # frames at most, per second
GIF_COLOURS = 64
GIF_PIXELS = 620  # of the longer side


def animate(model: Model, simulation: Simulation, path: str | Path) -> Path:
    """Write an animation of `simulation`, a simulation of `model`, to `path` (.html or .gif).

    The HTML file has a slider, loads nothing and is small: poses in 16 bits each. In space the
    mouse turns the view.
    """
    check_suffix(path, SUFFIXES, "an animation")
    path = Path(path)
    if path.suffix.lower() == ".html":
        frames = min(HTML_FRAMES, HTML_POSES // len(model.bodies))
        text = (
            html_page(film(model, simulation, frames=frames))
            if model.dimensions == 2
            else _space_page(model, simulation, frames)
        )
        with written(path) as file:
            file.write_text(text, encoding="utf-8")
    else:
        frames = _gif_frames(simulation)
        if model.dimensions == 2:
            shown = film(model, simulation, frames=frames)
            times, pictures = shown.times, _pictures(shown)
        else:
            times, poses = film_poses(model, simulation, frames)
            bodies = solids(model, simulated_parameters(simulation))
            pictures = space_frames(bodies, times, poses, GIF_PIXELS)
        with written(path) as file:
            _write_gif(list(pictures), float(times[-1] - times[0]), file)
    return path


def html_page(shown: Film) -> str:
    """The page of a planar model as text."""
    scene = shown.scene
    return page(scene.title, [scene.description], part(_data(shown), "planar.js"))


def _space_page(model: Model, simulation: Simulation, frames: int) -> str:
    """The page of a model in space."""
    check_simulated(model, simulation, "y")
    scene = scene_of_simulation(model, simulation)
    shown = frames_of(scene, simulation.time, simulation.values, most=frames)
    return page(scene.title, [scene.description], scene_part(scene, shown))


def _data(shown: Film) -> dict[str, object]:
    """Data of the page: coordinates in metres, poses packed."""
    scene, size = shown.scene, shown.size
    low, high = shown.limits()

    def rounded(points: np.ndarray) -> list[list[float]]:
        return [short(point, 4) for point in np.asarray(points)]

    def end(anchor: Anchor) -> list[float]:
        return [anchor.body, *anchor.at]

    return {
        "numbers": 3, "low": low.tolist(), "high": high.tolist(), "size": size,
        **times_of(shown.times), **packed(shown.poses.reshape(len(shown.times), -1)),
        "bodies": [
            {"name": f"{k + 1} {name}", "colour": BODY_COLOURS[k % len(BODY_COLOURS)],
             "depth": scene.depths[k], "outline": rounded(scene.outline(k, 0.02 * size))}
            for k, name in enumerate(scene.bodies)
        ],
        "joints": [
            {"symbol": j.type.symbol, "slides": bool(j.direction),
             "at": end(j.child), "from": end(j.parent), "direction": j.direction or [1, 0]}
            for j in scene.joints if not j.type.is_free
        ],
        "ties": [
            {"kind": tie.kind, "colour": colour_of(tie), "rank": rank,
             "ends": [end(e) for e in sorted(tie.ends, key=lambda a: (a.body, a.at))]}
            for tie, rank in zip(scene.ties, ranks(scene), strict=True)
        ],
        "points": [end(a) for a in scene.points.values()],
        "trails": [end(a) for a in shown.trails],
        "ground": [rounded(line) for line in ground_lines(scene, shown.poses, size)],
        "width": WIDTH, "spacing": SPACING,
    }  # fmt: skip


def _gif_frames(simulation: Simulation) -> int:
    seconds = min(LONGEST, float(simulation.time[-1] - simulation.time[0]))
    return int(min(GIF_FRAMES, max(2, round(seconds * GIF_RATE))))


def _write_gif(pictures: Sequence[np.ndarray], span: float, path: Path) -> None:
    """Frames of a film of `span` s, written by Pillow with one palette for all."""
    from PIL import Image

    middle = Image.fromarray(pictures[len(pictures) // 2]).quantize(colors=GIF_COLOURS - 1)
    colours = [255, 255, 255, *(middle.getpalette() or [])]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours)
    reduced = []
    for picture in pictures:
        frame = Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        indices = np.where((picture == 255).all(axis=-1), 0, np.asarray(frame))  # white stays white
        reduced.append(Image.fromarray(indices.astype(np.uint8), "P"))
        reduced[-1].putpalette(colours)
    seconds = min(LONGEST, span)
    reduced[0].save(
        path, save_all=True, append_images=reduced[1:], loop=0, optimize=False,
        duration=max(20, round(1000 * seconds / len(reduced))),
    )  # fmt: skip


def _pictures(shown: Film) -> Iterator[np.ndarray]:
    """Every frame as an array of bytes (height, width, 3)."""
    from matplotlib.collections import LineCollection, PolyCollection

    scene, size = shown.scene, shown.size
    canvas, axis, clock = _stage(shown)
    colours = [BODY_COLOURS[k % len(BODY_COLOURS)] for k in range(len(scene.bodies))]
    order = np.argsort(scene.depths, kind="stable")
    outlines = [scene.outline(k, 0.02 * size) for k in order]
    paths = [scene.place_all(anchor, shown.poses) for anchor in shown.trails]
    trails = LineCollection([], colors=[colours[a.body] for a in shown.trails], linewidths=1.0,
                            alpha=0.55, zorder=2)  # fmt: skip
    faces, edges = [pale(colours[k]) for k in order], [colours[k] for k in order]
    bodies = PolyCollection([], facecolors=faces, edgecolors=edges, linewidths=1.3, zorder=3)
    ties = LineCollection([], linewidths=1.1, zorder=4)
    joints = PolyCollection([], facecolors=PAPER, edgecolors=INK, linewidths=1.1, zorder=5)
    for collection in (trails, bodies, ties, joints):
        axis.add_collection(collection)
    for k, (time, poses) in enumerate(zip(shown.times, shown.poses, strict=True)):
        bodies.set_verts(
            [placed(outline, poses[b]) for b, outline in zip(order, outlines, strict=True)]
        )
        lines, hues = _lines(shown, poses)
        ties.set_segments(lines)
        ties.set_color(hues)
        joints.set_verts(joint_outlines(scene, poses, size))
        trails.set_segments([path[max(0, k - 80) : k + 1] for path in paths])
        clock.set_text(f"{time:.2f} s")
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _stage(shown: Film) -> tuple[FigureCanvasAgg, Axes, Text]:
    """The parts that stand still: canvas, axes with the ground, and the text with the time."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    low, high = shown.limits()
    sides = high - low
    missing = np.maximum(0, 0.5 * sides.max() - sides) / 2
    low, high = low - missing, high + missing
    inches = (high - low) / (high - low).max() * GIF_PIXELS / 100 + (0.0, 0.35)
    figure = Figure(figsize=tuple(inches), dpi=100, facecolor=PAPER)
    canvas = FigureCanvasAgg(figure)
    axis = figure.add_axes((0, 0, 1, 1 - 0.35 / inches[1]))
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axis.axis("off")
    heights = {"y": 1 - 0.2 / inches[1], "va": "center"}
    title = shortened(shown.scene.title)
    figure.text(0.02, s=title, fontsize=11, fontweight="bold", color=INK, **heights)
    clock = figure.text(0.98, s="", fontsize=10, ha="right", color=GREY, **heights)
    ground = ground_lines(shown.scene, shown.poses, shown.size)
    axis.add_collection(LineCollection(ground, colors=GREY, linewidths=0.9))
    return canvas, axis, clock


def _lines(shown: Film, poses: np.ndarray) -> tuple[list[np.ndarray], list[str]]:
    """Guides, springs and dampers in one frame, and their colours."""
    scene = shown.scene
    lines = guides(scene, poses)
    hues = [GREY] * len(lines)
    for tie, rank in zip(scene.ties, ranks(scene), strict=True):
        drawn = tie_lines(scene, tie, rank, poses, shown.size)
        lines += drawn
        hues += [colour_of(tie)] * len(drawn)
    return lines, hues
