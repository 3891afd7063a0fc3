"""Wrench of every joint on its child, by Newton and Euler from the leaves to the ground.

With the true acceleration a of a body's centre of gravity, its angular acceleration α, the loads
F, M on it, gravity and the water's A v̇ of added mass, what is left of

    m a = F + m g + R − Σ over children R_child − A v̇,        J α = …

is the joint's: R and its moment. The effort of a joint is part of it, since it passes through the
joint; springs and dampers between two bodies do not. Featherstone, "Rigid Body Dynamics
Algorithms", section 5.3, calls this pass the second half of the recursive Newton–Euler algorithm.
"""

from __future__ import annotations

from dataclasses import dataclass

from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.multibody.kinematics import evaluated
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import Vector, moment, scaled, subtracted


@dataclass(frozen=True)
class Reaction:
    """The wrench of a joint on its child: `force` [N] in world axes and `moment` [N·m] about +Y.

    The moment is about the joint's point of the child, at −`joint_to_child` from the child's
    centre of gravity: the hinge of a revolute joint; the point that slides, of a prismatic one.
    The parent feels the opposite at the same place.
    """

    joint: str
    force: Vector
    moment: AnyScalar


def reactions(assembly: Assembly, solved: Accelerations) -> list[Reaction]:
    """The reaction of every joint that holds its child, in the order of the links."""
    links, found = assembly.tree.links, []
    wrenches = [_inertial(assembly, solved, k) for k in range(len(links))]
    _add_water(assembly, solved, wrenches)
    for k in range(len(links) - 1, -1, -1):
        link, (x, z, turn) = links[k], wrenches[k]
        joint_type = link.joint.joint_type
        if joint_type.is_free:
            continue
        if joint_type.frees_rotation:  # no moment but its effort
            turn = at_joint = assembly.generalized_forces[k]
        else:
            arm = assembly.frames[k].rotation(_back(assembly, k))
            at_joint = turn - moment(arm, (x, z))
        found.append(Reaction(link.joint_name, (x, z), at_joint))
        if link.parent >= 0:
            parent = wrenches[link.parent]
            parent[0], parent[1] = parent[0] + x, parent[1] + z
            if not links[link.parent].joint.joint_type.frees_rotation:
                parent[2] = parent[2] + (turn + moment(assembly.frames[k].reach, (x, z)))
    return found[::-1]


def _inertial(assembly: Assembly, solved: Accelerations, k: int) -> list[AnyScalar]:
    """The wrench that link k needs beyond its loads, about its origin."""
    frame, (mass, inertia) = assembly.frames[k], assembly.masses[k]
    f = assembly.wrenches[k]
    x, z = frame.acceleration_at(frame.arm, solved.origins[k], solved.alphas[k])
    if solved.raised is not assembly.gravity:
        z = z + (assembly.gravity - solved.raised)
    needed = scaled(mass, (x, z))
    turn = 0
    if not assembly.tree.links[k].joint.joint_type.frees_rotation:
        turn = inertia * solved.alphas[k] + moment(frame.arm, needed) - f[2]
    return [needed[0] - f[0], needed[1] - f[1], turn]


def _add_water(assembly: Assembly, solved: Accelerations, wrenches: list[list[AnyScalar]]) -> None:
    """Add A v̇, which is about the centres of gravity."""
    for (i, j), block in assembly.added_mass.items():
        frame = assembly.frames[j]
        motion = (*solved.of_point(frame, j, frame.arm), solved.alphas[j])
        x, z, turn = (sum(a * v for a, v in zip(row, motion, strict=True)) for row in block)
        parts = (x, z, turn + moment(assembly.frames[i].arm, (x, z)))
        wrenches[i] = [w + part for w, part in zip(wrenches[i], parts, strict=True)]


def _back(assembly: Assembly, k: int) -> Vector:
    """From the origin of link k to the joint's point, in body axes."""
    ahead = evaluated(assembly.tree.links[k], assembly.values, "joint_to_child")
    return subtracted(assembly.frames[k].local_arm, ahead)
