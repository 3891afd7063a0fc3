"""Scenes of models: bodies, joints and loads between points.

A planar model has its bodies as flat outlines near y = 0. One in space has their shapes or boxes
with their moments of inertia, and sticks from their centres of gravity to all that holds them.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.model import Mesh, Model
from m4e_fmi.model.elements import inertia_of, parameter_values, quantity, vector
from m4e_fmi.model.loads import Bushing, TensionDamper, TensionSpring, TensionStop
from m4e_fmi.model.shapes import MOST_TRIANGLES
from m4e_fmi.multibody import topology
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
    Value,
)
from m4e_fmi.report.drawing.hulls import Hull, fitted, inertia_box, shape_hull
from m4e_fmi.report.drawing.parts import ranks
from m4e_fmi.report.drawing.scene import Anchor, PlanarScene, unmoved_scene

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation

THICKNESS = 0.06
"""Of a planar body's outline, relative to the size of the model."""
LAYER = 1e-4
"""Distance of planar bodies from those that hold them, towards the eye, in sizes of the model."""
IN_PLANE = ("x", "z", "theta")
AXIS = 0.22
"""Half the length of a joint's axis, relative to the size of the model."""


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
    if model.dimensions == 2:
        return _planar(model, unmoved_scene(model, values or {}), prefix)
    return _spatial(model, prefix, values or {}, most)


def scene_of_simulation(model: Model, simulation: Simulation, component: str = "") -> Scene:
    """The scene of `scene_of_model` with the parameters that were simulated."""
    values = {v.name: v.start for v in simulation.program.parameters}
    return scene_of_model(model, component, values)


def _motion(prefix: str, body: str, moving: Sequence[str]) -> tuple[Value, ...]:
    return tuple(
        Followed(f"{prefix}body.{body}.{part}") if part in moving else 0.0 for part in COORDINATES
    )


def _ropes(ropes: Sequence[tuple[str, tuple[Spot, Spot]]]) -> tuple[Rope, ...]:
    aside = ranks([(kind, frozenset[Hashable](ends)) for kind, ends in ropes])
    return tuple(Rope(kind, ends, rank) for (kind, ends), rank in zip(ropes, aside, strict=True))


def _spatial(model: Model, prefix: str, given: Mapping[str, float], most: int) -> Scene:
    tree, values = topology(model), parameter_values(model.parameters)
    values.update((name, value) for name, value in given.items() if name in values)

    def numbers(owner: object, field: str) -> Triple:
        found = [float(part.evaluate(values)) for part in vector(owner, field)]
        return (found[0], found[1], found[2]) if len(found) == 3 else (0.0, 0.0, 0.0)

    points = {
        name: Spot(tree.index(point.body), numbers(point, "at"))
        for name, point in model.points.items()
    }
    held, joints = [], []
    for k, link in enumerate(tree.links):
        if not link.joint_type.is_free:
            x, y, z = numbers(link.joint, "joint_to_child")
            spot = Spot(k, (-x, -y, -z))
            base = Spot(link.parent, numbers(link.joint, "parent_to_joint"))
            joints.append((link, spot, base))
            held += [spot, base]
    sticks: list[dict[Triple, None]] = [{} for _ in tree.links]
    for spot in (*held, *points.values()):
        if spot.body != GROUND:
            sticks[spot.body][spot.at] = None
    bodies = [model.bodies[link.body] for link in tree.links]
    most = most // max(1, sum(isinstance(body.shape, Mesh) for body in bodies))
    hulls = [
        shape_hull(body.shape, values, most) if body.shape else inertia_box(body, values)
        for body in bodies
    ]
    arms = [math.hypot(*end) for ends in sticks for end in ends]
    arms += [math.hypot(*spot.at) for spot in points.values() if spot.body == GROUND]
    largest = max(float(np.abs(hull.vertices).max()) for hull in hulls)
    size = max(arms, default=0.0) or largest or 1.0

    def lines() -> Iterator[tuple[Spot, Spot, bool]]:
        """Axes of joints, and from parent to child where these slide; True for what turns."""
        for link, spot, base in joints:
            if link.joint_type.has_direction or link.joint_type.symbol == "sleeve":
                yield base, spot, False
            for name, middle in _axes(link, spot, base):
                along = np.array(numbers(link.joint, name))
                half = AXIS * size * along / np.linalg.norm(along)
                yield _moved(middle, -half), _moved(middle, half), name != "direction"

    return Scene(
        title=model.name,
        description=" ".join(model.description.split()),
        planar=False,
        bodies=tuple(
            Body(
                f"{prefix}{link.body}",
                _motion(prefix, link.body, COORDINATES),
                (hull if body.shape else fitted(hull, size),),
                tuple(ends),
            )
            for link, body, hull, ends in zip(tree.links, bodies, hulls, sticks, strict=True)
        ),
        hinges=tuple((spot, link.joint_type.symbol == "square") for link, spot, _ in joints),
        axes=tuple(lines()),
        ropes=_ropes(
            [
                (load.type, (points[load.points[0]], points[load.points[1]]))
                for load in model.loads.values()
                if isinstance(load, TensionSpring | TensionDamper | TensionStop | Bushing)
            ]
        ),
    )


