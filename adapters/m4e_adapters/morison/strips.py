"""Forces on a member, integrated over its wetted part.

Per length, with P the projection across the member, e the unit vector along it, u and u̇ velocity
and local acceleration of the water, v the velocity of the member, w = u − v:

    f = ρ π D²/4 C_M P u̇ + ½ ρ D C_D |P w| P w + ½ ρ π D C_T |e·w| (e·w) e

The acceleration of the member belongs to `added_mass`. Each segment is wet where the surface, taken
as straight between its ends, is above its lower side: it is cut there, and three Gauss points lie
in what is left. A section of a member that is not upright is wet in part, in proportion to the
height of the surface over its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import RecordedFlow
from m4e_adapters.morison.config import Member
from m4e_adapters.morison.motion import Axis, BodyMotion, axis_of
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
from m4e_fmi.program import Recorder, Variable, maximum, minimum, sqrt

POINTS = 3
UPRIGHT = 1e-6  # horizontal part of the axis of an upright member, so that its root has a slope
NONE = 1e-9  # [m] or [m/s], which guards quotients and roots


@dataclass(frozen=True)
class Coefficients:
    """C_D, C_T, C_M of a member [1], recorded."""

    drag: Number
    tangential_drag: Number
    inertia: Number


@dataclass(frozen=True)
class MemberLoad:
    """Forces [N] and moments [N.m] of drag and inertia about the body's centre; wet length [m]."""

    drag: tuple[Vector, Vector]
    inertia: tuple[Vector, Vector]
    wet_length: Number

    @property
    def force(self) -> Vector:
        """Of both [N]."""
        return add(self.drag[0], self.inertia[0])


def record_coefficients(recorder: Recorder, name: str, member: Member) -> Coefficients:
    """The tunable parameters `<member>.drag`, `.tangential_drag`, `.inertia`."""

    def parameter(what: str, text: str, start: float) -> Number:
        variable = Variable(f"{name}.{what}", "1", text, start=start, minimum=0.0, tunable=True)
        return recorder.parameter(variable)

    return Coefficients(
        parameter("drag", f"drag coefficient of the flow across {name}", member.drag),
        parameter(
            "tangential_drag", f"drag coefficient of the flow along {name}", member.tangential_drag
        ),
        parameter("inertia", f"inertia coefficient of {name}", member.inertia_coefficient),
    )


def member_load(
    member: Member,
    coefficients: Coefficients,
    body: BodyMotion,
    flow: RecordedFlow,
    surface: float,
) -> MemberLoad:
    """The load on a member of a body at its pose and velocity, in waves of `surface` [m]."""
    axis = axis_of(member, body)
    density, diameter = flow.water.density, member.diameter
    area = 0.25 * math.pi * diameter**2
    drag, turning_drag, inertia, turning_inertia = ZERO, ZERO, ZERO, ZERO
    wet: Number = 0.0
    for s, length in _wet_points(member, axis, body, flow, surface):
        arm = axis.at(s)
        water = flow.at(add(body.place, arm))
        relative = difference(water.velocity, body.velocity_at(arm))
        normal, tangential = across(relative, axis.along), dot(relative, axis.along)
        size = sqrt(dot(normal, normal) + NONE**2)
        quadratic = scaled(0.5 * density * diameter * coefficients.drag * size, normal)
        along = 0.5 * density * math.pi * diameter * coefficients.tangential_drag
        skin = scaled(along * abs(tangential) * tangential, axis.along)
        pull = scaled(length, add(quadratic, skin))
        push = across(water.acceleration, axis.along)
        push = scaled(length * (density * area * coefficients.inertia), push)
        drag, turning_drag = add(drag, pull), add(turning_drag, cross(arm, pull))
        inertia, turning_inertia = add(inertia, push), add(turning_inertia, cross(arm, push))
        wet = wet + length
    return MemberLoad((drag, turning_drag), (inertia, turning_inertia), wet)


def _wet_points(
    member: Member, axis: Axis, body: BodyMotion, flow: RecordedFlow, surface: float
) -> Iterator[tuple[Number, Number]]:
    """Places s [m] along the member and the wet lengths [m] that they stand for."""
    places = boundaries(member, surface)
    x, y, _ = axis.along
    half = 0.5 * member.diameter * sqrt(x * x + y * y + UPRIGHT**2)
    depths = []
    for s in places:
        px, py, pz = add(body.place, axis.at(s))
        depths.append(flow.elevation(px, py) - pz)
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    for (low, high), (first, second) in zip(pairwise(places), pairwise(depths), strict=True):
        step = high - low
        begin, width = _wet_part(first + half, second + half)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            share = begin + width * (0.5 + 0.5 * node)
            depth = first + (second - first) * share
            section = minimum(maximum(0.5 + depth / (2.0 * half), 0.0), 1.0)
            yield low + share * step, 0.5 * weight * step * width * section


def boundaries(member: Member, surface: float) -> list[float]:
    """Places [m] along the member between which its segments are.

    They are the closer together the nearer they are to still water, from the height of the waves,
    `surface` [m], on: lengths are in proportion to √(z² + surface²).
    """
    first, second = (point_in_space(end)[2] for end in member.ends)
    rise = second - first
    shares = np.linspace(0.0, 1.0, member.segments + 1)
    if surface > 0.0 and abs(rise) > UPRIGHT * member.length:
        low, high = np.arcsinh(first / surface), np.arcsinh(second / surface)
        shares = (surface * np.sinh(low + (high - low) * shares) - first) / rise
    return [0.0, *(member.length * shares[1:-1]).tolist(), member.length]


def _wet_part(first: Number, second: Number) -> tuple[Number, Number]:
    """Begin and width [1] of the part of a segment whose depths [m] at the ends are not below 0."""
    wet_first, wet_second = maximum(first, 0.0), maximum(second, 0.0)
    dry_first, dry_second = maximum(-first, 0.0), maximum(-second, 0.0)
    begin = dry_first / (dry_first + wet_second + NONE)
    end = 1.0 - dry_second / (dry_second + wet_first + NONE)
    return begin, maximum(end - begin, 0.0)
