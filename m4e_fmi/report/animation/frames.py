"""The numbers of an animation: where everything is in each of its frames, from results."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.errors import InputError
from m4e_fmi.report.animation.scene import GROUND, Cable, Followed, Place, Scene, Spot, Value
from m4e_fmi.shown import first_of

Floats = NDArray[np.float64]
PER_BODY = 7
"""Numbers of a body: place [m], and quaternion."""


@dataclass(frozen=True)
class Poses:
    """Places (T, N, 3) [m] and attitudes (T, N, 3, 3), body to world axes, of all bodies."""

    places: Floats
    attitudes: Floats

    def of(self, spot: Spot, frame: int = 0) -> Floats:
        """Where a point is, (3,) [m]."""
        at = np.array(spot.at)
        return at if spot.body == GROUND else self.all_of(spot.body, at, frame)

    def all_of(self, body: int, corners: Floats, frame: int = 0) -> Floats:
        """Where points of a body are, (n, 3) [m], that are `corners` (n, 3) [m] in its axes."""
        return self.places[frame, body] + corners @ self.attitudes[frame, body].T


@dataclass(frozen=True)
class Frames:
    """`times` (T,) [s] and, of each frame, the poses of the bodies and the places of the cables.

    `cables` are (T, n, 3) [m] each; `exact` is False for those of which ends only are known.
    """

    times: Floats
    poses: Poses
    cables: tuple[Floats, ...] = ()
    exact: tuple[bool, ...] = field(default=())

    def columns(self) -> Floats:
        """All numbers of each frame (T, N) [m, 1]: of bodies and cables."""
        count = len(self.times)
        turns = quaternions(self.poses.attitudes)
        parts = [np.concatenate([self.poses.places, turns], axis=2).reshape(count, -1)]
        parts += [nodes.reshape(count, -1) for nodes in self.cables]
        return np.concatenate(parts, axis=1)


def frames_of(scene: Scene, time: Floats, series: Mapping[str, Floats], *, most: int) -> Frames:
    """At most `most` frames, evenly spaced, of results at `time` (R,) [s]; two at least.

    `series` are the variables that the scene follows, (R,) each, in their units. InputError for
    bodies whose variables are missing, and of numbers that are not finite.
    """
    rows = _finite_rows(scene, time, series)
    from scipy.spatial.transform import Rotation

    time = time[:rows]
    count = min(most, rows)
    times = np.linspace(time[0], time[-1], count)

    def at(values: Floats) -> Floats:
        """Values (R, …) at the times of the frames, linear between rows."""
        flat = values.reshape(rows, -1)
        even = [np.interp(times, time, column) for column in flat.T]
        return np.reshape(np.transpose(even), (count, *values.shape[1:]))

    def places(value: Sequence[Value]) -> Floats:
        return np.stack([_values(one, series, rows) for one in value], axis=1)

    moving = poses_of(scene, series, rows)
    turns = quaternions(moving.attitudes)
    cables, exact = [], []
    for cable in scene.cables:
        nodes = _nodes(cable, series)
        cables.append(at(np.stack([places(node) for node in nodes], axis=1)))
        exact.append(nodes is cable.nodes)
    flat = at(turns).reshape(-1, 4)[:, [1, 2, 3, 0]]  # of any length, scalar first
    attitudes = Rotation.from_quat(flat).as_matrix().reshape(count, -1, 3, 3)
    poses = Poses(at(moving.places), attitudes)
    return Frames(times, poses, tuple(cables), tuple(exact))


def poses_of(scene: Scene, series: Mapping[str, Floats], rows: int = 1) -> Poses:
    """Where the bodies are in the first `rows` of `series` (R,), variables in their units."""
    motions = [_values(value, series, rows) for body in scene.bodies for value in body.motion]
    moved = np.reshape(motions, (len(scene.bodies), 6, rows)).transpose(2, 0, 1)
    return Poses(moved[..., :3], rotations(moved[..., 3:]))


def _values(value: Value, series: Mapping[str, Floats], rows: int) -> Floats:
    if not isinstance(value, Followed):
        return np.full(rows, float(value))
    return value.factor * np.asarray(series[value.variable][:rows], float) + value.offset


def _nodes(cable: Cable, series: Mapping[str, Floats]) -> tuple[Place, ...]:
    """The nodes of a cable if all were recorded, else its ends."""
    followed = (value for node in cable.nodes for value in node if isinstance(value, Followed))
    known = cable.nodes and all(value.variable in series for value in followed)
    return cable.nodes if known else cable.ends


def rotations(angles: Floats) -> Floats:
    """R_z(ψ) R_y(θ) R_x(φ), (…, 3, 3) [1], of roll, pitch, yaw `angles` (…, 3) [rad]."""
    (cx, sx), (cy, sy), (cz, sz) = ((np.cos(a), np.sin(a)) for a in np.moveaxis(angles, -1, 0))
    rows = [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quaternions(attitudes: Floats) -> Floats:
    """(T, N, 4) [1] of `attitudes` (T, N, 3, 3) [1], scalar first, without jumps of the sign."""
    from scipy.spatial.transform import Rotation

    frames, count = attitudes.shape[:2]
    found = Rotation.from_matrix(attitudes.reshape(-1, 3, 3)).as_quat().reshape(frames, count, 4)
    found = found[..., [3, 0, 1, 2]]
    for k in range(1, frames):
        turned = (found[k] * found[k - 1]).sum(axis=-1) < 0
        found[k, turned] *= -1
    return found


def _finite_rows(scene: Scene, time: Floats, series: Mapping[str, Floats]) -> int:
    """Number of rows before the first that is not finite. InputError for missing variables."""
    values = [value for body in scene.bodies for value in body.motion]
    values += [value for cable in scene.cables for end in cable.ends for value in end]
    names = [value.variable for value in values if isinstance(value, Followed)]
    missing = sorted({name for name in names if name not in series})
    if missing:
        message = f"it has no {first_of(map(repr, missing), 1)}, which the animation follows"
        raise InputError.single(message, "record them: run with --animate, or without --variables")
    nodes = (v for cable in scene.cables for node in _nodes(cable, series) for v in node)
    names += [value.variable for value in nodes if isinstance(value, Followed)]
    finite = np.ones(len(time), bool)
    for name in dict.fromkeys(names):
        finite &= np.isfinite(np.asarray(series[name], float))
    rows = len(time) if finite.all() else int(np.argmin(finite))
    if rows < 2:
        told = {0: "no rows", 1: "one row"}[rows]
        message = f"it has {told} of finite numbers: there is no motion to be shown"
        raise InputError.single(message, "run it for at least one step")
    return rows


def packed(columns: Floats) -> dict[str, object]:
    """Data for player.js of `columns` (T, N) [m, 1]: those that vary as 16-bit integers by frames.

    The value of one is offset + scale·n; the others keep their `constants`.
    """
    low, high = columns.min(axis=0), columns.max(axis=0)
    varying = np.flatnonzero(high > low)
    offsets, scales = low[varying], (high - low)[varying] / 65535
    whole = np.round((columns[:, varying] - offsets) / scales).astype("<u2")
    return {
        "frames": len(columns),
        "constants": [float(f"{value:.9g}") for value in low],
        "varying": varying.tolist(),
        "offsets": offsets.tolist(),
        "scales": scales.tolist(),
        "poses": base64.b64encode(whole.tobytes()).decode("ascii"),
    }
