"""Positions and velocities of every body, over any scalar, at a cost that grows with their number.

Every body has an origin, which is where its joint holds it: the hinge of a revolute body, the
centre of gravity of any other. A body's angle is its coordinate, or with a relative one the sum of
that and its parent's. The motion of an origin follows from that of the parent's:

    v = v_parent + ω_parent tilde(reach) + ṡ direction
    a = a_parent + α_parent tilde(reach) + s̈ direction − inward

`columns` makes the paper's B and Ḃ from the same frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from m4e_fmi.model.elements import vector
from m4e_fmi.model.expression import Values
from m4e_fmi.multibody.space import Pair, Rotation, added, scaled, subtracted, swung, tilde
from m4e_fmi.multibody.topology import Link, Topology
from m4e_fmi.program import sqrt

ZERO: Pair = (0, 0)


@dataclass(frozen=True)
class Frame:
    """Motion of one body, or of the ground. Vectors are in world axes if nothing else is said.

    `position` and `velocity` are those of the centre of gravity [m, m/s], `angle` and `omega` are
    absolute [rad, rad/s]. `arm` leads from the origin to the centre of gravity, `local_arm` is the
    same in body axes. `reach` leads from the parent's origin to this one, `local_reach` is the same
    in the parent's axes; `direction` is the unit vector along which a prismatic body slides;
    `inward` is defined above [m/s²]. `turns` says if the body ever turns.
    """

    origin: Pair
    origin_velocity: Pair
    angle: Any
    omega: Any
    rotation: Rotation
    turns: bool
    local_arm: Pair = ZERO
    local_reach: Pair = ZERO
    reach: Pair = ZERO
    inward: Pair = ZERO
    direction: Pair = ZERO
    arm: Pair = ZERO

    @property
    def position(self) -> Pair:
        return added(self.origin, self.arm)

    @property
    def velocity(self) -> Pair:
        return self.velocity_at(self.arm)

    def velocity_at(self, arm: Pair) -> Pair:
        """Velocity of the body's point at `arm` from the origin."""
        return swung(self.origin_velocity, self.omega, arm)

    def acceleration_at(self, arm: Pair, origin: Pair, alpha: Any) -> Pair:
        """Acceleration of the point at `arm`, for the origin's and the angular acceleration."""
        return subtracted(swung(origin, alpha, arm), scaled(self.omega * self.omega, arm))

    def place(self, at: Pair) -> Place:
        """The point fixed at `at` (body axes, from the centre of gravity)."""
        arm = self.rotation(added(self.local_arm, at))
        return Place(arm, added(self.origin, arm), self.velocity_at(arm))


@dataclass(frozen=True)
class Place:
    """A point of a body: its arm from the body's origin in world axes, and its motion."""

    arm: Pair
    position: Pair
    velocity: Pair


GROUND_FRAME = Frame(ZERO, ZERO, 0, 0, Rotation(), turns=False)


def frames(tree: Topology, q: Sequence[Any], u: Sequence[Any], values: Values) -> list[Frame]:
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
        origin=(q[x], q[z]),
        origin_velocity=(u[x], u[z]),
        angle=q[theta],
        omega=u[theta],
        rotation=Rotation.by(q[theta]),
        turns=True,
    )


def _revolute(link: Link, parent: Frame, q: Any, u: Any, values: Values) -> Frame:
    (theta,) = link.coordinates
    angle, omega = q[theta], u[theta]
    if link.follows:
        angle, omega = parent.angle + angle, parent.omega + omega
    rotation = Rotation.by(angle)
    local_arm = _evaluated(link, "joint_to_child", values)
    local_reach = added(parent.local_arm, _evaluated(link, "parent_to_joint", values))
    reach = parent.rotation(local_reach)
    return Frame(
        origin=added(parent.origin, reach),
        origin_velocity=parent.velocity_at(reach),
        angle=angle,
        omega=omega,
        rotation=rotation,
        turns=True,
        local_arm=local_arm,
        local_reach=local_reach,
        reach=reach,
        inward=_centripetal(parent, reach),
        arm=rotation(local_arm),
    )


def _fixed(link: Link, parent: Frame, q: Any, u: Any, values: Values) -> Frame:
    del q, u
    local_reach = added(parent.local_arm, _offset(link, values))
    reach = parent.rotation(local_reach)
    return Frame(
        origin=added(parent.origin, reach),
        origin_velocity=parent.velocity_at(reach),
        angle=parent.angle,
        omega=parent.omega,
        rotation=parent.rotation,
        turns=parent.turns,
        local_reach=local_reach,
        reach=reach,
        inward=_centripetal(parent, reach),
    )


def _prismatic(link: Link, parent: Frame, q: Any, u: Any, values: Values) -> Frame:
    (s,) = link.coordinates
    assert link.joint.direction is not None
    dx, dz = (part.evaluate(values) for part in vector(link.joint, "direction"))
    length = sqrt(dx * dx + dz * dz)
    local_direction = (dx / length, dz / length)
    direction = parent.rotation(local_direction)
    fixed = added(parent.local_arm, _offset(link, values))
    local_reach = added(fixed, scaled(q[s], local_direction))
    reach = parent.rotation(local_reach)
    coriolis = scaled(2 * parent.omega * u[s], tilde(direction)) if parent.turns else ZERO
    return Frame(
        origin=added(parent.origin, reach),
        origin_velocity=added(parent.velocity_at(reach), scaled(u[s], direction)),
        angle=parent.angle,
        omega=parent.omega,
        rotation=parent.rotation,
        turns=parent.turns,
        local_reach=local_reach,
        reach=reach,
        inward=subtracted(_centripetal(parent, reach), coriolis),
        direction=direction,
    )


_FRAMES = {"floating": _floating, "revolute": _revolute, "prismatic": _prismatic, "fixed": _fixed}


def _centripetal(parent: Frame, reach: Pair) -> Pair:
    """Acceleration towards the parent's origin of a point that turns with the parent."""
    return scaled(parent.omega * parent.omega, reach) if parent.turns else ZERO


def _offset(link: Link, values: Values) -> Pair:
    """From the parent's centre of gravity to the child's, where nothing has slid, in its axes."""
    outer, inner = (_evaluated(link, end, values) for end in ("parent_to_joint", "joint_to_child"))
    return added(outer, inner)


def _evaluated(link: Link, field: str, values: Values) -> Pair:
    x, z = (part.evaluate(values) for part in vector(link.joint, field))
    return x, z
