"""Mass matrix and forcing of Eq. (5), written with composite bodies; reactions of the joints.

Bᵀ(𝓜 + A)B is never multiplied out. The bodies on a link have a mass, a first moment about its
origin and, those that turn with the link, a second moment; of a subtree on a hinge only its mass
matters, at the hinge. With these an entry of the dry mass matrix is one scalar product, of the
momentum that the inner body's coordinate sees and that of the outer one. The forcing is one pass
outwards with u̇ = 0 and one inwards. Added mass, which may couple bodies, is added by columns of B.

The velocity transformation B maps joint velocities to the velocities (v, ω) of the centres of
gravity, v = B u; v̇ = B u̇ + Ḃ u. Sabet and Diaz-Flores Caminero, "Multibody for Everybody",
Algorithm 1, fills B block by block along the branches; here a body's rows are written on the way
from the body to the ground, which gives the same blocks. A coordinate that turns a lever l about n
contributes n × l to its column of B, and n × dl/dt to the same column of Ḃ. An angle turns its own
link and all relative ones beyond: relative angles, sliders and welds, but nothing that hangs on an
absolute angle.

The reaction of every joint on its child follows from accelerations by Newton and Euler, from the
leaves to the ground. With the true acceleration a of a body's centre of gravity, its angular
acceleration α, the loads F, M on it, gravity and the water's A v̇ of added mass, the remainder of

    m a = F + m g + R − Σ over children R_child − A v̇,        J α = …

is the joint's: R and its moment. The effort of a joint is part of it, since it passes through the
joint; springs and dampers between two bodies do not. Featherstone, "Rigid Body Dynamics
Algorithms", section 5.3, calls this pass the second half of the recursive Newton–Euler algorithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.joints import Frame
from m4e_fmi.multibody.assembly import Accelerations, Assembly
from m4e_fmi.multibody.topology import Topology, evaluated
from m4e_fmi.program import AnyScalar
from m4e_fmi.program.tape import Scalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Matrix,
    Vector,
    add_force,
    added,
    applied,
    coupled,
    cross,
    dot,
    force_of,
    moment_of,
    plus,
    scaled,
    shifted,
    subtracted,
    summed,
    swung,
    times,
)

Rows = list[dict[int, AnyScalar]]
"""A sparse matrix: for each row the entries by column; absent ones are zero."""
Columns = dict[int, Sequence[AnyScalar]]
"""Coordinate → its entries in a body's rows (v, ω), six; absent ones are zero."""


class ClosedForm:
    """M u̇ = f, solved."""

    def __init__(self, assembly: Assembly) -> None:
        symmetric = not assembly.added_mass
        rates = solve(mass_matrix(assembly), forcing(assembly), symmetric=symmetric)
        self.accelerations = outwards(assembly, rates)


@dataclass
class _Composite:
    """Mass of what hangs on a link, and its moments about the link's origin.

    The first moment is `first` in body axes and `carried` in world axes, that of what turns with
    the link and against it; so are the second moments (3, 3) `second` and `swept`.
    """

    mass: AnyScalar
    first: Vector
    second: Matrix
    swept: Matrix
    carried: Vector = ZERO

    def turning(self, frame: Frame) -> Vector:
        """The first moment in world axes."""
        return added(frame.rotation(self.first), self.carried)

    def spinning(self, frame: Frame) -> Matrix:
        """The second moment in world axes."""
        return summed(frame.rotation.tensor(self.second), self.swept)


def mass_matrix(assembly: Assembly) -> Rows:
    """Bᵀ(𝓜 + A)B, with both its halves."""
    tree = assembly.tree
    rows: Rows = [{} for _ in tree.velocity_names]
    composites = _composites(assembly)
    for k in range(len(tree.links)):
        for j, momentum, turning in _momenta(assembly, composites[k], k):
            own = True
            i, P, spin = k, momentum, turning
            while i >= 0:
                for coordinate, entry in _seen(assembly, i, P, spin):
                    if not (own and coordinate > j) and not _is_zero(entry):
                        rows[j][coordinate] = rows[coordinate][j] = entry
                spin = spin if tree.links[i].is_relative else ZERO
                spin = added(spin, cross(assembly.frames[i].reach, P))
                i, own = tree.links[i].parent, False
    if assembly.added_mass:
        _add_water(assembly, rows)
    return rows


