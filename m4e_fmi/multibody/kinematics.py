"""Positions, velocities, B and Ḃ of every body, over any scalar.

The velocity transformation B maps joint velocities to the velocities (v_x, v_z, ω) of the centres
of gravity, v = B u; v̇ = B u̇ + Ḃ u. Sabet and Diaz-Flores Caminero, "Multibody for Everybody",
Algorithm 1, fills B block by block along the branches; the blocks are written here on the way
outwards, each body's row from its parent's row, which gives the same blocks.

With absolute angles a rotating arm a = R(θ)ρ contributes tilde(a) to the column of θ in B, and
−a θ̇ to the same column of Ḃ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from m4e_fmi.model.elements import vector
from m4e_fmi.model.expression import Values
from m4e_fmi.multibody.planar import Pair, Rotation, added, scaled, tilde
from m4e_fmi.multibody.topology import Link, Topology
from m4e_fmi.program import sqrt

Columns = dict[int, Pair]


@dataclass(frozen=True)
class Frame:
    """Motion of one body (or of the ground).

    `position` of the centre of gravity in the world [m]; `angle` absolute [rad]; `velocity` and
    `omega`. `columns[j]` holds (∂x/∂q_j, ∂z/∂q_j), the body's two translational rows of B, and
    `column_rates[j]` those of Ḃ; `angle_index` is the column of its rotational row, whose only
    entry is 1 (−1: the body does not turn).
    """

    position: Pair
    angle: Any
    rotation: Rotation
    velocity: Pair
    omega: Any
    columns: Columns
    column_rates: Columns
    angle_index: int

    def arm(self, at: Pair) -> Arm:
        """The point fixed at `at` (body axes, from the centre of gravity)."""
        arm = self.rotation(at)
        columns = dict(self.columns)
        if self.angle_index >= 0:
            columns[self.angle_index] = _sum(columns.get(self.angle_index), tilde(arm))
        position = added(self.position, arm)
        velocity = added(self.velocity, scaled(self.omega, tilde(arm)))
        return Arm(arm, position, velocity, columns)

    def acceleration(self, rates: Sequence[Any], u: Sequence[Any]) -> tuple[Pair, Any]:
        """Acceleration of the centre of gravity and angular acceleration for u̇ = `rates`."""
        total: Pair = (0, 0)
        for j, column in self.columns.items():
            total = added(total, scaled(rates[j], column))
        for j, column in self.column_rates.items():
            total = added(total, scaled(u[j], column))
        return total, rates[self.angle_index] if self.angle_index >= 0 else 0


@dataclass(frozen=True)
class Arm:
    """A point of a body: its arm from the centre of gravity in world axes, its motion and ∂r/∂q."""

    arm: Pair
    position: Pair
    velocity: Pair
    columns: Columns


GROUND_FRAME = Frame((0, 0), 0, Rotation(), (0, 0), 0, {}, {}, -1)


def frames(
    tree: Topology,
    q: Sequence[Any],
    u: Sequence[Any],
    values: Values,
) -> list[Frame]:
    """The frame of every link for coordinates `q`, velocities `u` and named parameter `values`."""
    result: list[Frame] = []
    for link in tree.links:
        parent = result[link.parent] if link.parent >= 0 else GROUND_FRAME
        result.append(_FRAMES[link.joint.type](link, parent, q, u, values))
    return result


def _floating(link: Link, parent: Frame, q: Any, u: Any, values: Any) -> Frame:
    del parent, values
    x, z, theta = link.coordinates
    return Frame(
        position=(q[x], q[z]),
        angle=q[theta],
        rotation=Rotation.by(q[theta]),
        velocity=(u[x], u[z]),
        omega=u[theta],
        columns={x: (1, 0), z: (0, 1)},
        column_rates={},
        angle_index=theta,
    )


def _revolute(link: Link, parent: Frame, q: Any, u: Any, values: Any) -> Frame:
    (theta,) = link.coordinates
    rotation = Rotation.by(q[theta])
    outer = _evaluated(link, "parent_to_joint", values)
    inner = rotation(_evaluated(link, "joint_to_child", values))
    frame = _carried(parent, parent.rotation(outer))
    columns, rates = frame.columns, frame.column_rates
    columns[theta] = tilde(inner)
    rates[theta] = scaled(-u[theta], inner)
    return Frame(
        position=added(frame.position, inner),
        angle=q[theta],
        rotation=rotation,
        velocity=added(frame.velocity, scaled(u[theta], tilde(inner))),
        omega=u[theta],
        columns=columns,
        column_rates=rates,
        angle_index=theta,
    )


def _prismatic(link: Link, parent: Frame, q: Any, u: Any, values: Any) -> Frame:
    (s,) = link.coordinates
    assert link.joint.direction is not None
    dx, dz = (part.evaluate(values) for part in vector(link.joint, "direction"))
    length = sqrt(dx * dx + dz * dz)
    direction = parent.rotation((dx / length, dz / length))
    fixed = added(
        _evaluated(link, "parent_to_joint", values), _evaluated(link, "joint_to_child", values)
    )
    arm = added(parent.rotation(fixed), scaled(q[s], direction))
    frame = _carried(parent, arm)
    columns, rates = frame.columns, frame.column_rates
    columns[s] = direction
    if parent.angle_index >= 0:
        # the arm also grows: d/dt tilde(arm) = −arm θ̇ + ṡ tilde(direction)
        growth = scaled(u[s], tilde(direction))
        rates[parent.angle_index] = added(rates[parent.angle_index], growth)
        rates[s] = scaled(parent.omega, tilde(direction))
    return Frame(
        position=frame.position,
        angle=parent.angle,
        rotation=parent.rotation,
        velocity=added(frame.velocity, scaled(u[s], direction)),
        omega=parent.omega,
        columns=columns,
        column_rates=rates,
        angle_index=parent.angle_index,
    )


_FRAMES = {"floating": _floating, "revolute": _revolute, "prismatic": _prismatic}


def _carried(parent: Frame, arm: Pair) -> Frame:
    """The frame of a point at `arm` (world axes) that turns with the parent."""
    columns, rates = dict(parent.columns), dict(parent.column_rates)
    k = parent.angle_index
    if k >= 0:
        columns[k] = _sum(columns.get(k), tilde(arm))
        rates[k] = _sum(rates.get(k), scaled(-parent.omega, arm))
    return Frame(
        position=added(parent.position, arm),
        angle=parent.angle,
        rotation=parent.rotation,
        velocity=added(parent.velocity, scaled(parent.omega, tilde(arm))),
        omega=parent.omega,
        columns=columns,
        column_rates=rates,
        angle_index=k,
    )


def _sum(old: Pair | None, new: Pair) -> Pair:
    return new if old is None else added(old, new)


def _evaluated(link: Link, field: str, values: Values) -> Pair:
    x, z = (part.evaluate(values) for part in vector(link.joint, field))
    return x, z
