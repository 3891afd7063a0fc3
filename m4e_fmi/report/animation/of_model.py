"""Scenes of models: bodies, joints and loads between points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.model import Model
from m4e_fmi.model.elements import inertia_of, parameter_values, quantity
from m4e_fmi.model.shapes import MOST_TRIANGLES
from m4e_fmi.report.animation.scene import COORDINATES, Body, Followed, Rope, Scene, Value
from m4e_fmi.report.drawing.parts import ranks
from m4e_fmi.report.drawing.scene import Anchor, unmoved_scene
from m4e_fmi.report.drawing.scene import Scene as PlanarScene
from m4e_fmi.report.drawing.space.hinges import GROUND, Spot
from m4e_fmi.report.drawing.space.hulls import Hull
from m4e_fmi.report.drawing.space.solids import Solids, solids

if TYPE_CHECKING:
    from m4e_fmi.simulate import Simulation

THICKNESS = 0.02
"""Of a planar body's outline, relative to the size of the model."""
IN_PLANE = ("x", "z", "theta")


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
        shown = unmoved_scene(model, values or {})
        return _planar(model, shown, prefix, THICKNESS * _size(shown) or _gyration(model))
    return _spatial(model, solids(model, values, most=most), prefix)


def scene_of_simulation(model: Model, simulation: Simulation, component: str = "") -> Scene:
    """The scene of `scene_of_model` with the parameters that were simulated."""
    return scene_of_model(model, component, simulated_parameters(simulation))


def simulated_parameters(simulation: Simulation) -> dict[str, float]:
    """The parameters of a simulation by name [SI]."""
    return {v.name: v.start for v in simulation.program.parameters}


def _motion(prefix: str, body: str, moving: Sequence[str]) -> tuple[Value, ...]:
    return tuple(
        Followed(f"{prefix}body.{body}.{part}") if part in moving else 0.0 for part in COORDINATES
    )


def _spatial(model: Model, shown: Solids, prefix: str) -> Scene:
    bodies = tuple(
        Body(f"{prefix}{name}", _motion(prefix, name, COORDINATES), (hull,), sticks)
        for name, hull, sticks in zip(shown.bodies, shown.hulls, shown.sticks, strict=True)
    )
    aside = _ranks([frozenset(rope.ends) for rope in shown.ropes])
    return Scene(
        title=model.name,
        description=shown.description,
        planar=False,
        bodies=bodies,
        hinges=tuple((hinge.spot, hinge.symbol == "square") for hinge in shown.hinges),
        axes=tuple((*ends, turns) for ends, turns in shown.lines),
        ropes=tuple(
            Rope(rope.kind, rope.ends, rank) for rope, rank in zip(shown.ropes, aside, strict=True)
        ),
    )


def _ranks(ends: Sequence[frozenset[Spot]]) -> Iterator[float]:
    """Of each rope its place among those with the same ends, counted from their middle."""
    counts, seen = Counter(ends), Counter[frozenset[Spot]]()
    for pair in ends:
        yield seen[pair] - (counts[pair] - 1) / 2
        seen[pair] += 1


def _planar(model: Model, shown: PlanarScene, prefix: str, radius: float) -> Scene:
    """Bodies as flat outlines at y = 0, of that `radius` [m] about their points."""
    bodies = tuple(
        Body(f"{prefix}{name}", _motion(prefix, name, IN_PLANE), (_flat(shown, k, radius),))
        for k, name in enumerate(shown.bodies)
    )
    joints = [joint for joint in shown.joints if not joint.type.is_free]
    return Scene(
        title=model.name,
        description=shown.description,
        planar=True,
        bodies=bodies,
        hinges=tuple((_spot(joint.child), joint.type.symbol == "square") for joint in joints),
        axes=tuple(
            (_spot(joint.parent), _spot(joint.child), False) for joint in joints if joint.direction
        ),
        ropes=tuple(
            Rope(tie.kind, (_spot(tie.ends[0]), _spot(tie.ends[1])), rank)
            for tie, rank in zip(shown.ties, ranks(shown), strict=True)
            if not tie.kind.startswith("torsion")
        ),
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


def _flat(shown: PlanarScene, body: int, radius: float) -> Hull:
    outline = shown.outline(body, radius)
    corners = np.insert(outline, 1, 0.0, axis=1)
    return Hull(corners, (tuple(range(len(corners))),))


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
