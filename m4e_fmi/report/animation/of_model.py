"""Scenes of models: bodies, joints and loads between points.

A planar model has its bodies as flat outlines near y = 0, which hold all their points. One in space
has their shapes or boxes with their moments of inertia, and sticks from their centres of gravity to
all that holds them.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.model import Mesh, Model
from m4e_fmi.model.elements import inertia_of, parameter_values, quantity, vector
from m4e_fmi.model.expression import Values
from m4e_fmi.model.shapes import MOST_TRIANGLES
from m4e_fmi.multibody import Topology, topology
from m4e_fmi.multibody.topology import TreeLink
from m4e_fmi.report.animation.scene import (
    COORDINATES,
    GROUND,
    Body,
    Followed,
    Rope,
    Scene,
    Spot,
    Triple,
)
from m4e_fmi.report.drawing.hulls import Hull, fitted, inertia_box, shape_hull
from m4e_fmi.report.drawing.parts import ranks

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation

THICKNESS = 0.06
"""Of a planar body's outline, relative to the size of the model."""
LAYER = 1e-4
"""Distance of planar bodies from those that hold them, towards the eye, in sizes of the model."""
IN_PLANE = ("x", "z", "theta")
AXIS = 0.22
"""Half the length of a joint's axis, relative to the size of the model."""
AROUND = 2 * np.pi * np.arange(32) / 32
CENTRE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Places:
    """Where a model has its points and its joints, with `values` of its parameters.

    Each joint has its link, its point on the child and that on the parent; free ones are left out.
    """

    tree: Topology
    values: Values
    points: dict[str, Spot]
    joints: tuple[tuple[TreeLink, Spot, Spot], ...]

    def numbers(self, owner: object, field: str) -> Triple:
        """A vector of an element in world axes, at q = 0."""
        found = [float(part.evaluate(self.values)) for part in vector(owner, field)]
        x, y, z = found if len(found) == 3 else (found[0], 0.0, found[1])
        return x, y, z

    def held(self, body: int) -> list[Triple]:
        """The places of a body where something holds it."""
        ends = [end for _, spot, base in self.joints for end in (spot, base)]
        return list(dict.fromkeys(e.at for e in (*ends, *self.points.values()) if e.body == body))


def places_of(model: Model, given: Mapping[str, float]) -> Places:
    """The places of a model; parameters that are not `given` have its own values."""
    tree, values = topology(model), parameter_values(model.parameters)
    values.update((name, value) for name, value in given.items() if name in values)
    found = Places(tree, values, {}, ())
    points = {
        name: Spot(tree.index(point.body), found.numbers(point, "at"))
        for name, point in model.points.items()
    }
    joints = []
    for k, link in enumerate(tree.links):
        if not link.joint_type.is_free:
            x, y, z = found.numbers(link.joint, "joint_to_child")
            base = Spot(link.parent, found.numbers(link.joint, "parent_to_joint"))
            joints.append((link, Spot(k, (-x, -y, -z)), base))
    return replace(found, points=points, joints=tuple(joints))


def scene_of_model(
    model: Model,
    component: str = "",
    values: Mapping[str, float] | None = None,
    *,
    most: int = MOST_TRIANGLES,
) -> Scene:
    """The scene of a model that is `component` of a system, or all there is.

    Parameters that are not among `values` have those of the model. Meshes have `most` triangles
    together.
    """
    prefix = f"{component}." if component else ""
    found, planar = places_of(model, values or {}), model.dimensions == 2
    links = found.tree.links
    sticks = [found.held(k) for k in range(len(links))]
    arms = [math.hypot(*end) for ends in sticks for end in ends]
    if planar:
        hulls = _outlines(model, found, sticks, 2.0 * max(arms, default=0.0))
        size = 0.0  # no axes are drawn
    else:
        bodies = [model.bodies[link.body] for link in links]
        most = most // max(1, sum(isinstance(body.shape, Mesh) for body in bodies))
        hulls = [
            shape_hull(body.shape, found.values, most)
            if body.shape
            else inertia_box(body, found.values)
            for body in bodies
        ]
        arms += [math.hypot(*spot.at) for spot in found.points.values() if spot.body == GROUND]
        largest = max(float(np.abs(hull.vertices).max()) for hull in hulls)
        size = max(arms, default=0.0) or largest or 1.0
        hulls = [
            hull if body.shape else fitted(hull, size)
            for body, hull in zip(bodies, hulls, strict=True)
        ]
    moving = IN_PLANE if planar else COORDINATES
    return Scene(
        title=model.name,
        description=" ".join(model.description.split()),
        planar=planar,
        bodies=tuple(
            Body(
                f"{prefix}{link.body}",
                tuple(
                    Followed(f"{prefix}body.{link.body}.{part}") if part in moving else 0.0
                    for part in COORDINATES
                ),
                (hull,),
                () if planar else tuple(ends),
            )
            for link, hull, ends in zip(links, hulls, sticks, strict=True)
        ),
        hinges=tuple((spot, link.joint_type.symbol == "square") for link, spot, _ in found.joints),
        axes=tuple(_lines(found, 0.0 if planar else AXIS * size)),
        ropes=_ropes(model, found),
    )