def _composites(assembly: Assembly) -> list[_Composite]:
    result: list[_Composite] = []
    axes = [c - TURN for c in assembly.tree.components if c >= TURN]
    nothing: Matrix = [[0] * TURN for _ in range(TURN)]
    for (mass, inertia), frame in zip(assembly.masses, assembly.frames, strict=True):
        arm = frame.local_arm
        second = shifted(inertia, mass, arm, axes)
        result.append(_Composite(mass, scaled(mass, arm), second, nothing))
    for k in range(len(result) - 1, -1, -1):
        link, reach, child = assembly.tree.links[k], assembly.frames[k].local_reach, result[k]
        if link.parent >= 0:
            parent = result[link.parent]
            parent.second = shifted(parent.second, child.mass, reach, axes)
            if link.is_relative:
                carried, swept = child.carried, child.swept
                if not link.joint_type.rotates:
                    parent.first = added(parent.first, child.first)
                    more = summed(coupled(reach, child.first, axes), child.second)
                    parent.second = summed(parent.second, more)
                else:
                    carried = child.turning(assembly.frames[k])
                    swept = child.spinning(assembly.frames[k])
                parent.carried = added(parent.carried, carried)
                more = summed(coupled(assembly.frames[k].reach, carried, axes), swept)
                parent.swept = summed(parent.swept, more)
            parent.first = added(parent.first, scaled(child.mass, reach))
            parent.mass = parent.mass + child.mass
    return result


def _momenta(assembly: Assembly, body: _Composite, k: int) -> list[tuple[int, Vector, Vector]]:
    """For each coordinate of link k at unit rate: linear and angular momentum of what it moves."""
    link, frame = assembly.tree.links[k], assembly.frames[k]
    if not link.speeds:
        return []
    first, second, found = body.turning(frame), body.spinning(frame), []
    for coordinate, freedom in zip(link.speeds, frame.freedoms, strict=True):
        motion = freedom.column(ZERO, spin=True)
        velocity, omega = force_of(motion), moment_of(motion)
        P = added(scaled(body.mass, velocity), cross(omega, first))
        L = added(cross(first, velocity), applied(second, omega))
        found.append((coordinate, P, L))
    return found


def _seen(assembly: Assembly, i: int, P: Vector, L: Vector) -> list[tuple[int, AnyScalar]]:
    """The part of a momentum P, L about link i's origin along each coordinate, the last first."""
    rows = zip(assembly.tree.links[i].speeds, assembly.frames[i].freedoms, strict=True)
    return [(coordinate, freedom.along((*P, *L))) for coordinate, freedom in rows][::-1]


def forcing(assembly: Assembly) -> list[AnyScalar]:
    """Bᵀ(g + g_g) − Bᵀ(𝓜 + A)Ḃu + τ."""
    tree = assembly.tree
    moving = outwards(assembly, [0] * len(tree.velocity_names))
    wrenches = [list(wrench) for wrench in assembly.wrenches]
    bias = []
    sunk = subtracted(ZERO, assembly.gravity)
    for k, (mass, inertia) in enumerate(assembly.masses):
        frame, alpha = assembly.frames[k], moving.alphas[k]
        push = frame.acceleration_at(frame.arm, moving.origins[k], alpha)
        bias.append((*push, *alpha))
        second = frame.rotation.tensor(inertia)
        spun = subtracted(cross(applied(second, frame.omega), frame.omega), applied(second, alpha))
        add_force(wrenches[k], scaled(mass, subtracted(sunk, push)), frame.arm, spun)
    for (i, j), block in assembly.added_mass.items():
        push = [times(-1, dot(row, bias[j])) for row in block]
        add_force(wrenches[i], force_of(push), assembly.frames[i].arm, moment_of(push))
    return _projected(assembly, wrenches)


