"""Mode shapes of models: at rest and moved one way pale, and the other way in full colour."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.analysis.attitudes import attitudes, rotated
from m4e_fmi.analysis.points import At, operating_point
from m4e_fmi.errors import InputError
from m4e_fmi.model import Model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Variable
from m4e_fmi.report.animation.frames import Poses
from m4e_fmi.report.animation.of_model import scene_of_model
from m4e_fmi.report.drawing.labels import shortened
from m4e_fmi.report.drawing.style import INK, save
from m4e_fmi.report.drawing.views import extent, limits, paint, prepare, start_poses

Floats = NDArray[np.float64]
WIDEST = 12.5  # inches
SWING = 0.12  # how far a mode shape moves a body at most, as a part of the model's diagonal
LARGEST_TURN = 0.5  # rad
REST, FAINT = 0.15, 0.4  # strengths of the pictures at rest and moved back
SMALL = 1e-4  # amplitude at which the size of a mode is found


def plot_modes(
    model: Model,
    shapes: ArrayLike,
    picture: str | Path,
    *,
    titles: Sequence[str] = (),
    at: At = None,
) -> Path:
    """Draw mode shapes of `model` to `picture`: at rest, and moved one way and the other.

    Column k of `shapes`, (n, modes), in any units, holds the coordinates of mode k in the order of
    the Program's states, of a free attitude its small rotations; real or complex (its phase now and
    a quarter of a period later). `at` is where to move from, the start values if
    it is not given. Amplitudes are scaled to be seen. InputError for shapes of another size.
    """
    from matplotlib.figure import Figure

    program = model_program(model)
    program = program.with_start(operating_point(program, at).values)
    modes = MovedModel(model, program)
    columns = _columns(shapes, modes.coordinates)
    low, high = limits(modes.scene, modes.rest, 0.04 + SWING)
    width, height = 3.4 * (high - low) / (high - low).max()
    width, height, count = max(1.6, width), height + 0.4, max(1, columns.shape[1])
    across = min(max(1, int(WIDEST / width)), count)
    down = -(-count // across)
    figure = Figure(figsize=(width * across, height * down + 0.4), layout="constrained")
    for k, axis in enumerate(figure.subplots(down, across, squeeze=False).ravel()):
        prepare(axis, low, high)
        if k < columns.shape[1]:
            shape = columns[:, k]
            largest = np.angle(shape[np.argmax(np.abs(shape))])
            one_way, other = modes.swung(np.real(shape * np.exp(-1j * largest)))
            for poses, strength in ((modes.rest, REST), (one_way, FAINT), (other, 1.0)):
                paint(axis, modes.scene, poses, 0, strength=strength)
            title = titles[k] if k < len(titles) else f"mode {k + 1}"
            axis.set_title(shortened(title), fontsize=9, color=INK, loc="left")
    figure.suptitle(
        shortened(model.name), x=0.01, ha="left", fontsize=11, fontweight="bold", color=INK
    )
    return save(figure, picture, margin=0.1)


class MovedModel:
    """A model that is moved from rest; `coordinates` are what a shape has one number for each."""

    def __init__(self, model: Model, program: Program) -> None:
        self.program, self.scene = program, scene_of_model(model)
        self.rest = start_poses(self.scene, program)
        self._attitudes = attitudes(program)
        rotations = {a.quaternion[0]: a.rotations for a in self._attitudes}
        moved = {v.derivative_of for v in program.states}
        self.coordinates: list[Variable] = []
        for k, state in enumerate(program.states):
            own = (state,) if state.name in moved else ()
            self.coordinates += rotations.get(k, own)

    def swung(self, shape: Floats) -> tuple[Poses, Poses]:
        """The poses one way and the other of a mode of `shape` (n,) in SI, so that it is seen."""
        near = self.poses(shape, SMALL)
        steps = [
            near.all_of(k, hull.vertices) - self.rest.all_of(k, hull.vertices)
            for k, body in enumerate(self.scene.bodies)
            for hull in body.surfaces
        ]
        low, high = extent(self.scene, self.rest)
        size = float(np.linalg.norm(high - low))
        step = float(np.linalg.norm(np.vstack(steps), axis=1).max()) / (SWING * size)
        turn = float(np.abs(near.attitudes - self.rest.attitudes).max()) / LARGEST_TURN
        amplitude = SMALL / max(step, turn, 1e-300)
        return self.poses(shape, -amplitude), self.poses(shape, amplitude)

    def poses(self, shape: Floats, amplitude: float) -> Poses:
        """The poses at an amplitude of a mode of `shape` (n,) in SI."""
        moved = dict(zip((v.name for v in self.coordinates), amplitude * shape, strict=True))
        starts = {v.name: v.start for v in self.program.states}
        changed = {n: starts[n] + float(part) for n, part in moved.items() if n in starts}
        for attitude in self._attitudes:
            own = [self.program.states[k] for k in attitude.quaternion]
            turn = np.array([moved[v.name] for v in attitude.rotations])
            turned = rotated(np.array([v.start for v in own]), turn)
            changed |= {v.name: float(part) for v, part in zip(own, turned, strict=True)}
        return start_poses(self.scene, self.program.with_start(changed))


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
