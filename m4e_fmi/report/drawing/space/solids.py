"""A model in space in numbers: what of each body is drawn, and where the bodies are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.errors import InputError
from m4e_fmi.model import Mesh, Model
from m4e_fmi.model.elements import parameter_values, vector
from m4e_fmi.model.loads import Bushing, TensionDamper, TensionSpring, TensionStop
from m4e_fmi.model.shapes import MOST_TRIANGLES
from m4e_fmi.multibody import Topology, topology
from m4e_fmi.program import Program
from m4e_fmi.report.drawing.scene import start_values
from m4e_fmi.report.drawing.space.hinges import GROUND, Hinge, Spot, Triple, hinge_of
from m4e_fmi.report.drawing.space.hulls import Hull, fitted, inertia_box, shape_hull
from m4e_fmi.simulate import Simulation

Floats = NDArray[np.float64]

AXIS = 0.22
"""Half the length of an axis, relative to the size of the scene."""


@dataclass(frozen=True)
class Rope:
    """A load along the line of two points."""

    kind: str
    ends: tuple[Spot, Spot]


@dataclass(frozen=True)
class Solids:
    """A model in space to be drawn; bodies in the order of their numbers.

    `hulls` are their shapes, or boxes with their moments of inertia, `sticks` the points of each
    body to which lines lead from its centre of gravity, all in body axes [m]. Axes of joints are
    drawn to `reach` [m] on both sides.
    """

    title: str
    description: str
    bodies: tuple[str, ...]
    hulls: tuple[Hull, ...]
    sticks: tuple[tuple[Triple, ...], ...]
    hinges: tuple[Hinge, ...]
    ropes: tuple[Rope, ...]
    points: Mapping[str, Spot]
    reach: float

    @property
    def lines(self) -> Iterator[tuple[tuple[Spot, Spot], bool]]:
        """Axes of joints, and from parent to child where these slide; True for what turns."""
        for hinge in self.hinges:
            if any(axis.slides for axis in hinge.axes) or hinge.symbol == "sleeve":
                yield (hinge.base, hinge.spot), False
            for axis in hinge.axes:
                yield axis.ends(self.reach), not axis.slides


@dataclass(frozen=True)
class Poses:
    """Places (T, N, 3) [m] and attitudes (T, N, 3, 3), body to world axes, of all bodies."""

    places: Floats
    attitudes: Floats

    def of(self, spot: Spot, frame: int = 0) -> Floats:
        """Where a point is, (3,) [m]."""
        at = np.array(spot.at)
        if spot.body == GROUND:
            return at
        return self.places[frame, spot.body] + self.attitudes[frame, spot.body] @ at

    def all_of(self, body: int, corners: Floats, frame: int = 0) -> Floats:
        """Where points of a body are, (n, 3) [m], that are `corners` (n, 3) [m] in its axes."""
        return self.places[frame, body] + corners @ self.attitudes[frame, body].T


def solids(
    model: Model, given: Mapping[str, float] | None = None, *, most: int = MOST_TRIANGLES
) -> Solids:
    """`model` in numbers, all meshes together of `most` triangles.

    Parameters that are not `given` have the values of the model.
    """
    tree, values = topology(model), parameter_values(model.parameters)
    values.update((name, value) for name, value in (given or {}).items() if name in values)

    def numbers(owner: object, field: str) -> Triple:
        given = [float(part.evaluate(values)) for part in vector(owner, field)]
        return (given[0], given[1], given[2]) if len(given) == 3 else (0.0, 0.0, 0.0)

    sticks: list[list[Triple]] = [[] for _ in tree.links]
    hinges: list[Hinge] = []
    for k, link in enumerate(tree.links):
        if link.joint_type.is_free:
            continue
        hinge = hinge_of(link, k, numbers)
        for end in (hinge.spot, hinge.base):
            if end.body != GROUND:
                sticks[end.body].append(end.at)
        hinges.append(hinge)
    points = {
        name: Spot(tree.index(point.body), numbers(point, "at"))
        for name, point in model.points.items()
    }
    for spot in points.values():
        if spot.body != GROUND:
            sticks[spot.body].append(spot.at)
    ropes = tuple(
        Rope(load.type, (points[load.points[0]], points[load.points[1]]))
        for load in model.loads.values()
        if isinstance(load, TensionSpring | TensionDamper | TensionStop | Bushing)
    )
    bodies = [model.bodies[link.body] for link in tree.links]
    most = most // max(1, sum(isinstance(body.shape, Mesh) for body in bodies))
    drawn = [
        shape_hull(body.shape, values, most) if body.shape else inertia_box(body, values)
        for body in bodies
    ]
    size = _size(drawn, sticks, points)
    hulls = (
        hull if body.shape else fitted(hull, size) for body, hull in zip(bodies, drawn, strict=True)
    )
    return Solids(
        title=model.name,
        description=" ".join(model.description.split()),
        bodies=tuple(link.body for link in tree.links),
        hulls=tuple(hulls),
        sticks=tuple(tuple(dict.fromkeys(ends)) for ends in sticks),
        hinges=tuple(hinges),
        ropes=ropes,
        points=points,
        reach=AXIS * size,
    )


def _size(
    hulls: Sequence[Hull],
    sticks: list[list[Triple]],
    points: Mapping[str, Spot],
) -> float:
    """A length of the scene [m]: that of its longest arm, or its largest body."""
    arms = [np.linalg.norm(end) for ends in sticks for end in ends]
    ground = [np.linalg.norm(spot.at) for spot in points.values() if spot.body == GROUND]
    longest = max((*arms, *ground), default=0.0)
    return float(longest) or max(float(np.abs(hull.vertices).max()) for hull in hulls) or 1.0


def start_poses(model: Model, program: Program) -> Poses:
    """Where the bodies are at the start values of the program."""
    values = {name: np.array([value]) for name, value in start_values(program).items()}
    return poses_of(topology(model), values)


def poses_of(tree: Topology, values: Mapping[str, Floats]) -> Poses:
    """Where bodies are, of `values`: series (T,) [m, rad] of x, y, z, phi, theta, psi of each."""
    places, attitudes = [], []
    for link in tree.links:
        x, y, z, phi, theta, psi = (
            np.asarray(values[f"body.{link.body}.{part}"], float)
            for part in ("x", "y", "z", "phi", "theta", "psi")
        )
        places.append(np.stack([x, y, z], axis=-1))
        attitudes.append(rotations(phi, theta, psi))
    return Poses(np.stack(places, axis=1), np.stack(attitudes, axis=1))


def rotations(phi: Floats, theta: Floats, psi: Floats) -> Floats:
    """R_z(ψ) R_y(θ) R_x(φ), (T, 3, 3) [1], of roll `phi`, pitch `theta`, yaw `psi`, (T,) [rad]."""
    (cx, sx), (cy, sy), (cz, sz) = ((np.cos(a), np.sin(a)) for a in (phi, theta, psi))
    rows = [
        [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
        [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def check_simulated(model: Model, simulation: Simulation, coordinate: str) -> None:
    """InputError if the simulation is not of this model: it lacks a coordinate of a body."""
    missing = [b for b in model.bodies if f"body.{b}.{coordinate}" not in simulation.values]
    if missing:
        message = f"the simulation of {simulation.program.name!r} has no body {missing[0]!r}"
        raise InputError.single(message, "give the model that was simulated")


def film_poses(model: Model, simulation: Simulation, frames: int) -> tuple[Floats, Poses]:
    """At most `frames` times (T,) [s], evenly spaced, and the poses at the nearest outputs.

    InputError if the simulation is of another model.
    """
    check_simulated(model, simulation, "y")
    count = min(frames, max(2, len(simulation.time)))
    times = np.linspace(simulation.time[0], simulation.time[-1], count)
    rows = np.interp(times, simulation.time, np.arange(len(simulation.time)))
    nearest = np.rint(rows).astype(int)
    values = {name: np.asarray(series)[nearest] for name, series in simulation.values.items()}
    return times, poses_of(topology(model), values)


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