def outwards(assembly: Assembly, rates: Sequence[AnyScalar]) -> Accelerations:
    """The accelerations of all links for u̇ = `rates`."""
    origins: list[Vector] = []
    alphas: list[Vector] = []
    for link, frame in zip(assembly.tree.links, assembly.frames, strict=True):
        origin, alpha = ZERO, ZERO
        if link.parent >= 0:
            origin, alpha = origins[link.parent], alphas[link.parent]
            origin = swung(origin, alpha, frame.reach)
        origin = subtracted(origin, force_of(frame.inward))
        alpha = subtracted(alpha, moment_of(frame.inward))
        motion = [*origin, *alpha]
        for coordinate, freedom in zip(link.speeds, frame.freedoms, strict=True):
            freedom.move(motion, rates[coordinate])
        origins.append(force_of(motion))
        alphas.append(moment_of(motion))
    return Accelerations(list(rates), origins, alphas, ZERO)


def _projected(assembly: Assembly, wrenches: list[list[AnyScalar]]) -> list[AnyScalar]:
    """Bᵀ of the `wrenches` about the origins, which are added up on the way, and the efforts."""
    tree = assembly.tree
    result: list[AnyScalar] = [0] * len(tree.velocity_names)
    for k in range(len(tree.links) - 1, -1, -1):
        link, frame = tree.links[k], assembly.frames[k]
        efforts = assembly.generalized_forces[k]
        force, turn = force_of(wrenches[k]), moment_of(wrenches[k])
        for (coordinate, part), effort in zip(
            _seen(assembly, k, force, turn), efforts[::-1], strict=True
        ):
            result[coordinate] = plus(part, effort)
        if link.parent >= 0:
            handed = turn
            if not link.is_relative:  # an angle of its own: the parent feels its effort alone
                handed = scaled(efforts[-1], scaled(-1, frame.freedoms[-1].turning))
            add_force(wrenches[link.parent], force, frame.reach, handed)
    return result


def velocity_transformation(tree: Topology, bodies: Sequence[Frame], k: int) -> Columns:
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


def _add_water(assembly: Assembly, rows: Rows) -> None:
    """Add BᵀAB."""
    bodies: dict[int, Columns] = {
        k: velocity_transformation(assembly.tree, assembly.frames, k)
        for k, _ in assembly.added_mass
    }
    for (first, second), block in assembly.added_mass.items():
        for j, right in bodies[second].items():
            push = [dot(row, right) for row in block]
            for i, left in bodies[first].items():
                entry = dot(left, push)
                if not _is_zero(entry):
                    rows[i][j] = rows[i].get(j, 0) + entry


def solve(rows: Rows, right: Sequence[AnyScalar], *, symmetric: bool) -> list[AnyScalar]:
    """x of rows · x = right, without pivoting: of a positive definite matrix. `rows` is used up.

    Unknowns are eliminated from the last to the first, leaves before their parents, which fills in
    nothing that is zero in the mass matrix of a tree. Of a symmetric matrix half is computed.
    """
    x = list(right)
    for k in range(len(x) - 1, -1, -1):
        pivot, row = rows[k][k], {j: entry for j, entry in rows[k].items() if j < k}
        for i in range(k):
            if k not in rows[i]:
                continue
            factor = rows[i][k] / pivot
            x[i] = x[i] - factor * x[k]
            for j, entry in row.items():
                if symmetric and j > i:
                    continue
                rows[i][j] = rows[i].get(j, 0) - factor * entry
                if symmetric:
                    rows[j][i] = rows[i][j]
    for k, row in enumerate(rows):
        for j, entry in row.items():
            if j < k:
                x[k] = x[k] - entry * x[j]
        x[k] = x[k] / row[k]
    return x


def _is_zero(value: AnyScalar) -> bool:
    if isinstance(value, Scalar):
        return value.tape.value(value.index) == 0.0
    return isinstance(value, int) and value == 0


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
    _push_water(assembly, solved, wrenches)
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


def _push_water(assembly: Assembly, solved: Accelerations, wrenches: list[list[AnyScalar]]) -> None:
    """Add A v̇, which is about the centres of gravity."""
    for (i, j), block in assembly.added_mass.items():
        frame = assembly.frames[j]
        motion = (*solved.of_point(frame, j, frame.arm), *solved.alphas[j])
        push = [dot(row, motion) for row in block]
        add_force(wrenches[i], force_of(push), assembly.frames[i].arm, moment_of(push))
