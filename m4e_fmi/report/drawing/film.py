"""A simulation as a sequence of poses at even times: what both forms of animation show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_fmi.model import Model
from m4e_fmi.report.drawing.scene import Anchor, Scene, scene
from m4e_fmi.report.drawing.space.solids import check_simulated
from m4e_fmi.simulate import Simulation


@dataclass(frozen=True)
class Film:
    """`times` [s], evenly spaced, (T,); `poses` x, z, θ of every body, (T, N, 3).

    `trails` are the points whose paths are shown: of each body that holds no other, the point
    farthest from its joint.
    """

    scene: Scene
    times: np.ndarray
    poses: np.ndarray

    @property
    def size(self) -> float:
        """A length to scale symbols by [m], the same in all frames."""
        return self.scene.size(self.poses)

    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner, (2,) each, of all that is ever seen, with a margin [m]."""
        low, high = self.scene.extent(self.poses)
        margin = 0.08 * self.scene.diagonal(self.poses)
        return low - margin, high + margin

    @property
    def trails(self) -> list[Anchor]:
        """The points whose paths are shown."""
        holders = {joint.parent.body for joint in self.scene.joints}
        found = []
        for body, joint in enumerate(self.scene.joints):
            if body in holders:
                continue
            from_joint = np.array(self.scene.attachments[body]) - joint.child.at
            farthest = int(np.argmax(np.hypot(*from_joint.T)))
            found.append(Anchor(body, self.scene.attachments[body][farthest]))
        return found


def film(model: Model, simulation: Simulation, *, frames: int) -> Film:
    """At most `frames` poses of `simulation`, a simulation of `model`, linear between its outputs.

    InputError if the simulation is of another model.
    """
    check_simulated(model, simulation, "x")
    shown = scene(model, simulation.program)
    poses = shown.poses(simulation.values)
    count = min(frames, max(2, len(simulation.time)))
    times = np.linspace(simulation.time[0], simulation.time[-1], count)
    columns = poses.reshape(len(poses), -1)
    even = [np.interp(times, simulation.time, column) for column in columns.T]
    return Film(shown, times, np.stack(even, axis=1).reshape(count, *poses.shape[1:]))
