"""Scenes in pictures: in one pose.

Parallel projection; what is nearer covers what is farther away. Planar scenes are seen from the
side, others from ahead, above and the right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.multibody.declaration import is_unset
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmi.report.animation.frames import Poses, poses_of
from m4e_fmi.report.animation.scene import GROUND, Scene
from m4e_fmi.report.drawing.parts import colour_of, ground, tie_lines
from m4e_fmi.report.drawing.style import BODY_COLOURS, GREY, INK, PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]
TURN, RISE = np.radians(-60.0), np.radians(22.0)
"""Where the eye is: about Z from +X, and above the X–Y plane."""
SIDE = -np.pi / 2
"""About Z, of the eye that sees a planar scene."""
PALEST, DARKEST = 0.28, 0.65
"""Share of a body's colour, the rest being white, in faces seen from ahead and from the side."""
MARGIN = 0.02
"""Least side of what is seen, relative to its largest."""
NONE = np.zeros(4)  # no colour
RIGHT = np.array([1.0, 0.0])


@dataclass(frozen=True)
class View:
    """A parallel projection: `right` and `up` on the paper and `ahead` into it, in world axes."""

    right: Floats
    up: Floats
    ahead: Floats

    @classmethod
    def of(cls, planar: bool = False) -> View:
        """That of a scene in space, or of a `planar` one."""
        turn, rise = (SIDE, 0.0) if planar else (TURN, RISE)
        eye = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        return cls(right, np.cross(eye, right), -eye)

    def flat(self, points: Floats) -> Floats:
        """On the paper, (…, 2) [m], what are `points` (…, 3) [m] in the world."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)

    def facing(self, sides: Floats) -> Floats:
        """Cosines (F,) [1] between the line of sight and the normals of `sides` (F, k, 3) [m]."""
        last = -1 if sides.shape[1] > 3 else 0
        normals = np.cross(sides[:, 2] - sides[:, 0], sides[:, last] - sides[:, 1])
        sizes = np.linalg.norm(normals, axis=1)
        return np.abs(normals @ self.ahead) / np.where(sizes > 0, sizes, 1.0)


def colour(body: int) -> str:
    """The colour of a body by its index."""
    return BODY_COLOURS[body % len(BODY_COLOURS)]


def start_poses(scene: Scene, program: Program) -> Poses:
    """Where the bodies are at the start values of the program.

    Masses that nobody has set are 1 kg: places do not depend on them.
    """
    program = program.with_start({v.name: 1.0 for v in program.parameters if is_unset(v)})
    form, states = load_python(program), program.states
    x, u, p = ([v.start for v in of] for of in (states, program.inputs, program.parameters))
    values = [*x, *form.outputs(0.0, x, u, p, form.constants(p))]
    names = [v.name for v in (*states, *program.outputs)]
    return poses_of(scene, {n: np.array([v]) for n, v in zip(names, values, strict=True)})


def extent(scene: Scene, poses: Poses, cables: Sequence[Floats] = ()) -> Floats:
    """Lower and upper corner (2, 3) [m] of bodies, and of joints on the ground.

    Without water also of other points of the ground. Only where nothing else is shown, of the
    `cables` (T, n, 3) [m].
    """
    ground = [spot.at for spot, _ in scene.hinges if spot.body == GROUND]
    if scene.water is None:
        ground += [spot.at for rope in scene.ropes for spot in rope.ends if spot.body == GROUND]
    seen = [np.reshape(ground, (-1, 3))]
    frames = range(0, len(poses.places), max(1, len(poses.places) // 200))
    for body, one in enumerate(scene.bodies):
        if not one.surfaces and not one.sticks:
            continue
        corners = np.vstack([*(hull.vertices for hull in one.surfaces), *map(np.array, one.sticks),
                             np.zeros((1, 3))])  # fmt: skip
        box = _corners(corners.min(axis=0), corners.max(axis=0))
        points = corners if len(corners) < len(box) else box
        seen += [poses.all_of(body, points, frame) for frame in frames]
    if not sum(map(len, seen)):
        seen += [*(nodes.reshape(-1, 3) for nodes in cables), np.zeros((1, 3))]
    everything = np.concatenate(seen)
    ends = np.array([everything.min(axis=0), everything.max(axis=0)])
    least = MARGIN * (np.ptp(ends, axis=0).max() or 1.0)
    return ends + np.where(np.ptp(ends, axis=0) < least, least / 2, 0.0) * [[-1.0], [1.0]]


def _corners(low: Floats, high: Floats) -> Floats:
    """The corners (8, 3) of a box."""
    return np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T


def limits(scene: Scene, poses: Poses, margin: float) -> tuple[Floats, Floats]:
    """Lower left and upper right corner (2,) [m] of a picture of all that is ever seen."""
    flat = View.of(scene.planar).flat(_corners(*extent(scene, poses)))
    room = margin * float(np.ptp(flat, axis=0).max() or 1.0)
    return flat.min(axis=0) - room, flat.max(axis=0) + room


def paint(axis: Axes, scene: Scene, poses: Poses) -> None:
    """Draw all bodies, joints and loads in the first of the `poses`, the farthest first."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.colors import to_rgba

    view = View.of(scene.planar)
    parts: list[_Part] = []
    for body, one in enumerate(scene.bodies):
        hue = np.array(to_rgba(colour(body)))
        for hull in one.surfaces:
            corners = poses.all_of(body, hull.vertices)
            for faces in hull.alike:
                sides = corners[faces]
                shares = PALEST + (DARKEST - PALEST) * (1.0 - view.facing(sides))
                shades = 1.0 - shares[:, None] * (1.0 - hue)
                shades[:, 3] = 0.85 if hull.edged else 1.0
                edges = np.broadcast_to(hue, shades.shape) if hull.edged else shades
                width = 0.6 if hull.edged else 0.3
                parts += [_Part(*of, width) for of in zip(sides, shades, edges, strict=True)]
        for end in one.sticks:
            tip = poses.all_of(body, np.array([end]))[0]
            parts.append(_Part(np.array([poses.places[0, body], tip]), NONE, hue, 2.2))
    parts.sort(key=lambda part: -float((part.points @ view.ahead).mean()))
    axis.add_collection(
        PolyCollection(
            [view.flat(part.points) for part in parts],
            facecolors=np.array([part.face for part in parts]),
            edgecolors=np.array([part.edge for part in parts]),
            linewidths=[part.width for part in parts],
            zorder=5,
        )
    )
    size = max(np.ptp(axis.get_xlim()), np.ptp(axis.get_ylim()))
    for rope in scene.ropes:
        ends = view.flat(np.array([poses.of(spot) for spot in rope.ends]))
        lines = tie_lines(rope.kind, ends, rope.rank, float(size))
        hue = colour_of(rope.kind)
        axis.add_collection(LineCollection(lines, colors=hue, lw=1.1, zorder=6))
        fixed = [at for spot, at in zip(rope.ends, ends, strict=True) if spot.body == GROUND]
        for at in fixed:
            draw_ground(axis, at)
    for start, end, turns in scene.axes:
        line = view.flat(np.array([poses.of(start), poses.of(end)]))
        axis.plot(*line.T, color=INK, lw=0.8, ls="-." if turns else "-", zorder=6)
    for spot, weld in scene.hinges:
        at, marker = view.flat(poses.of(spot)), "s" if weld else "o"
        axis.plot(*at, marker, ms=5, mfc=PAPER, mec=INK, mew=1.0, zorder=7)


def draw_ground(axis: Axes, at: Floats, along: Floats = RIGHT) -> None:
    """Draw the ground at a place `at` (2,) [m], or a rail of it `along` (2,) [1]."""
    from matplotlib.collections import LineCollection

    size = float(max(np.ptp(axis.get_xlim()), np.ptp(axis.get_ylim())))
    reach = (0.03 if along is RIGHT else 0.11) * size * along
    lines = ground(at - reach, at + reach, 0.009 * size)
    axis.add_collection(LineCollection(lines, colors=GREY, lw=1.0, zorder=4))


@dataclass(frozen=True)
class _Part:
    """A polygon, or a line, of `points` (n, 3) [m]; colours (4,) of its face and its edges."""

    points: Floats
    face: Floats
    edge: Floats
    width: float
