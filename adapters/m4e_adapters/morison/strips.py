"""Points of a member at which the water loads it: on its wetted part, and at its ends.

Each segment is wet where the surface, taken as straight between its ends, is above its lower side:
it is cut there, and three Gauss points lie in what is left. A section of a member that is not
upright is wet in part, in proportion to the height of the surface over its own. So is an end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.morison.buoyancy import UPRIGHT
from m4e_adapters.morison.config import Member
from m4e_adapters.morison.motion import Axis, BodyMotion
from m4e_adapters.morison.vectors import Number, Vector, add
from m4e_fmi.program import maximum, minimum, sqrt

POINTS = 3
NONE = 1e-9  # [m], which guards quotients
Elevation = Callable[[Number, Number], Number]
"""Of the surface [m] over (x, y) [m]."""


@dataclass(frozen=True)
class Coefficients:
    """C_D, C_T, C_M of a member, and the drag of its ends [1]: numbers, or recorded."""

    drag: Number
    tangential_drag: Number
    inertia: Number
    end_drag: Number


@dataclass(frozen=True)
class LoadPoint:
    """A point on the axis, at the `arm` [m], that stands for a wet `length` [m]; 0 of an end.

    Across and along the member: drag over the velocity squared [N.s2/m2], and inertia over the
    acceleration of the water [kg].
    """

    arm: Vector
    length: Number
    drag_across: Number
    drag_along: Number
    mass_across: Number
    mass_along: Number


def load_points(
    member: Member,
    known: Coefficients,
    axis: Axis,
    body: BodyMotion,
    places: Sequence[float],
    elevation: Elevation,
    density: float,
) -> Iterator[LoadPoint]:
    """The points of a member of a body, with segments between `places` [m] on its axis.

    The pressure of waves on buoyant members accelerates them along the axis as the water.
    """
    area = 0.25 * math.pi * member.diameter**2
    for s, length in _wet_points(member, places, axis, body, elevation):
        yield LoadPoint(
            axis.at(s),
            length,
            length * (0.5 * density * member.diameter) * known.drag,
            length * (0.5 * density * math.pi * member.diameter) * known.tangential_drag,
            length * (density * area) * known.inertia,
            length * (density * area) if member.is_buoyant else 0.0,
        )
    if member.end_drag > 0.0 or member.end_added_mass > 0.0:
        half = half_height(member, axis)
        for s in (0.0, member.length):
            x, y, z = add(body.place, axis.at(s))
            wet = _wet_share(elevation(x, y) - z, half)
            drag = wet * (0.5 * density * area) * known.end_drag
            yield LoadPoint(axis.at(s), 0.0, 0.0, drag, 0.0, wet * end_mass(member, density))


def end_mass(member: Member, density: float) -> float:
    """Added mass [kg] along the axis of one end of a member under water."""
    return member.end_added_mass * density * math.pi * member.diameter**3 / 12.0


def half_height(member: Member, axis: Axis) -> Number:
    """Half the height [m] of a section."""
    x, y, _ = axis.along
    return 0.5 * member.diameter * sqrt(x * x + y * y + UPRIGHT**2)


def _wet_share(depth: Number, half: Number) -> Number:
    """Part [1] of a section at a `depth` [m] that is wet."""
    return minimum(maximum(0.5 + depth / (2.0 * half), 0.0), 1.0)


def _wet_points(
    member: Member,
    places: Sequence[float],
    axis: Axis,
    body: BodyMotion,
    elevation: Elevation,
) -> Iterator[tuple[Number, Number]]:
    """Places s [m] along the member and the wet lengths [m] that they stand for."""
    half = half_height(member, axis)
    depths = []
    for s in places:
        px, py, pz = add(body.place, axis.at(s))
        depths.append(elevation(px, py) - pz)
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    for (low, high), (first, second) in zip(pairwise(places), pairwise(depths), strict=True):
        step = high - low
        begin, width = _wet_part(first + half, second + half)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            share = begin + width * (0.5 + 0.5 * node)
            depth = first + (second - first) * share
            yield low + share * step, 0.5 * weight * step * width * _wet_share(depth, half)


def boundaries(member: Member, surface: float, segments: int | None = None) -> list[float]:
    """Places [m] along the member between which its segments are.

    They are the closer together the nearer they are to still water, from the height of the waves,
    `surface` [m], on: lengths are in proportion to √(z² + surface²). `segments` in place of those
    that the member has.
    """
    first, second = (point_in_space(end)[2] for end in member.ends)
    rise = second - first
    shares = np.linspace(0.0, 1.0, (segments or member.segments) + 1)
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
