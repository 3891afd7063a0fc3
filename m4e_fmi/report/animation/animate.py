"""A simulation as an animation: a GIF, or one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.files.writing import check_suffix, written
from m4e_fmi.model import Model
from m4e_fmi.report.animation.frames import frames_of
from m4e_fmi.report.animation.of_model import scene_of_simulation
from m4e_fmi.report.animation.page import LONGEST, page, scene_part
from m4e_fmi.report.drawing.views import film
from m4e_fmi.simulate import Simulation

SUFFIXES = (".html", ".gif")
HTML_FRAMES, HTML_POSES = 1200, 14_000  # frames at most, and poses of bodies
GIF_FRAMES, GIF_RATE = 160, 20.0  # frames at most, per second
GIF_COLOURS = 64
GIF_PIXELS = 620  # of the longer side


def animate(model: Model, simulation: Simulation, path: str | Path) -> Path:
    """Write an animation of `simulation`, a simulation of `model`, to `path` (.html or .gif).

    The HTML file has a slider, loads nothing and is small: poses in 16 bits each. The mouse turns
    the view. InputError if the simulation is of another model.
    """
    check_suffix(path, SUFFIXES, "an animation")
    path = Path(path)
    missing = [b for b in model.bodies if f"body.{b}.z" not in simulation.values]
    if missing:
        message = f"the simulation of {simulation.program.name!r} has no body {missing[0]!r}"
        raise InputError.single(message, "give the model that was simulated")
    scene = scene_of_simulation(model, simulation)
    is_page = path.suffix.lower() == ".html"
    most = min(HTML_FRAMES, HTML_POSES // len(model.bodies)) if is_page else _gif_frames(simulation)
    shown = frames_of(scene, simulation.time, simulation.values, most=most)
    with written(path) as file:
        if is_page:
            text = page(scene.title, [scene.description], scene_part(scene, shown))
            file.write_text(text, encoding="utf-8")
        else:
            span = float(shown.times[-1] - shown.times[0])
            _write_gif(list(film(scene, shown, GIF_PIXELS)), span, file)
    return path


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
