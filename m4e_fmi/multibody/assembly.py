"""The equations of motion, assembled once over whatever scalars come in.

    Bᵀ(𝓜 + A)B u̇ = Bᵀ(g + g_g) − Bᵀ(𝓜 + A)Ḃ u + τ        (the paper's Eq. 5 with added mass)

𝓜 is the dry mass matrix; A the added mass at infinite frequency of the bodies that have it, a full
matrix in world axes about the centres of gravity; gravity acts on the dry mass only; τ are efforts
of the joints. Run on SymPy this is what people read, run on a tape it is what machines run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from m4e_fmi.model import Model
from m4e_fmi.model.elements import GROUND, quantity, vector
from m4e_fmi.model.expression import Values
from m4e_fmi.multibody.kinematics import GROUND_FRAME, Arm, Frame, frames
from m4e_fmi.multibody.loads import actions, potential
from m4e_fmi.multibody.planar import Pair, added, moment, scaled
from m4e_fmi.multibody.topology import Link, Topology
from m4e_fmi.program.tape import Scalar

Wrench = tuple[Any, Any, Any]
Matrix = list[list[Any]]
Blocks = dict[tuple[int, int], Matrix]
"""3×3 blocks of an inertia matrix by pair of links; a pair without one has none."""


@dataclass(frozen=True)
class Scalars:
    """The scalars to assemble with: q, u, the time, parameters by name, and what acts from outside.

    `body_wrench[name]` = (F_x, F_z, M_y) at a centre of gravity, `point_force[name]` = (F_x, F_z),
    `effort[joint]`; what is absent is zero. `added_mass` has three rows (x, z, θ) and columns for
    each body with added mass, in the order of their numbers. `number` makes a scalar of a constant.
    """

    q: Sequence[Any]
    u: Sequence[Any]
    time: Any
    parameters: Mapping[str, Any]
    body_wrench: Mapping[str, Wrench]
    point_force: Mapping[str, Pair]
    effort: Mapping[str, Any]
    added_mass: Matrix
    number: Callable[[float], Any] = float


@dataclass(frozen=True)
class Assembly:
    """The assembled equations `mass_matrix` · u̇ = `forcing`, and the motion they were made from."""

    frames: list[Frame]
    points: dict[str, Arm]
    mass_matrix: Matrix
    forcing: list[Any]
    kinetic: Any
    potential: Any


@dataclass(frozen=True)
class _Motion:
    """A model in motion: its frames and points, and the scalars of its quantities."""

    model: Model
    tree: Topology
    frames: list[Frame]
    points: dict[str, Arm]
    values: Values

    def frame(self, body: str) -> Frame:
        return GROUND_FRAME if body == GROUND else self.frames[self.tree.index(body)]

    def of_body(self, link: Link, field: str) -> Any:
        return quantity(self.model.bodies[link.body], field).evaluate(self.values)

    @property
    def gravity(self) -> Any:
        return quantity(self.model, "gravity").evaluate(self.values)


def assemble(model: Model, tree: Topology, scalars: Scalars) -> Assembly:
    """Assemble the equations of `model` over `scalars`."""
    values = Values({**scalars.parameters, "t": scalars.time}, number=scalars.number)
    motion = _Motion(model, tree, frames(tree, scalars.q, scalars.u, values), {}, values)
    for name, point in model.points.items():
        x, z = (part.evaluate(values) for part in vector(point, "at"))
        motion.points[name] = motion.frame(point.body).arm((x, z))
    inertia = _inertia(motion, scalars.added_mass)
    wrenches = _wrenches(motion, scalars)
    mass_matrix, forcing = _projected(motion, inertia, wrenches, scalars.u)
    _add_efforts(tree, scalars.effort, forcing)
    return Assembly(
        frames=motion.frames,
        points=motion.points,
        mass_matrix=mass_matrix,
        forcing=forcing,
        kinetic=_kinetic(motion.frames, inertia),
        potential=_potential(motion),
    )


def _projected(
    motion: _Motion, inertia: Blocks, wrenches: list[list[Any]], u: Sequence[Any]
) -> tuple[Matrix, list[Any]]:
    """Bᵀ(𝓜 + A)B and Bᵀ(g − (𝓜 + A)Ḃu)."""
    size = len(u)
    mass_matrix: Matrix = [[0] * size for _ in range(size)]
    forcing: list[Any] = [0] * size
    rows = [_rows(frame) for frame in motion.frames]
    bias = [_bias(frame, u) for frame in motion.frames]
    remaining = [list(wrench) for wrench in wrenches]
    for (i, j), block in inertia.items():
        for a in range(3):
            for b in range(3):
                if not _is_zero(block[a][b]):
                    _add_product(mass_matrix, rows[i][a], block[a][b], rows[j][b])
                    remaining[i][a] = remaining[i][a] - block[a][b] * bias[j][b]
    for force, row in zip(remaining, rows, strict=True):
        for a in range(3):
            for k, column in row[a].items():
                forcing[k] = forcing[k] + column * force[a]
    return mass_matrix, forcing


def _add_efforts(tree: Topology, effort: Mapping[str, Any], forcing: list[Any]) -> None:
    """Efforts act on the child and back on the parent: with absolute angles, on two coordinates."""
    for link in tree.links:
        if link.joint_name not in effort:
            continue
        (k,) = link.coordinates
        forcing[k] = forcing[k] + effort[link.joint_name]
        if link.joint.type == "revolute" and link.parent >= 0:
            back = tree.links[link.parent].angle
            if back >= 0:
                forcing[back] = forcing[back] - effort[link.joint_name]


def solve_symmetric(matrix: Matrix, right: Sequence[Any]) -> list[Any]:
    """x of matrix · x = right by L D Lᵀ without pivoting; the matrix is positive definite.

    Structural zeros (the integer 0) cost nothing. Works over any scalar.
    """
    n = len(right)
    lower: Matrix = [[0] * n for _ in range(n)]
    diagonal: list[Any] = [0] * n
    x = list(right)
    for j in range(n):
        pivot = matrix[j][j]
        for k in range(j):
            if not _is_zero(lower[j][k]):
                pivot = pivot - lower[j][k] * lower[j][k] * diagonal[k]
        diagonal[j] = pivot
        for i in range(j + 1, n):
            entry = matrix[i][j]
            for k in range(j):
                if not (_is_zero(lower[i][k]) or _is_zero(lower[j][k])):
                    entry = entry - lower[i][k] * diagonal[k] * lower[j][k]
            lower[i][j] = entry if _is_zero(entry) else entry / pivot
    for i in range(n):
        for k in range(i):
            if not _is_zero(lower[i][k]):
                x[i] = x[i] - lower[i][k] * x[k]
    for i in range(n - 1, -1, -1):
        x[i] = x[i] / diagonal[i]
        for k in range(i + 1, n):
            if not _is_zero(lower[k][i]):
                x[i] = x[i] - lower[k][i] * x[k]
    return x


def _is_zero(value: Any) -> bool:
    if isinstance(value, Scalar):
        return value.tape.value(value.index) == 0.0
    return isinstance(value, int) and value == 0


def _rows(frame: Frame) -> tuple[dict[int, Any], dict[int, Any], dict[int, Any]]:
    """The three rows of B of one body: v_x, v_z, ω; column → entry."""
    turning = {frame.angle_index: 1} if frame.angle_index >= 0 else {}
    xs = {k: column[0] for k, column in frame.columns.items()}
    zs = {k: column[1] for k, column in frame.columns.items()}
    return xs, zs, turning


def _bias(frame: Frame, u: Sequence[Any]) -> Wrench:
    """Ḃ u of one body."""
    total: Pair = (0, 0)
    for j, column in frame.column_rates.items():
        total = added(total, scaled(u[j], column))
    return (*total, 0)


def _inertia(motion: _Motion, added_mass: Matrix) -> Blocks:
    """Blocks of 𝓜 + A."""
    blocks: Blocks = {}
    links = motion.tree.links
    for i, link in enumerate(links):
        m, inertia = motion.of_body(link, "mass"), motion.of_body(link, "inertia")
        blocks[i, i] = [[m, 0, 0], [0, m, 0], [0, 0, inertia]]
    wet = [i for i, link in enumerate(links) if motion.model.bodies[link.body].added_mass]
    for first, i in enumerate(wet):
        for second, j in enumerate(wet):
            block = blocks.setdefault((i, j), [[0] * 3 for _ in range(3)])
            for a in range(3):
                for b in range(3):
                    block[a][b] = block[a][b] + added_mass[3 * first + a][3 * second + b]
    return blocks


def _add_product(matrix: Matrix, left: dict[int, Any], factor: Any, right: dict[int, Any]) -> None:
    """matrix += leftᵀ · factor · right, for sparse rows."""
    for i, a in left.items():
        for j, b in right.items():
            matrix[i][j] = matrix[i][j] + a * factor * b


def _wrenches(motion: _Motion, scalars: Scalars) -> list[list[Any]]:
    """Sum (F_x, F_z, M_y) of gravity, loads and outside forces on each link, about its CG."""
    index, links = motion.tree.index, motion.tree.links
    total: list[list[Any]] = [list(scalars.body_wrench.get(k.body, (0, 0, 0))) for k in links]

    def push(i: int, force: Pair, torque: Any) -> None:
        if i >= 0:  # the ground takes what it gets
            parts = (*force, torque)
            total[i] = [old + new for old, new in zip(total[i], parts, strict=True)]

    def push_point(name: str, force: Pair) -> None:
        body = motion.model.points[name].body
        push(index(body), force, moment(motion.points[name].arm, force))

    for i, link in enumerate(links):
        push(i, (0, -motion.of_body(link, "mass") * motion.gravity), 0)
    for name, force in scalars.point_force.items():
        push_point(name, force)
    for load in motion.model.loads.values():
        for action in actions(load, motion.frame, motion.points, motion.values):
            if action.point:
                push_point(action.point, action.force)
            else:
                push(index(action.body), action.force, action.moment)
    return total


def _kinetic(bodies: list[Frame], inertia: Blocks) -> Any:
    """½ vᵀ(𝓜 + A)v."""
    velocity = [(*frame.velocity, frame.omega) for frame in bodies]
    total: Any = 0
    for (i, j), block in inertia.items():
        for a in range(3):
            for b in range(3):
                total = total + velocity[i][a] * block[a][b] * velocity[j][b]
    return total / 2


def _potential(motion: _Motion) -> Any:
    """Potential energy of gravity (zero at Z = 0) and of the springs."""
    total: Any = 0
    for link, frame in zip(motion.tree.links, motion.frames, strict=True):
        total = total + motion.of_body(link, "mass") * motion.gravity * frame.position[1]
    for load in motion.model.loads.values():
        total = total + potential(load, motion.frame, motion.points, motion.values)
    return total
