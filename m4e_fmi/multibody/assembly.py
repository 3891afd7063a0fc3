"""A model in motion: its frames, inertias and loads, over any scalar.

    Bᵀ(𝓜 + A)B u̇ = Bᵀ(g + g_g) − Bᵀ(𝓜 + A)Ḃ u + τ        (the paper's Eq. 5 with added mass)

𝓜 is the dry mass matrix; A the added mass at infinite frequency of the bodies that have it, a full
matrix in world axes about the centres of gravity; gravity acts on the dry mass only; τ are the
generalized forces of the joints. Both ways to u̇ start from an `Assembly`: `recursion`, whose cost
grows with the number of bodies, and `closed_form`, which writes M and f of this equation. Run on
SymPy they give equations to read, run on a tape the code that machines run. Energies and the power
of the loads are those of an `Assembly`, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from m4e_fmi.joints import Frame, PointMotion
from m4e_fmi.model import Model, Table
from m4e_fmi.model.elements import (
    GROUND,
    inertia_of,
    neutral_mass,
    quantity,
    vector,
)
from m4e_fmi.model.expression import NOTHING, Expression, Values
from m4e_fmi.model.groups import gravity_of
from m4e_fmi.multibody.loads import Acting, acting
from m4e_fmi.multibody.topology import Lookup, ModelState, MotionValues, Topology, frames, in_space
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import (
    TURN,
    ZERO,
    Matrix,
    Vector,
    Wrench,
    add_force,
    dot,
    force_of,
    moment_of,
    plus,
    quadratic,
    scaled,
    shifted,
    subtracted,
    times,
)


def at_time(name: str, table: Table, time: AnyScalar) -> AnyScalar:
    """The value of a table at a time, computed from its rows."""
    del name
    return table.at(time)


@dataclass(frozen=True)
class Scalars:
    """The scalars to assemble with: q, u, the time, parameters by name, and inputs.

    `q` in m and rad, `u` (n,) in m/s and rad/s, in the order of the links; `time` in s.

    Neutral masses are among the parameters, by their names in the program.

    `body_wrench[name]` = (F [N], M [N·m]) at a centre of gravity, `point_force[name]` [N],
    `effort[joint]` [N or N·m] along each of its coordinates; absent ones are zero. `added_mass`
    [kg, kg·m, kg·m²] has a row and a column for each component of the motion of each body with
    added mass, in the order of their numbers: (x, z, θ) in the plane, (v, ω) in space. `number`
    makes a scalar of a constant, `table` of a table.
    """

    q: Sequence[AnyScalar]
    u: Sequence[AnyScalar]
    time: AnyScalar
    parameters: Mapping[str, AnyScalar]
    body_wrench: Mapping[str, Wrench]
    point_force: Mapping[str, Vector]
    effort: Mapping[str, Sequence[AnyScalar]]
    added_mass: Matrix
    number: Callable[[float], AnyScalar] = float
    table: Lookup = at_time


@dataclass(frozen=True)
class Assembly:
    """A model in motion.

    `masses[k]` = (mass, inertia (3, 3) about the CG in body axes) of link k; `added_mass[i, j]` the
    6×6 block by which link j's acceleration acts on link i; `wrenches[k]` = (F, M) on link k about
    its origin (not its CG), gravity left out; `generalized_forces[k]` along its joint's
    coordinates. `loads` are the model's, by name, and are part of the wrenches and generalized
    forces.
    """

    model: Model
    tree: Topology
    scalars: Scalars
    values: MotionValues
    frames: list[Frame]
    points: dict[str, PointMotion]
    gravity: Vector
    masses: list[tuple[AnyScalar, Matrix]]
    added_mass: dict[tuple[int, int], Matrix]
    wrenches: list[list[AnyScalar]]
    generalized_forces: list[list[AnyScalar]]
    loads: dict[str, Acting]

    @cached_property
    def seconds(self) -> list[Matrix]:
        """Moments of inertia (3, 3) [kg·m²] of each link about its origin, in world axes."""
        axes = [c - TURN for c in self.tree.components if c >= TURN]
        pairs = zip(self.masses, self.frames, strict=True)
        return [
            frame.rotation.tensor(shifted(inertia, mass, frame.local_arm, axes))
            for (mass, inertia), frame in pairs
        ]


@dataclass(frozen=True)
class Accelerations:
    """`rates` = u̇ (n,); `origins[k]` and `alphas[k]` of link k: a + `raised`, and α.

    In m/s² and rad/s², world axes.
    """

    rates: list[AnyScalar]
    origins: list[Vector]
    alphas: list[Vector]
    raised: Vector

    def of_point(self, frame: Frame, k: int, arm: Vector) -> Vector:
        """True acceleration of the point at `arm` from the origin of link `k`."""
        return subtracted(frame.acceleration_at(arm, self.origins[k], self.alphas[k]), self.raised)


def assemble(model: Model, tree: Topology, scalars: Scalars) -> Assembly:
    """Set `model` in motion with `scalars`."""
    values = Values({**scalars.parameters, "t": scalars.time}, number=scalars.number)
    masses = []
    for link in tree.links:
        body = model.bodies[link.body]
        if body.is_neutral:
            mass = values[neutral_mass(link.body)]
        else:
            mass = quantity(body, "mass").evaluate(values)
        masses.append((mass, _tensor(inertia_of(body), values)))
    moving = frames(tree, scalars.q, scalars.u, values)
    state = ModelState(model, tree, scalars.q, scalars.u, moving, points := {})
    for name, point in model.points.items():
        at = in_space(vector(point, "at"), values)
        points[name] = state.frame(point.body).place(at)
    motion = MotionValues(values, state, scalars.table)
    loads = {name: acting(load, motion) for name, load in model.loads.items()}
    forces = [[*scalars.effort.get(link.joint_name, [0] * len(link.speeds))] for link in tree.links]
    return Assembly(
        model=model,
        tree=tree,
        scalars=scalars,
        values=motion,
        frames=moving,
        points=points,
        gravity=in_space(gravity_of(model), values),
        masses=masses,
        added_mass=_blocks(tree, links_with_added_mass(model, tree), scalars.added_mass),
        wrenches=_wrenches(state, scalars, loads, forces),
        generalized_forces=forces,
        loads=loads,
    )


def links_with_added_mass(model: Model, tree: Topology) -> list[int]:
    """Indices of the links with added mass, in their order."""
    return [k for k, link in enumerate(tree.links) if model.bodies[link.body].added_mass]


def _tensor(parts: Sequence[Expression], values: Values) -> Matrix:
    """An inertia (3, 3) [kg·m²] of I_yy, of its diagonal, or of that and I_xy, I_yz, I_zx."""
    found = [0 if part == NOTHING else part.evaluate(values) for part in parts]
    xx, yy, zz, xy, yz, zx = {1: [0, *found, 0, 0, 0, 0], 3: [*found, 0, 0, 0], 6: found}[
        len(found)
    ]
    return [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]


def _blocks(tree: Topology, links: list[int], matrix: Matrix) -> dict[tuple[int, int], Matrix]:
    """The 6×6 blocks of the added-mass matrix, by pair of links; zero for other components."""
    size, found = len(tree.components), dict[tuple[int, int], Matrix]()
    for first, i in enumerate(links):
        for second, j in enumerate(links):
            block = found[i, j] = [[0] * (2 * TURN) for _ in range(2 * TURN)]
            for a, row in zip(tree.components, matrix[size * first :], strict=False):
                for b, entry in zip(tree.components, row[size * second :], strict=False):
                    block[a][b] = entry
    return found


def _wrenches(
    state: ModelState, scalars: Scalars, loads: Mapping[str, Acting], forces: list[list[AnyScalar]]
) -> list[list[AnyScalar]]:
    """Sum (F, M) of loads and outside forces on each link, about its origin.

    Efforts of loads on joints are added to `forces`.
    """
    index, model = state.tree.index, state.model
    total: list[list[AnyScalar]] = [[0] * (2 * TURN) for _ in state.tree.links]

    def push(body: str, force: Vector, arm: Vector, torque: Vector = ZERO) -> None:
        if body != GROUND:  # nothing moves the ground
            add_force(total[index(body)], force, arm, torque)

    for body, wrench in scalars.body_wrench.items():
        push(body, force_of(wrench), state.frame(body).arm, moment_of(wrench))
    for name, force in scalars.point_force.items():
        push(model.points[name].body, force, state.points[name].arm)
    for action in (action for load in loads.values() for action in load.actions):
        if action.joint:
            k = index(model.joints[action.joint].child)
            forces[k][action.number] = forces[k][action.number] + action.effort
        elif action.point:
            push(model.points[action.point].body, action.force, state.points[action.point].arm)
        else:
            push(action.body, action.force, state.frame(action.body).arm, action.moment)
    return total


def kinetic_energy(assembly: Assembly) -> AnyScalar:
    """½ vᵀ(𝓜 + A)v [J]."""
    total: AnyScalar = 0
    for (mass, inertia), frame in zip(assembly.masses, assembly.frames, strict=True):
        total = total + mass * dot(frame.velocity, frame.velocity)
        # J is in body axes, and so is what it is applied to
        spin = frame.omega if frame.rotation.about is not None else frame.rotation.back(frame.omega)
        total = plus(total, quadratic(inertia, spin))
    for (i, j), block in assembly.added_mass.items():
        left, right = ((*f.velocity, *f.omega) for f in (assembly.frames[i], assembly.frames[j]))
        for row, v in zip(block, left, strict=True):
            total = plus(total, times(v, dot(row, right)))
    return total / 2


def potential_energy(assembly: Assembly) -> AnyScalar:
    """Potential energy [J] of gravity on the dry masses (zero at the origin) and of the springs.

    A spring counts if its quantities depend on parameters only, and a law if its integral is known:
    see `loads`.
    """
    total: AnyScalar = 0
    for (mass, _), frame in zip(assembly.masses, assembly.frames, strict=True):
        total = plus(total, dot(scaled(mass, assembly.gravity), frame.position))
    for load in assembly.loads.values():
        total = total + load.potential
    return total


def input_power(assembly: Assembly) -> AnyScalar:
    """Power [W] of what acts from outside; the integer 0 if nothing does."""
    total: AnyScalar = 0
    outside = assembly.scalars
    for body, wrench in outside.body_wrench.items():
        frame = assembly.values.state.frame(body)
        total = plus(total, dot(wrench, (*frame.velocity, *frame.omega)))
    for name, force in outside.point_force.items():
        total = plus(total, dot(force, assembly.points[name].velocity))
    for joint, efforts in outside.effort.items():
        for number, effort in enumerate(efforts):
            _, rate = assembly.values.state.joint(joint, number)
            total = plus(total, times(effort, rate))
    return total


def load_powers(assembly: Assembly) -> dict[str, AnyScalar]:
    """Power [W] by which each load changes the sum of kinetic and potential energy, by its name.

    A load that has a potential and nothing else is left out. Together with the power of what acts
    from outside these are d(energy)/dt.
    """
    powers = {name: load.power for name, load in assembly.loads.items()}
    return {name: power for name, power in powers.items() if not isinstance(power, int)}
