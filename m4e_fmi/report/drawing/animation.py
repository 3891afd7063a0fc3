"""A simulation as an animation: one HTML file that needs nothing else."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.files.writing import check_suffix, written
from m4e_fmi.model import Model
from m4e_fmi.report.animation.frames import frames_of
from m4e_fmi.report.animation.of_model import scene_of_model
from m4e_fmi.report.animation.page import page, scene_part
from m4e_fmi.report.drawing.space.solids import check_simulated
from m4e_fmi.simulate import Simulation

MOST_FRAMES, MOST_POSES = 1200, 14_000
"""Frames of an animation, and poses of bodies in all of them: 8 bytes each."""


def animate(model: Model, simulation: Simulation, path: str | Path) -> Path:
    """Write an animation of `simulation`, a simulation of `model`, to `path` (.html).

    The file has a slider, loads nothing and is small: poses in 16 bits each. The mouse turns the
    view.
    """
    path = Path(path)
    check_suffix(path, (".html",), "an animation")
    check_simulated(model, simulation)
    scene = scene_of_model(model)
    most = min(MOST_FRAMES, MOST_POSES // len(model.bodies))
    shown = frames_of(scene, simulation.time, simulation.values, most=most)
    with written(path) as file:
        file.write_text(page(scene.title, [scene.description], scene_part(scene, shown)), "utf-8")
    return path
