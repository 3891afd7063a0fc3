"""How the parts of a scene are drawn: lines and outlines in metres, from any pose."""

from __future__ import annotations

import numpy as np

from m4e_fmi.report.drawing import symbols
from m4e_fmi.report.drawing.scene import GROUND_INDEX, Anchor, JointMark, Scene, Tie, turned
from m4e_fmi.report.drawing.symbols import Line

SPRING, DAMPER, OTHER = "#2a7f62", "#7a4fa3", "#7b8794"
WIDTH = 0.022  # of a spring, as a part of the scene's size
SPACING = 1.5  # between ties that lie abreast, in widths


def colour_of(tie: Tie) -> str:
    """The colour of springs, of dampers, or of other loads."""
    if "spring" in tie.kind:
        return SPRING
    return DAMPER if "damper" in tie.kind else OTHER


def ranks(scene: Scene) -> list[float]:
    """For every tie its place among those with the same ends, counted from their middle.

    Of ties at a joint, which lie around it, the place counted from the inside.
    """
    groups: dict[frozenset[Anchor], list[int]] = {}
    for k, tie in enumerate(scene.ties):
        groups.setdefault(frozenset(tie.ends), []).append(k)
    result = [0.0] * len(scene.ties)
    for members in groups.values():
        for order, k in enumerate(members):
            around = scene.ties[k].kind.startswith("torsion")
            result[k] = order if around else order - (len(members) - 1) / 2
    return result


def tie_lines(scene: Scene, tie: Tie, rank: float, poses: np.ndarray, size: float) -> list[Line]:
    """Lines of a tie, (n, 2) each [m], at `poses` (N, 3) [m, m, rad]; `size` is the scene's."""
    ends = np.array([scene.place(end, poses) for end in tie.ends])
    if tie.kind.startswith("torsion"):
        return _around(tie, ends, rank, size)
    width = WIDTH * size
    order = sorted(range(2), key=lambda k: (tie.ends[k].body, tie.ends[k].at))
    if np.allclose(ends[0], ends[1]):
        return []
    first, second = ends[order]
    start, end = symbols.moved_aside(first, second, SPACING * width * rank)
    arms = [np.array(pair) for pair in ((first, start), (end, second))]
    if tie.kind == "tension_spring":
        return [symbols.spring(start, end, width), *arms]
    if tie.kind == "tension_damper":
        return [*symbols.damper(start, end, width), *arms]
    return [np.array([start, end]), *arms]


def _around(tie: Tie, ends: np.ndarray, rank: float, size: float) -> list[Line]:
    """A spiral or an arc with a bar, around the joint between two bodies."""
    unit = 0.0085 * size
    lines = [] if np.allclose(*ends) else [ends]
    centre = ends.mean(axis=0)
    inner = (1.5 + 1.1 * rank) * unit
    if tie.kind == "torsion_spring":
        return [symbols.spiral(centre, inner, inner + 1.3 * unit), *lines]
    radius = inner + 0.9 * unit
    angle = -1.4
    bar = [
        symbols.arc(centre, r, angle, angle)[0] for r in (radius - 0.7 * unit, radius + 0.7 * unit)
    ]
    return [symbols.arc(centre, radius, -2.6, -0.2), np.array(bar), *lines]


def ground_lines(scene: Scene, poses: np.ndarray, size: float) -> list[Line]:
    """The ground where something is fastened to it, and rails as long as slides go.

    Returns lines, (n, 2) each [m], for `poses` (T, N, 3) [m, m, rad].
    """
    hatch = 0.011 * size
    lines: list[Line] = []
    rails = {joint.parent.at: joint for joint in scene.joints
             if joint.direction and joint.parent.body == GROUND_INDEX}  # fmt: skip
    for at in scene.fixed:
        along, first, last = np.array([1.0, 0.0]), -0.0375 * size, 0.0375 * size
        if at in rails:
            along = np.array(rails[at].direction)
            slid = (scene.place_all(rails[at].child, poses) - at) @ along
            first, last = slid.min() - 0.09 * size, slid.max() + 0.09 * size
        lines += symbols.ground(at + first * along, at + last * along, hatch)
    return lines


def guides(scene: Scene, poses: np.ndarray) -> list[Line]:
    """Lines (2, 2) [m] from each sliding joint's point on a moving parent to that on its child.

    `poses` (N, 3) are in [m, m, rad].
    """
    return [
        np.array([scene.place(joint.parent, poses), scene.place(joint.child, poses)])
        for joint in scene.joints
        if joint.direction and joint.parent.body != GROUND_INDEX
    ]


def placed(outline: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Points of a body, `outline` (n, 2) [m], in the world, at `pose` x, z, θ (3,) [m, m, rad]."""
    return pose[:2] + np.array([turned((a, b), pose[2]) for a, b in outline])


def direction_of(joint: JointMark, poses: np.ndarray) -> np.ndarray:
    """A joint's direction in world axes, (2,) [1]; along X if it has none.

    `poses` (N, 3) are in [m, m, rad].
    """
    turn = poses[joint.parent.body, 2] if joint.parent.body >= 0 else 0.0
    return turned(joint.direction or (1.0, 0.0), turn)


def joint_outlines(scene: Scene, poses: np.ndarray, size: float) -> list[np.ndarray]:
    """Circles and sleeves of the joints, (n, 2) each [m], at `poses` (N, 3) [m, m, rad]."""
    radius = 0.0085 * size
    marks = []
    for joint in scene.joints:
        at = scene.place(joint.child, poses)
        if joint.type.symbol == "circle":
            marks.append(symbols.circle(at, radius, corners=20))
        elif joint.type.symbol == "sleeve":
            along = direction_of(joint, poses)
            marks.append(symbols.box(at, 4.2 * radius, 2 * radius, along))
    return marks
