"""Pictures of how a model moves: phase plots and mode shapes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError
from m4e_fmi.model import Model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Variable
from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.parts import colour_of, ground_lines, placed, ranks, tie_lines
from m4e_fmi.report.drawing.pictures import save
from m4e_fmi.report.drawing.scene import Scene, scene, start_values
from m4e_fmi.report.drawing.space.modes import ModePictures
from m4e_fmi.report.drawing.style import BODY_COLOURS, GREY, INK, pale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from m4e_fmi.analysis.points import At

WIDEST = 12.5  # inches
SWING = 0.12  # how far a mode shape moves a body at most, as a part of the scene's diagonal
LARGEST_TURN = 0.5  # rad


def plot_modes(
    model: Model,
    shapes: ArrayLike,
    picture: str | Path,
    *,
    titles: Sequence[str] = (),
    at: At = None,
) -> Path:
    """Draw mode shapes of `model` to `picture`: at rest in grey, and moved one way and the other.

    Column k of `shapes`, (n, modes), in any units, holds the coordinates of mode k in the order of
    the Program's states, of a free attitude its small rotations; real or complex (its phase now and
    a quarter of a period later). `at` is where to move from, the start values if
    it is not given. Amplitudes are scaled to be seen. InputError for shapes of another size.
    """
    from m4e_fmi.analysis.points import operating_point

    program = model_program(model)
    program = program.with_start(operating_point(program, at).values)
    if model.dimensions == 3:
        return _spatial_modes(ModePictures(model, program), shapes, picture, titles)
    coordinates = [v for v in program.states if v.derivative_of is None]
    columns = _columns(shapes, coordinates)
    shown = scene(model, program)
    size = shown.size(shown.start[None])
    low, high = _window(shown)
    width, height = 3.4 * (high - low) / (high - low).max()
    figure, axes = _grid(columns.shape[1], max(1.6, width), height + 0.4)
    for k, axis in enumerate(axes):
        shape, diagonal = _in_phase(columns[:, k]), shown.diagonal(shown.start[None])
        _mode(axis, shown, _moved(shown, program, coordinates, shape, diagonal), size)
        _entitle(axis, k, titles)
    return _saved(figure, model.name, picture)


def _spatial_modes(
    pictures: ModePictures, shapes: ArrayLike, picture: str | Path, titles: Sequence[str]
) -> Path:
    columns = _columns(shapes, pictures.coordinates)
    low, high = pictures.limits
    width, height = 3.4 * (high - low) / (high - low).max()
    figure, axes = _grid(columns.shape[1], max(1.6, width), height + 0.4)
    for k, axis in enumerate(axes):
        pictures.draw(axis, _in_phase(columns[:, k]))
        _entitle(axis, k, titles)
    return _saved(figure, pictures.model.name, picture)


def _columns(shapes: ArrayLike, coordinates: Sequence[Variable]) -> np.ndarray:
    """Shapes as an array (n, modes); InputError if they are not of these coordinates."""
    columns = np.atleast_2d(np.asarray(shapes))
    if columns.shape[0] != len(coordinates):
        message = (
            f"mode shapes have {columns.shape[0]} rows, the model {len(coordinates)} coordinates"
        )
        names = ", ".join(v.name for v in coordinates)
        raise InputError.single(message, f"give one row for each of {names}")
    return columns


def _in_phase(shape: np.ndarray) -> np.ndarray:
    """The shape (n,) when its largest part is largest."""
    return np.real(shape * np.exp(-1j * np.angle(shape[np.argmax(np.abs(shape))])))


def _entitle(axis: Axes, k: int, titles: Sequence[str]) -> None:
    title = titles[k] if k < len(titles) else f"mode {k + 1}"
    axis.set_title(shortened(title), fontsize=9, color=INK, loc="left")


def _moved(
    shown: Scene, program: Program, coordinates: list[Variable], shape: np.ndarray, diagonal: float
) -> np.ndarray:
    """Poses at minus and plus a mode shape, (2, N, 3), its amplitude such as to be seen."""

    def poses(amplitude: float) -> np.ndarray:
        changed = {v.name: v.start + amplitude * s for v, s in zip(coordinates, shape, strict=True)}
        return shown.poses(start_values(program.with_start(changed)))[0]

    small = 1e-4
    near = poses(small)
    steps = [
        placed(np.array(attached), near[b]) - placed(np.array(attached), shown.start[b])
        for b, attached in enumerate(shown.attachments)
    ]
    step = np.max(np.hypot(*np.vstack(steps).T))
    turn = np.abs(near - shown.start)[:, 2].max()
    amplitude = small / max(step / (SWING * diagonal), turn / LARGEST_TURN, 1e-300)
    return np.stack([poses(-amplitude), poses(amplitude)])


def _window(shown: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Corners of what every mode's picture shows [m]."""
    low, high = shown.extent(shown.start[None])
    margin = (0.04 + SWING) * shown.diagonal(shown.start[None])
    return low - margin, high + margin


def _mode(axis: Axes, shown: Scene, moved: np.ndarray, size: float) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    low, high = _window(shown)
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axis.set_aspect("equal")
    axis.axis("off")
    ground = ground_lines(shown, np.concatenate([shown.start[None], moved]), size)
    axis.add_collection(LineCollection(ground, colors=GREY, lw=0.8))
    outlines = [shown.outline(b, 0.02 * size) for b in range(len(shown.bodies))]
    still = [placed(outline, pose) for outline, pose in zip(outlines, shown.start, strict=True)]
    axis.add_collection(PolyCollection(still, facecolors="none", edgecolors="#b9c2ca", lw=0.8))
    for poses, alpha in zip(moved, (0.4, 0.95), strict=True):
        for tie, rank in zip(shown.ties, ranks(shown), strict=True):
            lines = tie_lines(shown, tie, rank, poses, size)
            axis.add_collection(LineCollection(lines, colors=colour_of(tie), lw=0.8, alpha=alpha))
        for b, outline in enumerate(outlines):
            colour = BODY_COLOURS[b % len(BODY_COLOURS)]
            axis.add_collection(
                PolyCollection(
                    [placed(outline, poses[b])], facecolors=pale(colour), edgecolors=colour,
                    lw=1.1, alpha=alpha,
                )
            )  # fmt: skip


def _grid(count: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure and `count` axes of a width and height in inches, in as many rows as it takes."""
    from matplotlib.figure import Figure

    columns = min(max(1, int(WIDEST / width)), max(1, count))
    rows = -(-max(1, count) // columns)
    figure = Figure(figsize=(width * columns, height * rows + 0.4), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis in axes[count:]:
        axis.axis("off")
    return figure, list(axes[:count])


def _saved(figure: Figure, title: str, picture: str | Path) -> Path:
    figure.suptitle(shortened(title), x=0.01, ha="left", fontsize=11, fontweight="bold", color=INK)
    return save(figure, picture, margin=0.1)
