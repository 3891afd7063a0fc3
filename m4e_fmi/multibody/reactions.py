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
from m4e_fmi.multibody.motion import evaluated
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Vector,
    add_force,
    added,
    applied,
    cross,
    dot,
    force_of,
    moment_of,
    scaled,
    subtracted,
)


@dataclass(frozen=True)
class Reaction:
    """The wrench of a joint on its child: `force` [N] and `moment` [N·m].

    In world axes, or in those of the child where the joint's `reaction_axes` are the body's.

    The moment is about the joint's point of the child, at −`joint_to_child` from the child's
    centre of gravity: the hinge of a revolute joint; the point that slides, of a prismatic one.
    The parent feels the opposite at the same place.
    """

    joint: str
    force: Vector
    moment: Vector


def reactions(assembly: Assembly, solved: Accelerations) -> list[Reaction]:
    """The reaction of every joint that holds its child, in the order of the links."""
    links, found = assembly.tree.links, []
    wrenches = [_inertial(assembly, solved, k) for k in range(len(links))]
    _add_water(assembly, solved, wrenches)
    for k in range(len(links) - 1, -1, -1):
        link, force, turn = links[k], force_of(wrenches[k]), moment_of(wrenches[k])
        if link.joint_type.is_free:
            continue
        if link.joint_type.frees_rotation:  # no moment but its effort
            axis = assembly.frames[k].freedoms[-1].turning
            turn = at_joint = scaled(assembly.generalized_forces[k][-1], axis)
        else:
            frame = assembly.frames[k]
            ahead = evaluated(link, assembly.values, "joint_to_child")
            arm = frame.rotation(subtracted(frame.local_arm, ahead))  # from the origin to the joint
            at_joint = subtracted(turn, cross(arm, force))
        shown, back = (force, at_joint), assembly.frames[k].rotation.back
        if link.joint.reaction_axes == "body":
            shown = back(force), back(at_joint)
        found.append(Reaction(link.joint_name, *shown))
        if link.parent >= 0:
            parent = wrenches[link.parent]
            parent[:TURN] = added(force_of(parent), force)
            if not links[link.parent].joint_type.frees_rotation:
                handed = added(turn, cross(assembly.frames[k].reach, force))
                parent[TURN:] = added(moment_of(parent), handed)
    return found[::-1]


def _inertial(assembly: Assembly, solved: Accelerations, k: int) -> list[AnyScalar]:
    """The wrench that link k needs beyond its loads, about its origin."""
    frame, (mass, inertia) = assembly.frames[k], assembly.masses[k]
    f = assembly.wrenches[k]
    acceleration = frame.acceleration_at(frame.arm, solved.origins[k], solved.alphas[k])
    if solved.raised is not assembly.gravity:
        acceleration = added(acceleration, subtracted(assembly.gravity, solved.raised))
    needed = scaled(mass, acceleration)
    turn = ZERO  # which a joint that frees rotation does not need
    if not assembly.tree.links[k].joint_type.frees_rotation:
        second = frame.rotation.tensor(inertia)
        spun = cross(frame.omega, applied(second, frame.omega))
        turn = added(applied(second, solved.alphas[k]), cross(frame.arm, needed))
        turn = subtracted(added(turn, spun), moment_of(f))
    return [*subtracted(needed, force_of(f)), *turn]


def _add_water(assembly: Assembly, solved: Accelerations, wrenches: list[list[AnyScalar]]) -> None:
    """Add A v̇, which is about the centres of gravity."""
    for (i, j), block in assembly.added_mass.items():
        frame = assembly.frames[j]
        motion = (*solved.of_point(frame, j, frame.arm), *solved.alphas[j])
        push = [dot(row, motion) for row in block]
        add_force(wrenches[i], force_of(push), assembly.frames[i].arm, moment_of(push))
