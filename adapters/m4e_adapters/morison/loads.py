"""Loads on a member, summed over its points.

With P the projection across the member, e the unit vector along it, u and u̇ velocity and local
acceleration of the water, v the velocity of the member, w = u − v, per length:

    f = ρ π D²/4 C_M P u̇ + ½ ρ D C_D |P w| P w + ½ ρ π D C_T |e·w| (e·w) e

and on each end, along the axis, ρ π D³/12 C_AE e·u̇ + ½ ρ π D²/4 C_DE |e·w| e·w. The acceleration of
the member belongs to `added_mass`.

The pressure on a buoyant member, with flat ends, is that of the still water up to the surface of
the waves (`buoyancy`), and that of the waves: across the member it is a part of C_M, along it
ρ π D²/4 (e·u̇) e. At the surface both together are 0, as the pressure there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedFlow
from m4e_adapters.morison.buoyancy import buoyancy
from m4e_adapters.morison.config import Member
from m4e_adapters.morison.motion import Axis, BodyMotion, axis_of
from m4e_adapters.morison.strips import (
    Coefficients,
    LoadPoint,
    boundaries,
    load_points,
)
from m4e_adapters.morison.vectors import (
    ZERO,
    Number,
    Vector,
    across,
    add,
    cross,
    difference,
    dot,
    scaled,
)
from m4e_fmi.program import Recorder, Variable, sqrt

NONE = 1e-9  # [m/s], which guards a root
Load = tuple[Vector, Vector]
"""A force [N] and its moment about the centre of the body [N.m]."""
NO_LOAD: Load = (ZERO, ZERO)


@dataclass(frozen=True)
class MemberLoad:
    """Loads of drag, inertia and buoyancy; wet length [m]."""

    drag: Load
    inertia: Load
    buoyancy: Load
    wet_length: Number

    @property
    def force(self) -> Vector:
        """Of all [N]."""
        return add(self.drag[0], self.inertia[0], self.buoyancy[0])


def joined(one: Load, other: Load) -> Load:
    """Their sum."""
    return add(one[0], other[0]), add(one[1], other[1])


def acting_at(arm: Vector, force: Vector) -> Load:
    """A `force` [N] at an `arm` [m]."""
    return force, cross(arm, force)


def record_coefficients(recorder: Recorder, name: str, member: Member) -> Coefficients:
    """The tunable parameters `<member>.drag`, `.tangential_drag`, `.inertia`, `.end_drag`."""

    def parameter(what: str, text: str, start: float) -> Number:
        variable = Variable(f"{name}.{what}", "1", text, start=start, minimum=0.0, tunable=True)
        return recorder.parameter(variable)

    text = f"drag coefficient of the flow along {name}"
    return Coefficients(
        drag=parameter("drag", f"drag coefficient of the flow across {name}", member.drag),
        tangential_drag=parameter("tangential_drag", text, member.tangential_drag),
        inertia=parameter("inertia", f"inertia coefficient of {name}", member.inertia_coefficient),
        end_drag=parameter("end_drag", f"drag coefficient of each end of {name}", member.end_drag)
        if member.end_drag > 0.0
        else 0.0,
    )


def member_load(
    member: Member,
    known: Coefficients,
    body: BodyMotion,
    flow: RecordedFlow,
    surface: float,
) -> MemberLoad:
    """The load on a member of a body at its pose and velocity, in waves of `surface` [m]."""
    axis, density = axis_of(member, body), flow.water.density
    drag, inertia, wet = NO_LOAD, NO_LOAD, 0.0
    places = boundaries(member, surface)
    for point in load_points(member, known, axis, body, places, flow.elevation, density):
        water = flow.at(add(body.place, point.arm))
        relative = difference(water.velocity, body.velocity_at(point.arm))
        drag = joined(drag, drag_at(point, axis, relative))
        inertia = joined(inertia, inertia_at(point, axis, water.acceleration))
        wet = wet + point.length
    if not flow.waves:
        places = [0.0, member.length]
    weight = density * flow.water.gravity
    where = [add(body.place, axis.at(s)) for s in places]
    levels = [flow.elevation(x, y) for x, y, _ in where] if member.is_buoyant else []
    lifted = buoyant_load(member, axis, body, places, levels, weight)
    return MemberLoad(drag, inertia, lifted, wet)


def drag_at(point: LoadPoint, axis: Axis, relative: Vector) -> Load:
    """Of the velocity w [m/s] of the water `relative` to a point."""
    normal, tangential = across(relative, axis.along), dot(relative, axis.along)
    size = sqrt(dot(normal, normal) + NONE**2)
    skin = point.drag_along * abs(tangential) * tangential
    return acting_at(
        point.arm, add(scaled(point.drag_across * size, normal), scaled(skin, axis.along))
    )


def inertia_at(point: LoadPoint, axis: Axis, acceleration: Vector) -> Load:
    """Of an `acceleration` [m/s2] of the water."""
    normal = scaled(point.mass_across, across(acceleration, axis.along))
    along = scaled(point.mass_along * dot(acceleration, axis.along), axis.along)
    return acting_at(point.arm, add(normal, along))


def buoyant_load(
    member: Member,
    axis: Axis,
    body: BodyMotion,
    places: Sequence[float],
    levels: Sequence[Number],
    weight: float,
) -> Load:
    """Of water of the `weight` ρ g [N/m3] up to its surface, of the `levels` [m] at `places` [m].

    The surface is straight between them.
    """
    if not member.is_buoyant:
        return NO_LOAD
    arms = [axis.at(s) for s in places]
    depths = [level - (body.place[2] + arm[2]) for level, arm in zip(levels, arms, strict=True)]
    total = NO_LOAD
    ends = zip(pairwise(arms), pairwise(depths), pairwise(places), strict=True)
    for two, deep, (low, high) in ends:
        part = buoyancy(
            two, axis.along, deep, radius=0.5 * member.diameter, length=high - low, weight=weight
        )
        total = joined(total, part)
    return total
