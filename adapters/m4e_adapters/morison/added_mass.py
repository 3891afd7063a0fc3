"""Added mass of members on a moving body, and what its turning adds.

The kinetic energy of the water is T = ½ ∫ m |P v|² ds, m = ρ π D²/4 C_A, over the part of the
members that is wet in the reference pose; it turns with the body. A strip exerts −m P d(P v)/dt,
whose power is −dT/dt, so that still water neither makes nor takes energy:

    −m P (a + α × r)                       in A, for whoever holds the body's mass
    m (e·v) (ω × e) − m P (ω × (ω × r))    here, `record_turning`

In a current the velocity along the member, e·v, is relative to it. An end has the energy
½ m (e·v)² and exerts −m d(e·v)/dt along e:

    −m e e·(a + α × r)                     in A
    −m e (v·(ω × e) + e·(ω × (ω × r)))     here
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from m4e_adapters.hydrodynamics.geometry.motions import (
    MOTIONS,
    mass_unit,
    places_in_space,
    point_in_space,
)
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedFlow
from m4e_adapters.morison.config import Member
from m4e_adapters.morison.motion import Axis, BodyMotion, axis_of
from m4e_adapters.morison.strips import end_mass
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
from m4e_fmi.program import Recorder, Variable

UNITS: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ROOT = 1.0 / math.sqrt(3.0)
Matrix = list[list[Number]]


def wet_masses(member: Member, density: float) -> Iterator[tuple[float, float]]:
    """Places s [m] along the member and masses [kg] of water with the moments up to s²."""
    (low, high) = _wet_in_reference(member)
    mass = density * 0.25 * math.pi * member.diameter**2 * member.added_mass * (high - low)
    if mass > 0.0:
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        yield middle - ROOT * half, 0.5 * mass
        yield middle + ROOT * half, 0.5 * mass


def wet_ends(member: Member, density: float) -> Iterator[tuple[float, float]]:
    """Places s [m] of ends that are under water, and their masses [kg] along the axis."""
    mass = end_mass(member, density)
    for s, end in zip((0.0, member.length), member.ends, strict=True):
        if mass > 0.0 and end[-1] <= 0.0:
            yield s, mass


def _wet_in_reference(member: Member) -> tuple[float, float]:
    """From and to [m] along the member, where it is below z = 0."""
    first, second = (point_in_space(end)[2] for end in member.ends)
    if first <= 0.0 and second <= 0.0:
        return 0.0, member.length
    if first > 0.0 and second > 0.0:
        return 0.0, 0.0
    crossing = member.length * first / (first - second)
    return (0.0, crossing) if first <= 0.0 else (crossing, member.length)


def added_mass(members: Mapping[str, Member], body: BodyMotion, density: float) -> Matrix:
    """A (6, 6) [kg, kg.m, kg.m2] about the centre of gravity at the pose now, world axes."""
    columns: list[list[Number]] = []
    masses = [
        (axis, axis.at(s), mass)
        for member in members.values()
        for axis in (axis_of(member, body),)
        for s, mass in wet_masses(member, density)
    ]
    ends = [
        (axis, axis.at(s), mass)
        for member in members.values()
        for axis in (axis_of(member, body),)
        for s, mass in wet_ends(member, density)
    ]
    for place in range(6):
        force, moment, unit = ZERO, ZERO, UNITS[place % 3]
        for axis, arm, mass in masses:
            moved = unit if place < 3 else cross(unit, arm)
            push = scaled(mass, across(moved, axis.along))
            force, moment = add(force, push), add(moment, cross(arm, push))
        for axis, arm, mass in ends:
            moved = unit if place < 3 else cross(unit, arm)
            push = scaled(mass * dot(moved, axis.along), axis.along)
            force, moment = add(force, push), add(moment, cross(arm, push))
        columns.append([*force, *moment])
    return [list(row) for row in zip(*columns, strict=True)]


def turning_load(member: Member, body: BodyMotion, flow: RecordedFlow) -> tuple[Vector, Vector]:
    """Force [N] and moment [N.m] of a member's added mass that turns with the body."""
    axis: Axis = axis_of(member, body)
    force, moment = ZERO, ZERO
    for s, mass in wet_masses(member, flow.water.density):
        arm = axis.at(s)
        x, y = flow.current.velocity(body.place[2] + arm[2])
        relative = difference(body.velocity_at(arm), (x, y, 0.0))
        turning = scaled(dot(axis.along, relative), cross(body.spin, axis.along))
        inwards = across(cross(body.spin, cross(body.spin, arm)), axis.along)
        push = scaled(mass, difference(turning, inwards))
        force, moment = add(force, push), add(moment, cross(arm, push))
    for s, mass in wet_ends(member, flow.water.density):
        arm = axis.at(s)
        x, y = flow.current.velocity(body.place[2] + arm[2])
        relative = difference(body.velocity_at(arm), (x, y, 0.0))
        inwards = dot(axis.along, cross(body.spin, cross(body.spin, arm)))
        turning = dot(relative, cross(body.spin, axis.along))
        push = scaled(-mass * (turning + inwards), axis.along)
        force, moment = add(force, push), add(moment, cross(arm, push))
    return force, moment


def publish_added_mass(recorder: Recorder, matrices: Mapping[str, Matrix], dimensions: int) -> None:
    """Outputs `added_mass[i,j]` of all bodies, which do not feel each other.

    Connections read from the descriptions which bodies rows are for.
    """
    motions, kept = MOTIONS[dimensions], places_in_space(dimensions)
    rows = [*chain.from_iterable(((body, k) for k in range(len(kept))) for body in matrices)]
    for i, (body, row) in enumerate(rows, start=1):
        for j, (other, column) in enumerate(rows, start=1):
            value = matrices[body][kept[row]][kept[column]] if body == other else 0.0
            text = f"{body} {motions[row].name} per acceleration in {other} {motions[column].name}"
            variable = Variable(
                f"added_mass[{i},{j}]",
                mass_unit(motions[row], motions[column]),
                f"added mass at infinite frequency: {text}",
            )
            recorder.output(variable, value)


def has_added_mass(members: Sequence[Member]) -> bool:
    """True if one of them has some in the reference pose."""
    parts = ((*wet_masses(member, 1.0), *wet_ends(member, 1.0)) for member in members)
    return any(parts)
