"""Mode shapes of models in space: at rest in outline, moved one way pale and the other in full."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.analysis.attitudes import attitudes, rotated
from m4e_fmi.model import Model
from m4e_fmi.program import Program, Variable
from m4e_fmi.report.drawing.space.pictures import View, extent, paint, prepare
from m4e_fmi.report.drawing.space.solids import Floats, Poses, Solids, solids, start_poses

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SWING = 0.12
"""How far a mode moves a body at most, as a part of the model's size."""
LARGEST_TURN = 0.5  # rad
FAINT = 0.3
SMALL = 1e-4  # amplitude at which the size of a mode is found


class ModePictures:
    """The modes of one model; `coordinates` are what a shape has one number for each."""

    def __init__(self, model: Model, program: Program) -> None:
        self.model, self.program, self.view = model, program, View.of()
        self.shown: Solids = solids(model)
        self._attitudes = attitudes(program)
        rotations = {a.quaternion[0]: a.rotations for a in self._attitudes}
        moved = {v.derivative_of for v in program.states}
        self.coordinates: list[Variable] = []
        for k, state in enumerate(program.states):
            own = (state,) if state.name in moved else ()
            self.coordinates += rotations.get(k, own)
        self.rest = start_poses(model, program)
        low, high = extent(self.shown, self.rest)
        self._size = float(np.linalg.norm(high - low)) or 1.0

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Lower left and upper right corner of every picture, (2,) each [m]."""
        low, high = extent(self.shown, self.rest)
        corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
        flat = self.view.flat(corners)
        margin = (0.04 + SWING) * self._size
        return flat.min(axis=0) - margin, flat.max(axis=0) + margin

    def draw(self, axis: Axes, shape: Floats) -> None:
        """Draw one mode, of `shape` (n,) in SI, to `axis`."""
        prepare(axis, *self.limits)
        poses = self.poses_of(shape)
        near = poses(SMALL)
        steps = [
            np.linalg.norm(near.all_of(body, corners) - self.rest.all_of(body, corners), axis=1)
            for body, corners in enumerate(hull.vertices for hull in self.shown.hulls)
        ]
        turns = near.attitudes - self.rest.attitudes
        step = max(float(np.max(moved)) for moved in steps) / (SWING * self._size)
        turn = float(np.abs(turns).max()) / LARGEST_TURN
        amplitude = SMALL / max(step, turn, 1e-300)
        paint(axis, self.shown, poses(-amplitude), 0, self.view, strength=FAINT)
        paint(axis, self.shown, poses(amplitude), 0, self.view)

    def poses_of(self, shape: Floats) -> Callable[[float], Poses]:
        """The poses at an amplitude of a mode of `shape` (n,) in SI."""

        def poses(amplitude: float) -> Poses:
            moved = dict(zip((v.name for v in self.coordinates), amplitude * shape, strict=True))
            starts = {v.name: v.start for v in self.program.states}
            changed = {n: starts[n] + float(part) for n, part in moved.items() if n in starts}
            for attitude in self._attitudes:
                own = [self.program.states[k] for k in attitude.quaternion]
                turn = np.array([moved[v.name] for v in attitude.rotations])
                turned = rotated(np.array([v.start for v in own]), turn)
                changed |= {v.name: float(part) for v, part in zip(own, turned, strict=True)}
            return start_poses(self.model, self.program.with_start(changed))

        return poses
