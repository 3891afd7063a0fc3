"""A model in motion: its frames, inertias and loads, over any scalar.

    Bᵀ(𝓜 + A)B u̇ = Bᵀ(g + g_g) − Bᵀ(𝓜 + A)Ḃ u + τ        (the paper's Eq. 5 with added mass)

𝓜 is the dry mass matrix; A the added mass at infinite frequency of the bodies that have it, a full
matrix in world axes about the centres of gravity; gravity acts on the dry mass only; τ are the
generalized forces of the joints. Both ways to u̇ start from an `Assembly`: `recursion`, whose cost
grows with the number of bodies, and `closed_form`, which writes M and f of this equation. Run on
SymPy they give equations to read, run on a tape the code that machines run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from m4e_fmi.joints import GROUND_FRAME, Frame, Place
from m4e_fmi.model import Model, Table
from m4e_fmi.model.elements import GROUND, neutral_mass, quantity, vector
from m4e_fmi.model.expression import Values
from m4e_fmi.multibody.kinematics import frames
from m4e_fmi.multibody.loads import Acting, acting
from m4e_fmi.multibody.motion import Lookup, Motion, State
from m4e_fmi.multibody.topology import Topology
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import PLANE, TURN, ZERO, Matrix, Vector, add_force


def at_time(name: str, table: Table, time: AnyScalar) -> AnyScalar:
    """The value of a table at a time, computed from its rows."""
    del name
    return table.at(time)


@dataclass(frozen=True)
class Scalars:
    """The scalars to assemble with: q, u, the time, parameters by name, and inputs.

    `q` (n,), `u` (n,) in m, rad, m/s, rad/s, in the order of the coordinates; `time` in s.

    Neutral masses are among the parameters, by their names in the program.

    `body_wrench[name]` = (F_x, F_z [N], M_y [N·m]) at a centre of gravity, `point_force[name]` =
    (F_x, F_z), `effort[joint]` [N or N·m]; absent ones are zero. `added_mass` [kg, kg·m, kg·m²] has
    three rows (x, z, θ) and columns for each body with added mass, in the order of their numbers.
    `number` makes a scalar of a constant, `table` of a table.
    """

    q: Sequence[AnyScalar]
    u: Sequence[AnyScalar]
    time: AnyScalar
    parameters: Mapping[str, AnyScalar]
    body_wrench: Mapping[str, tuple[AnyScalar, AnyScalar, AnyScalar]]
    point_force: Mapping[str, tuple[AnyScalar, AnyScalar]]
    effort: Mapping[str, AnyScalar]
    added_mass: Matrix
    number: Callable[[float], AnyScalar] = float
    table: Lookup = at_time


@dataclass(frozen=True)
class Assembly:
    """A model in motion.

    `masses[k]` = (mass, inertia about the CG) of link k; `added_mass[i, j]` the 6×6 block by which
    link j's acceleration acts on link i; `wrenches[k]` = (F, M) on link k about its origin (not its
    CG), gravity left out; `generalized_forces[k]` along its joint's coordinate. `loads`
    are the model's, by name, and are part of the wrenches and generalized forces.
    """

    model: Model
    tree: Topology
    scalars: Scalars
    values: Motion
    u: Sequence[AnyScalar]
    frames: list[Frame]
    points: dict[str, Place]
    gravity: AnyScalar
    masses: list[tuple[AnyScalar, AnyScalar]]
    added_mass: dict[tuple[int, int], Matrix]
    wrenches: list[list[AnyScalar]]
    generalized_forces: list[AnyScalar]
    loads: dict[str, Acting]

    def frame(self, body: str) -> Frame:
        """Of a body by its name, or of the ground."""
        return GROUND_FRAME if body == GROUND else self.frames[self.tree.index(body)]


@dataclass(frozen=True)
class Accelerations:
    """`rates` = u̇ (n,); `origins[k]` and `alphas[k]` of link k: a + (0, 0, `raised`), and α.

    In m/s² and rad/s², world axes.
    """

    rates: list[AnyScalar]
    origins: list[Vector]
    alphas: list[Vector]
    raised: AnyScalar

    def of_point(self, frame: Frame, k: int, arm: Vector) -> Vector:
        """True acceleration of the point at `arm` from the origin of link `k`."""
        x, y, z = frame.acceleration_at(arm, self.origins[k], self.alphas[k])
        return x, y, z - self.raised


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
        masses.append((mass, quantity(body, "inertia").evaluate(values)))
    moving = frames(tree, scalars.q, scalars.u, values)
    state = State(model, tree, scalars.q, scalars.u, moving, points := {})
    for name, point in model.points.items():
        x, z = (part.evaluate(values) for part in vector(point, "at"))
        points[name] = state.frame(point.body).place((x, 0, z))
    motion = Motion(values, state, scalars.table)
    loads = {name: acting(load, motion) for name, load in model.loads.items()}
    forces = [scalars.effort.get(link.joint_name, 0) for link in tree.links]
    return Assembly(
        model=model,
        tree=tree,
        scalars=scalars,
        values=motion,
        u=scalars.u,
        frames=moving,
        points=points,
        gravity=quantity(model, "gravity").evaluate(values),
        masses=masses,
        added_mass=_blocks(links_with_added_mass(model, tree), scalars.added_mass),
        wrenches=_wrenches(state, scalars, loads, forces),
        generalized_forces=forces,
        loads=loads,
    )


def links_with_added_mass(model: Model, tree: Topology) -> list[int]:
    """Indices of the links with added mass, in their order."""
    return [k for k, link in enumerate(tree.links) if model.bodies[link.body].added_mass]


def _blocks(links: list[int], matrix: Matrix) -> dict[tuple[int, int], Matrix]:
    """The 6×6 blocks of the added-mass matrix, by pair of links; zero off the plane."""
    size, found = len(PLANE), dict[tuple[int, int], Matrix]()
    for first, i in enumerate(links):
        for second, j in enumerate(links):
            block = found[i, j] = [[0] * (2 * TURN) for _ in range(2 * TURN)]
            for a, row in zip(PLANE, matrix[size * first :], strict=False):
                for b, entry in zip(PLANE, row[size * second :], strict=False):
                    block[a][b] = entry
    return found


def _wrenches(
    state: State, scalars: Scalars, loads: Mapping[str, Acting], forces: list[AnyScalar]
) -> list[list[AnyScalar]]:
    """Sum (F, M) of loads and outside forces on each link, about its origin.

    Efforts of loads on joints are added to `forces`.
    """
    index, model = state.tree.index, state.model
    total: list[list[AnyScalar]] = [[0] * (2 * TURN) for _ in state.tree.links]

    def push(body: str, force: Vector, arm: Vector, torque: Vector = ZERO) -> None:
        if body != GROUND:  # nothing moves the ground
            add_force(total[index(body)], force, arm, torque)

    for body, (x, z, torque) in scalars.body_wrench.items():
        push(body, (x, 0, z), state.frame(body).arm, (0, torque, 0))
    for name, (x, z) in scalars.point_force.items():
        push(model.points[name].body, (x, 0, z), state.points[name].arm)
    for action in (action for load in loads.values() for action in load.actions):
        if action.joint:
            k = index(model.joints[action.joint].child)
            forces[k] = forces[k] + action.effort
        elif action.point:
            push(model.points[action.point].body, action.force, state.points[action.point].arm)
        else:
            push(action.body, action.force, state.frame(action.body).arm, (0, action.moment, 0))
    return total
