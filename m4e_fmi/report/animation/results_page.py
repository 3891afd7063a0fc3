"""Animations as pages: of a simulation of a model, and of a file of results by its scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.errors import InputError
from m4e_fmi.model import Model
from m4e_fmi.report.animation.frames import Frames, frames_of
from m4e_fmi.report.animation.of_model import scene_of_simulation
from m4e_fmi.report.animation.page import Part, page, scene_part
from m4e_fmi.report.animation.scene import Scene, Water
from m4e_fmi.report.animation.scene_text import scene_of_text
from m4e_fmi.results.results_file import AT_STOP, Animation, Results, load_results
from m4e_fmi.results.series import SCENE
from m4e_fmi.simulate import Simulation

Floats = NDArray[np.float64]
MODEL_FRAMES, MODEL_POSES = 1200, 14_000
"""Of an animation of a simulation in memory: frames, and poses of bodies."""
MOST_FRAMES, BYTES = 4000, 450_000
"""Of an animation: frames, and bytes of their numbers before these become text, 4/3 as many."""
AGREES = 1e-3
"""Difference of waves from their recorded elevation, over the largest, that is none."""


def animate(model: Model, simulation: Simulation, path: str | Path) -> Path:
    """Write an animation of `simulation`, a simulation of `model`, to `path` (.html).

    The page loads nothing and is small: poses in 16 bits each. InputError if the simulation is of
    another model.
    """
    return Animation(simulation.program.name, model_page(model, simulation)).save(path)


def model_page(model: Model, simulation: Simulation) -> str:
    """The same page as text."""
    missing = [b for b in model.bodies if f"body.{b}.z" not in simulation.values]
    if missing:
        message = f"the simulation of {simulation.program.name!r} has no body {missing[0]!r}"
        raise InputError.single(message, "give the model that was simulated")
    scene = scene_of_simulation(model, simulation)
    most = min(MODEL_FRAMES, MODEL_POSES // len(model.bodies))
    shown = frames_of(scene, simulation.time, simulation.values, most=most)
    return page(scene.title, [scene.description], scene_part(scene, shown))


def animate_run(results: str | Path | Results, path: str | Path) -> Path:
    """Write the animation of `results`, a file or what `load` made of it, to `path` (.html).

    The page needs nothing else. InputError for results without a scene, of less than two rows, or
    without the variables that the scene follows.
    """
    made = run_page(results if isinstance(results, Results) else load_results(results))
    return Animation(str(results), made).save(path)


def run_page(results: Results) -> str:
    """The same page as text."""
    scene, shown, texts = _read(results)
    return page(scene.title, texts, scene_part(scene, shown))


def run_part(results: Results) -> Part:
    """The animation of results as part of a page; InputError as `animate_run`."""
    return scene_part(*_read(results)[:2])


def _read(results: Results) -> tuple[Scene, Frames, list[str]]:
    """The scene of results, its frames, and texts about them."""
    text = results.attributes.get(SCENE)
    name = str(results.path)
    if text is None:
        message = "has no scene: nothing in it has a shape, as of an FMU alone"
        raise InputError.single(message, "", name)
    try:
        scene = scene_of_text(text)
        if not (scene.bodies or scene.cables):
            raise InputError.single("its scene has no bodies and no lines", "")
        numbers = len(scene.variables) + len(scene.bodies)  # a quaternion has one more than angles
        most = max(2, min(MOST_FRAMES, BYTES // (2 * numbers)))
        shown = frames_of(scene, results.time, results.series, most=most)
    except InputError as error:
        raise InputError([replace(p, file=name) for p in error.problems]) from None
    sea, doubts = _agreed(scene.water, results)
    scene = replace(scene, water=sea)
    return scene, shown, [scene.description, *scene.notes, *doubts, *_notes(scene, shown, results)]


def _agreed(water: Water | None, results: Results) -> tuple[Water | None, list[str]]:
    """The water with its waves if their recorded elevation is theirs; else still, and a text."""
    series: Mapping[str, Floats] = results.series
    if water is None or water.gauge not in series:
        return water, []
    recorded = np.asarray(series[water.gauge], float)
    rows = np.linspace(0, len(recorded) - 1, min(len(recorded), 200)).astype(int)
    rows = rows[np.isfinite(recorded[rows])]
    heights = water.elevation(0.0, 0.0, results.time[rows])
    off = float(np.abs(heights - recorded[rows]).max(initial=0.0))
    if off <= AGREES * max(float(np.abs(recorded[rows]).max(initial=0.0)), 1e-3):
        return water, []
    text = (
        f"The water is drawn still: the waves of the scene differ by up to {off:.3g} m from the "
        f"recorded {water.gauge}."
    )
    return replace(water, trains=()), [text]


def _notes(scene: Scene, shown: Frames, results: Results) -> Iterator[str]:
    """Texts about what is not shown as it was."""
    rough = [
        cable.name for cable, exact in zip(scene.cables, shown.exact, strict=True) if not exact
    ]
    if rough:
        yield (
            f"Dashed straight lines ({', '.join(rough)}): the places of their nodes were not "
            "recorded; run with --animate to have them."
        )
    ended = results.attributes.get("ended", AT_STOP)
    if ended != AT_STOP:
        yield f"The run ended early ({ended}); shown until t = {shown.times[-1]:.6g} s."
    elif shown.times[-1] < results.time[-1]:
        yield f"Shown until t = {shown.times[-1]:.6g} s: numbers after that are not finite."
    count, rows = len(shown.times), len(results.time)
    if count < rows:
        step = (shown.times[-1] - shown.times[0]) / (count - 1)
        yield f"A frame every {step:.3g} s, of {rows} rows of results."
