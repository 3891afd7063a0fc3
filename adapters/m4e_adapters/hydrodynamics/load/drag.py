"""Drag of bodies, against still water or against the water's velocity u at a body:

    F = −c |v − u| (v − u) − d (v − u)

motion by motion, in the axes of the heading, v the velocity of the centre of gravity. u is that of
waves and current at the reference place of that centre, where the excitation is that of the waves
too; waves by linear theory, above still water that of its level. Rotations have u = 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Current, Drag
from m4e_adapters.hydrodynamics.heading import Axes, Number, reference_places
from m4e_adapters.hydrodynamics.load.motions import Motions
from m4e_adapters.hydrodynamics.seas.water.current import record_current
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Triple
from m4e_fmi.program import Recorder, Scalar, Variable

Vector = list[Scalar | float]
UNITS = {True: "N.m.s/rad", False: "N.s/m"}
"""Of linear drag, by whether the motion is a rotation."""


@dataclass(frozen=True)
class InWater:
    """Body number `body` whose drag is against the moving water, at the height `z` [m]."""

    body: int
    z: float

    def place(
        self,
        coefficients: Coefficients,
        reference: Axes | None,
        offsets: Sequence[tuple[Number, Number]],
    ) -> Triple:
        """The place (x, y, z) [m] of the body, whose heading has the axes `reference`.

        The reference place, or that place and the body's `offsets` (x, y) [m] from it.
        """
        x, y, _ = coefficients.places[self.body].tolist()
        if reference is not None:
            x, y = reference_places(coefficients.centers, reference)[self.body]
        if offsets:
            x, y = x + offsets[self.body][0], y + offsets[self.body][1]
        return x, y, self.z


def record_water_velocity(
    recorder: Recorder,
    coefficients: Coefficients,
    current: Current | None,
    moved: Motions,
    in_water: Sequence[InWater],
    of_waves: Sequence[Triple],
) -> dict[int, Vector]:
    """Velocity of the water by body number and motion, in the axes of the heading.

    `of_waves` are those of the waves [m/s] at the bodies `in_water`, in world axes.
    """
    if not in_water:
        return {}
    in_space = coefficients.dimensions == 3
    flow = record_current(recorder, current, depth=coefficients.depth, in_space=in_space)
    found: dict[int, Vector] = {}
    for body, (u, v, w) in zip(in_water, of_waves, strict=True):
        x, y = flow.velocity(body.z)
        vector: Vector = [u + x, v + y, w, 0.0, 0.0, 0.0] if in_space else [u + x, w, 0.0]
        found[body.body] = moved.axes.from_world(vector) if moved.axes else vector
    return found


def record_drag(
    recorder: Recorder,
    coefficients: Coefficients,
    drag: Mapping[str, Drag],
    velocity: Vector,
    water: Mapping[int, Vector],
) -> Vector:
    """Drag on all motions; its coefficients are parameters, those of `drag` by body.

    Linear drag of motions that have none is left out. `water` is the velocity of the water.
    """
    force: Vector = []
    for k, body in enumerate(coefficients.bodies):
        given, own = drag.get(body, Drag()), velocity[coefficients.own(k)]
        streams = water.get(k, [0.0] * len(own))
        for motion, v, u in zip(coefficients.body_motions, own, streams, strict=True):
            relative = v - u
            variable = Variable(
                f"{body}.drag_{motion.name}",
                motion.drag_unit,
                f"quadratic drag in {motion.name}: force -c |v| v",
                start=getattr(given, motion.name),
                minimum=0.0,
                tunable=True,
            )
            total = -recorder.parameter(variable) * abs(relative) * relative
            start = getattr(given.linear, motion.name)
            if start:
                text = f"linear drag in {motion.name}: force -c v"
                name = f"{body}.linear_drag_{motion.name}"
                variable = Variable(
                    name, UNITS[motion.is_rotation], text, start=start, minimum=0.0, tunable=True
                )
                total = total - recorder.parameter(variable) * relative
            force.append(total)
    return force