def _axes(link: TreeLink, spot: Spot, base: Spot) -> Iterator[tuple[str, Spot]]:
    """The fields of a joint that are directions, each with the point that its line leads through.

    Directions are fixed in the parent, and so is the first of two axes.
    """
    kind = link.joint_type
    if kind.has_direction:
        yield "direction", base
    for name in kind.axes:
        yield name, base if name == "axis" and len(kind.axes) > 1 else spot


def _moved(spot: Spot, way: np.ndarray) -> Spot:
    x, y, z = (np.array(spot.at) + way).tolist()
    return Spot(spot.body, (x, y, z))


def _planar(model: Model, shown: PlanarScene, prefix: str) -> Scene:
    size = _size(shown)
    radius = THICKNESS * size or _gyration(model)

    def flat(body: int) -> Hull:
        corners = np.insert(shown.outline(body, radius), 1, -LAYER * size * shown.depths[body], 1)
        return Hull(corners, (tuple(range(len(corners))),))

    joints = [joint for joint in shown.joints if not joint.type.is_free]
    return Scene(
        title=model.name,
        description=shown.description,
        planar=True,
        bodies=tuple(
            Body(f"{prefix}{name}", _motion(prefix, name, IN_PLANE), (flat(k),))
            for k, name in enumerate(shown.bodies)
        ),
        hinges=tuple((_spot(joint.child), joint.type.symbol == "square") for joint in joints),
        axes=tuple(
            (_spot(joint.parent), _spot(joint.child), False) for joint in joints if joint.direction
        ),
        ropes=_ropes([(tie.kind, (_spot(tie.ends[0]), _spot(tie.ends[1]))) for tie in shown.ties]),
    )


def _size(shown: PlanarScene) -> float:
    """A length of the model [m]: twice the longest arm from a centre of gravity; 0 if none."""
    arms = [np.hypot(*np.array(held).T).max() for held in shown.attachments]
    return 2.0 * float(max(arms, default=0.0))


def _gyration(model: Model) -> float:
    """The largest radius of gyration [m] of bodies with known mass and inertia, else 1 m."""
    values = parameter_values(model.parameters)
    bodies = (body for body in model.bodies.values() if not body.is_neutral)
    squares = (
        float(inertia_of(body)[0].evaluate(values)) / float(quantity(body, "mass").evaluate(values))
        for body in bodies
    )
    return max(squares, default=0.0) ** 0.5 or 1.0


def _spot(anchor: Anchor) -> Spot:
    x, z = anchor.at
    return Spot(anchor.body, (x, 0.0, z))


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
