"""The paper's B and Ḃ: the velocity of each centre of gravity by the joint velocities.

The velocity transformation B maps joint velocities to the velocities (v, ω) of the centres
of gravity, v = B u; v̇ = B u̇ + Ḃ u. Sabet and Diaz-Flores Caminero, "Multibody for Everybody",
Algorithm 1, fills B block by block along the branches; here a body's rows are written on the way
from the body to the ground, which gives the same blocks.

A coordinate that turns a lever l about n contributes n × l to its column of B, and n × dl/dt to the
same column of Ḃ. An angle turns its own link and all relative ones beyond: relative angles, sliders
and welds, but nothing that hangs on an absolute angle.
"""

from __future__ import annotations

from collections.abc import Sequence

from m4e_fmi.joints import Frame
from m4e_fmi.multibody.topology import Topology
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import ZERO, added, cross, scaled

Columns = dict[int, Sequence[AnyScalar]]
"""Coordinate → its entries in a body's rows (v, ω), six; absent ones are zero."""


def columns(tree: Topology, bodies: Sequence[Frame], k: int) -> Columns:
    """The rows of B of link `k`, (v [m/s], ω [rad/s]) per unit rate."""
    result: Columns = {}
    lever, spin = bodies[k].arm, True
    while k >= 0:
        link, frame = tree.links[k], bodies[k]
        freedoms = list(zip(link.speeds, frame.freedoms, strict=True))
        for coordinate, freedom in freedoms[-1:] + freedoms[:-1]:  # the order of sums over them
            result[coordinate] = freedom.column(lever, spin)
        if not link.is_relative:
            lever, spin = ZERO, False
        lever = added(lever, frame.reach)
        k = link.parent
    return result


def column_rates(
    tree: Topology, bodies: Sequence[Frame], u: Sequence[AnyScalar], k: int
) -> Columns:
    """The rows of Ḃ of link `k` for velocities `u` (n,), per s of those of B."""
    result: Columns = {}
    growth = cross(bodies[k].omega, bodies[k].arm)  # dl/dt
    while k >= 0:
        link, frame = tree.links[k], bodies[k]
        for coordinate, freedom in zip(link.speeds, frame.freedoms, strict=True):
            rate = freedom.column_rate(growth)
            if rate is not None:
                result[coordinate] = rate
        if not link.is_relative:
            growth = ZERO
        for coordinate, freedom in zip(link.speeds, frame.freedoms, strict=True):
            if freedom.direction is not ZERO:
                growth = added(growth, scaled(u[coordinate], freedom.direction))
        if link.parent >= 0:
            growth = added(growth, cross(bodies[link.parent].omega, frame.reach))
        k = link.parent
    return result
