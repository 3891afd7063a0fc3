"""The paper's B and Ḃ: what joint velocities do to the centre of gravity of a body.

The velocity transformation B maps joint velocities to the velocities (v_x, v_z, ω) of the centres
of gravity, v = B u; v̇ = B u̇ + Ḃ u. Sabet and Diaz-Flores Caminero, "Multibody for Everybody",
Algorithm 1, fills B block by block along the branches; here a body's rows are written on the way
from the body to the ground, which gives the same blocks.

A coordinate that turns a lever l contributes tilde(l) to its column of B, and tilde(dl/dt) to the
same column of Ḃ. An angle turns its own link and what follows that: other relative angles, sliders
and what is fixed, but not what hangs on an absolute angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from m4e_fmi.multibody.kinematics import ZERO, Frame
from m4e_fmi.multibody.space import added, scaled, tilde
from m4e_fmi.multibody.topology import Topology

Columns = dict[int, tuple[Any, Any, Any]]
"""Coordinate → its entries in a body's three rows (v_x, v_z, ω); what is absent is zero."""


def columns(tree: Topology, bodies: Sequence[Frame], k: int) -> Columns:
    """The three rows of B of link `k`."""
    result: Columns = {}
    lever, turning = bodies[k].arm, 1
    while k >= 0:
        link, frame = tree.links[k], bodies[k]
        if link.joint.type == "prismatic":
            result[link.coordinates[0]] = (*frame.direction, 0)
        elif not link.rigid:
            result[link.coordinates[-1]] = (*tilde(lever), turning)
        if link.joint.type == "floating":
            x, z, _ = link.coordinates
            result[x], result[z] = (1, 0, 0), (0, 1, 0)
        if not link.follows:
            lever, turning = ZERO, 0
        lever = added(lever, frame.reach)
        k = link.parent
    return result


def column_rates(tree: Topology, bodies: Sequence[Frame], u: Sequence[Any], k: int) -> Columns:
    """The three rows of Ḃ of link `k` for velocities `u`."""
    result: Columns = {}
    growth = scaled(bodies[k].omega, tilde(bodies[k].arm))  # dl/dt
    while k >= 0:
        link, frame = tree.links[k], bodies[k]
        if link.joint.type == "prismatic":
            s = link.coordinates[0]
            result[s] = (*scaled(frame.omega, tilde(frame.direction)), 0)
            growth = added(growth, scaled(u[s], frame.direction))
        elif not link.rigid:
            result[link.coordinates[-1]] = (*tilde(growth), 0)
        if not link.follows:
            growth = ZERO
        if link.parent >= 0:
            growth = added(growth, scaled(bodies[link.parent].omega, tilde(frame.reach)))
        k = link.parent
    return result