def scene_of_simulation(model: Model, simulation: Simulation, component: str = "") -> Scene:
    """The scene of `scene_of_model` with the parameters that were simulated."""
    values = {v.name: v.start for v in simulation.program.parameters}
    return scene_of_model(model, component, values)


def _outlines(
    model: Model, found: Places, sticks: Sequence[Sequence[Triple]], size: float
) -> list[Hull]:
    """Flat surfaces of bodies: those farther from the ground are thinner and nearer to the eye.

    A body that slides is a block along the direction of its joint. Of a model without arms the
    largest radius of gyration counts, of bodies with known mass and inertia, else 1 m.
    """
    from scipy.spatial import ConvexHull

    bodies = (body for body in model.bodies.values() if not body.is_neutral)
    radius = THICKNESS * size or max(
        (float(inertia_of(body)[0].evaluate(found.values))
         / float(quantity(body, "mass").evaluate(found.values)) for body in bodies), default=0.0
    ) ** 0.5 or 1.0  # fmt: skip
    hulls, depths = [], dict[int, int]()
    for k, link in enumerate(found.tree.links):
        depths[k] = depth = 1 + depths.get(link.parent, 0)
        round_corners = np.column_stack([np.cos(AROUND), np.sin(AROUND)])
        shape = radius * max(0.6, 0.88 ** (depth - 1)) * round_corners
        if link.joint_type.has_direction:
            x, _, z = found.numbers(link.joint, "direction")
            corners = radius * np.array([[-1.8, -1.2], [1.8, -1.2], [1.8, 1.2], [-1.8, 1.2]])
            shape = corners @ np.array([[x, z], [-z, x]]) / math.hypot(x, z)
        places = np.array([CENTRE, *sticks[k]])[:, ::2]
        hull = ConvexHull((places[:, None] + shape).reshape(-1, 2))
        corners = np.insert(hull.points[hull.vertices], 1, -LAYER * size * depth, 1)
        hulls.append(Hull(corners, (tuple(range(len(corners))),)))
    return hulls


def _lines(found: Places, reach: float) -> Iterator[tuple[Spot, Spot, bool]]:
    """Lines from parent to child where joints slide, and axes in space; True for what turns.

    Directions are fixed in the parent, and so is the first of two axes.
    """
    for link, spot, base in found.joints:
        kind = link.joint_type
        if kind.has_direction or kind.symbol == "sleeve":
            yield base, spot, False
        if not reach:
            continue
        for name in ("direction", *kind.axes) if kind.has_direction else kind.axes:
            fixed = name == "direction" or (name == "axis" and len(kind.axes) > 1)
            along = np.array(found.numbers(link.joint, name))
            half = reach * along / np.linalg.norm(along)
            middle = base if fixed else spot
            yield _moved(middle, -half), _moved(middle, half), name != "direction"


def _moved(spot: Spot, way: np.ndarray) -> Spot:
    x, y, z = (np.array(spot.at) + way).tolist()
    return Spot(spot.body, (x, y, z))


def _ropes(model: Model, found: Places) -> tuple[Rope, ...]:
    """Loads between two points; in the plane also those between two bodies, where these meet."""
    meet = {(a.body, b.body): (a, b) for _, spot, base in found.joints
            for a, b in ((spot, base), (base, spot))}  # fmt: skip
    ropes = list[tuple[str, tuple[Spot, Spot]]]()
    for load in model.loads.values():
        if hasattr(load, "points"):
            first, second = (found.points[name] for name in load.points)
            ropes.append((load.type, (first, second)))
        elif hasattr(load, "bodies") and model.dimensions == 2:
            one, other = (found.tree.index(name) for name in load.bodies)
            centres = Spot(one, CENTRE), Spot(other, CENTRE)
            ropes.append((load.type, meet.get((one, other), centres)))
    aside = ranks([(kind, frozenset[Hashable](ends)) for kind, ends in ropes])
    return tuple(Rope(kind, ends, rank) for (kind, ends), rank in zip(ropes, aside, strict=True))


def shifted(scene: Scene, bodies: int) -> Scene:
    """The same, with bodies that are counted from this number on."""

    def moved(spot: Spot) -> Spot:
        return spot if spot.body == GROUND else replace(spot, body=spot.body + bodies)

    return replace(
        scene,
        hinges=tuple((moved(spot), weld) for spot, weld in scene.hinges),
        axes=tuple((moved(first), moved(second), turns) for first, second, turns in scene.axes),
        ropes=tuple(
            replace(rope, ends=(moved(rope.ends[0]), moved(rope.ends[1]))) for rope in scene.ropes
        ),
    )
