"""Inputs of the bodies' motions, and their displacements in the axes of the heading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.geometry.motions import PLANE, SPACE, SWAY, YAW
from m4e_adapters.hydrodynamics.heading import (
    Axes,
    Heading,
    Number,
    reference_places,
)
from m4e_fmi.program import Recorder, Scalar, Variable, atan2

Vector = list[Scalar | float]

YAW_PLACE = SPACE.index(YAW)
ANGLES = ", R = R_z(psi) R_y(theta) R_x(phi) from body to world axes"


@dataclass(frozen=True)
class Motions:
    """Of all bodies, displacement and velocity in the axes of the heading, in space `axes`.

    `position` are the inputs, those of the plane relative to the reference pose. In space `places`
    are the reference places (x, y) [m] of the bodies, in world axes.
    """

    displacement: Vector
    velocity: Vector
    position: Vector
    axes: Axes | None = None
    places: Sequence[tuple[Number, Number]] = ()

    def offsets(self, coefficients: Coefficients) -> list[tuple[Number, Number]]:
        """Of each body the way (x, y) [m] in the world from its reference place."""
        first = [self.position[coefficients.own(k)] for k in range(len(coefficients.bodies))]
        if not self.places:
            return [(own[0], 0.0) for own in first]
        pairs = zip(first, self.places, strict=True)
        return [(own[0] - x, own[1] - y) for own, (x, y) in pairs]


def record_motions(recorder: Recorder, coefficients: Coefficients, heading: Heading) -> Motions:
    """Inputs of all bodies, and in space the heading."""
    if coefficients.dimensions == 2:
        position, velocity = _record_inputs(recorder, coefficients, heading)
        return Motions(position, velocity, position)
    text = "heading of the reference pose: angle of the hulls' x axis, from +X towards +Y"
    start = math.radians(heading.angle)
    limits = (start, start) if heading.fixed else (-math.inf, math.inf)
    given = Variable(
        "heading", "rad", text, start=start, display_unit="deg",
        minimum=limits[0], maximum=limits[1],
    )  # fmt: skip
    axes = Axes.at(recorder.parameter(given))
    position, velocity = _record_inputs(recorder, coefficients, heading)
    places = reference_places(coefficients.centers, axes)
    displacement = _in_heading_axes(position, axes, places, coefficients.centers)
    return Motions(displacement, axes.from_world(velocity), position, axes, places)


def _record_inputs(
    recorder: Recorder, coefficients: Coefficients, heading: Heading
) -> tuple[Vector, Vector]:
    """Inputs of all bodies, positions and velocities."""
    bodies = range(len(coefficients.bodies))
    motions = [_record_motion(recorder, coefficients, k, heading) for k in bodies]
    position, velocity = ([*chain(*part)] for part in zip(*motions, strict=True))
    return position, velocity


def _record_motion(
    recorder: Recorder, coefficients: Coefficients, k: int, heading: Heading
) -> tuple[Vector, Vector]:
    """Inputs of a body, positions and velocities.

    Those of the plane are relative to the reference pose, with the centre of gravity there.
    """
    body, motions = coefficients.bodies[k], coefficients.body_motions
    in_plane = coefficients.dimensions == 2
    x, y, z = _start(coefficients, k, heading)
    starts = {"x": x, "y": y, "z": z, "psi": math.radians(heading.angle)}
    position: Vector = []
    velocity: Vector = []
    for motion in motions:
        start = starts.get(motion.position, 0.0)
        name = f"{motion.position} of the centre of gravity"
        text = f"{motion.name} angle" if motion.is_rotation else name
        text += ", world frame" if motion in PLANE or motion is SWAY else ANGLES
        variable = Variable(f"{body}.{motion.position}", motion.unit, text, start=start)
        value = recorder.input(variable)
        position.append(value - start if in_plane else value)
    for motion in motions:
        text = f"rate of {body}.{motion.position}, world frame"
        if motion.is_rotation and not in_plane:
            text = f"angular velocity about +{'XYZ'[motions.index(motion) - 3]}, world frame"
        variable = Variable(f"{body}.{motion.velocity}", f"{motion.unit}/s", text)
        velocity.append(recorder.input(variable))
    return position, velocity


def _start(coefficients: Coefficients, k: int, heading: Heading) -> tuple[float, float, float]:
    """The centre of gravity (x, y, z) [m] of a body in the reference pose."""
    centers = coefficients.places
    x, y = centers[k, :2]
    if heading.angle:
        x, y = reference_places(centers, Axes.at(math.radians(heading.angle)))[k]
    return float(x), float(y), float(centers[k, 2])


def _in_heading_axes(
    position: Vector, axes: Axes, places: list[tuple[Number, Number]], centers: np.ndarray
) -> Vector:
    """Displacements from the reference pose, in the axes of the heading."""
    found: Vector = []
    for k, (x, y) in enumerate(places):
        own = position[6 * k : 6 * k + 6]
        moved = axes.from_world([own[0] - x, own[1] - y, own[2] - float(centers[k, 2]), 0, 0, 0])
        yaw = Axes.at(own[YAW_PLACE] - axes.angle)
        roll, pitch = yaw.to_world([0, 0, 0, own[3], own[4], 0])[3:5]
        found += [*moved[:3], roll, pitch, atan2(yaw.sine, yaw.cosine)]
    return found
