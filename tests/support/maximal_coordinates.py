"""Trajectories by another formulation: all bodies free, held together by Lagrange multipliers.

The paper's Eq. (1) with its constraints, J a = −J̇ v, solved together for accelerations and
multipliers:

    [ 𝓜  Jᵀ ] [  a ]   [   g   ]
    [ J  0  ] [ −λ ] = [ −J̇ v ]

in the coordinates x, z, θ of every body (index reduced to one), integrated by SciPy's DOP853. After
every step positions and velocities are brought back to the constraints. Reads the paper's lists by
itself and uses nothing of m4e_fmi.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853

TOLERANCE = 1e-13


def trajectories(lists: Mapping[str, Any], times: np.ndarray) -> np.ndarray:
    """x, z, θ of every body, (len(times), 3N), of a system in the paper's lists."""
    system = MaximalCoordinates(lists)
    n = system.size
    state = np.concatenate([system.start_positions(), np.zeros(n)])
    state[n:] = system.start_velocities(state[:n])
    rows = [state[:n]]
    for begin, end in pairwise(times):
        solver = DOP853(system.rates, begin, state, end, rtol=TOLERANCE, atol=TOLERANCE)
        while solver.status == "running":
            solver.step()
            solver.y = system.projected(solver.y)
        state = solver.y
        rows.append(state[:n])
    return np.array(rows)


class MaximalCoordinates:
    """Masses, constraints and forces of a system in the paper's lists."""

    def __init__(self, lists: Mapping[str, Any]) -> None:
        self.lists = lists
        self.joints = [tuple(row) for row in lists["joints"]]
        self.types = list(lists["types"])
        count = len(self.joints)
        self.size = 3 * count
        self.origin = np.array(lists.get("Reference_frame_Origin", (0, 0)), float)
        self.arms = [
            (_vector(a), _vector(b))
            for a, b in zip(lists["parent_cg_to_joint"], lists["joint_to_child_cg"], strict=True)
        ]
        self.directions = [_vector(row) for row in lists["prismatic_direction"]]
        mass, inertia = np.ravel(lists["m0"]), np.ravel(lists["J0"])
        self.mass = np.ravel(np.column_stack([mass, mass, inertia])).astype(float)
        self.weight = np.zeros(self.size)
        self.weight[1::3] = -mass * float(lists["g"])
        self.forces = _forces(lists, self.origin)
        self.constraints = sum(0 if kind == "F" else 2 for kind in self.types)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        n, c = self.size, self.constraints
        q, v = y[:n], y[n:]
        _, jacobian, bias = self.constrained(q, v)
        force = self.weight.copy()
        for push in self.forces:
            push(t, q, v, force)
        matrix = np.zeros((n + c, n + c))
        matrix[range(n), range(n)] = self.mass
        matrix[:n, n:] = jacobian.T
        matrix[n:, :n] = jacobian
        solved = np.linalg.solve(matrix, np.concatenate([force, -bias]))
        return np.concatenate([v, solved[:n]])

    def constrained(
        self, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Constraints, their Jacobian, and J̇ v."""
        residual, bias = np.zeros(self.constraints), np.zeros(self.constraints)
        jacobian = np.zeros((self.constraints, self.size))
        k = 0
        for (a, b), kind, (p, c), d in zip(
            self.joints, self.types, self.arms, self.directions, strict=True
        ):
            if kind == "F":
                continue
            ra, va, pa, wa, ta = self._end(q, v, a, p)
            rb, vb, pb, wb, _ = self._end(q, v, b, -c)
            ia, ib = 3 * (a - 1), 3 * (b - 1)
            if kind == "R":
                residual[k : k + 2] = rb - ra
                bias[k : k + 2] = -(wb**2) * pb + wa**2 * pa
                jacobian[k : k + 2, ib : ib + 2] = np.eye(2)
                jacobian[k : k + 2, ib + 2] = _tilde(pb)
                if a:
                    jacobian[k : k + 2, ia : ia + 2] = -np.eye(2)
                    jacobian[k : k + 2, ia + 2] = -_tilde(pa)
            else:
                normal = _turned(np.array([-d[1], d[0]]), ta)
                apart, rate = rb - ra, vb - va
                residual[k] = normal @ apart
                residual[k + 1] = q[ib + 2] - ta
                bias[k] = (
                    -(wa**2) * normal @ apart
                    + 2 * wa * _tilde(normal) @ rate
                    + normal @ (-(wb**2) * pb + wa**2 * pa)
                )
                jacobian[k, ib : ib + 2] = normal
                jacobian[k, ib + 2] = normal @ _tilde(pb)
                jacobian[k + 1, ib + 2] = 1
                if a:
                    jacobian[k, ia : ia + 2] = -normal
                    jacobian[k, ia + 2] = _tilde(normal) @ apart - normal @ _tilde(pa)
                    jacobian[k + 1, ia + 2] = -1
            k += 2
        return residual, jacobian, bias

    def _end(self, q: np.ndarray, v: np.ndarray, body: int, arm: np.ndarray) -> tuple:
        """Position, velocity, turned arm, ω and θ at one side of a joint."""
        return _end(q, v, body, arm, self.origin)

    def projected(self, y: np.ndarray) -> np.ndarray:
        """Positions and velocities with the constraints met, changed as little as 𝓜 allows."""
        n = self.size
        q, v = y[:n].copy(), y[n:].copy()
        residual, jacobian, _ = self.constrained(q, v)
        weighted = jacobian / self.mass
        matrix = weighted @ jacobian.T
        if self.constraints:
            q -= weighted.T @ np.linalg.solve(matrix, residual)
            _, jacobian, _ = self.constrained(q, v)
            weighted = jacobian / self.mass
            v -= weighted.T @ np.linalg.solve(weighted @ jacobian.T, jacobian @ v)
        return np.concatenate([q, v])

    def start_positions(self) -> np.ndarray:
        """x, z, θ of every body at ic; parents come first in the lists used here."""
        q = np.zeros(self.size)
        values = self._joint_values(0)
        for row, (a, b) in enumerate(self.joints):
            kind, (p, c), d = self.types[row], self.arms[row], self.directions[row]
            theta = q[3 * a - 1] if a else 0.0
            place = q[3 * a - 3 : 3 * a - 1] if a else self.origin
            own = values[row]
            if kind == "F":  # the paper's code starts it where parent_cg_to_joint says
                q[3 * b - 3 : 3 * b] = (*(self.origin + p), own[2])
            elif kind == "R":
                q[3 * b - 3 : 3 * b - 1] = place + _turned(p, theta) + _turned(c, own[0])
                q[3 * b - 1] = own[0]
            else:
                q[3 * b - 3 : 3 * b - 1] = place + _turned(p + own[0] * d + c, theta)
                q[3 * b - 1] = theta
        return q

    def start_velocities(self, q: np.ndarray) -> np.ndarray:
        """Velocities of all bodies that meet J v = 0 and the joint velocities of ic."""
        _, jacobian, _ = self.constrained(q, np.zeros(self.size))
        rows, wanted = [], []
        for row, (a, b) in enumerate(self.joints):
            own = self._joint_values(1)[row]
            if self.types[row] == "P":  # along the axis, against the parent
                line = np.zeros(self.size)
                axis = _turned(self.directions[row], q[3 * a - 1] if a else 0.0)
                line[3 * b - 3 : 3 * b - 1] = axis
                if a:
                    apart = q[3 * b - 3 : 3 * b - 1] - q[3 * a - 3 : 3 * a - 1]
                    line[3 * a - 3 : 3 * a - 1] = -axis
                    line[3 * a - 1] = -axis @ _tilde(apart)
                rows.append(line)
                wanted.append(own[0])
            else:
                for k, value in zip(range(3)[-len(own) :], own, strict=True):
                    line = np.zeros(self.size)
                    line[3 * b - 3 + k] = 1
                    rows.append(line)
                    wanted.append(value)
        matrix = np.vstack([jacobian, rows])
        right = np.concatenate([np.zeros(self.constraints), wanted])
        return np.linalg.solve(matrix, right)

    def _joint_values(self, half: int) -> list[np.ndarray]:
        """Coordinates (half 0) or velocities (1) of each row of joints, from ic."""
        sizes = {
            b: 3 if kind == "F" else 1 for (_, b), kind in zip(self.joints, self.types, strict=True)
        }
        total = sum(sizes.values())
        ic = np.ravel(self.lists.get("ic", np.zeros(2 * total))).astype(float)
        first, starts = half * total, {}
        for body in sorted(sizes):
            starts[body] = first
            first += sizes[body]
        return [ic[starts[b] : starts[b] + sizes[b]] for _, b in self.joints]


Force = Callable[[float, np.ndarray, np.ndarray, np.ndarray], None]


def _forces(lists: Mapping[str, Any], origin: np.ndarray) -> list[Force]:
    given = lists.get("Force", {})
    points = lists.get("Initial_Points", {})
    made: list[Force] = []
    for body, *components in given.get("CG", []):
        made.append(_applied(body, components))
    for (first, second), (length, stiffness) in given.get("TensionSpring", []):
        ends = [_point(name, points) for name in (first, second)]
        made.append(_tension(ends, origin, float(stiffness), float(length), 0.0))
    for (first, second), damping in given.get("TensionDamper", []):
        ends = [_point(name, points) for name in (first, second)]
        made.append(_tension(ends, origin, 0.0, 0.0, float(damping)))
    for bodies, (angle, stiffness) in given.get("TorsionSpring", []):
        made.append(_torsion(bodies, float(stiffness), float(angle), 0.0))
    for bodies, damping in given.get("TorsionDamper", []):
        made.append(_torsion(bodies, 0.0, 0.0, float(damping)))
    return made


def _applied(body: int, components: Sequence[Any]) -> Force:
    import sympy

    t = sympy.Symbol("t", real=True)
    functions = [sympy.lambdify(t, sympy.sympify(c), "math") for c in components]

    def push(time: float, q: np.ndarray, v: np.ndarray, total: np.ndarray) -> None:
        del q, v
        for k, function in enumerate(functions):
            total[3 * body - 3 + k] += function(time)

    return push


def _tension(
    ends: list[tuple[int, np.ndarray]], origin: np.ndarray, k: float, length: float, c: float
) -> Force:
    def push(time: float, q: np.ndarray, v: np.ndarray, total: np.ndarray) -> None:
        del time
        (r1, v1, p1, _, _), (r2, v2, p2, _, _) = (_end(q, v, *end, origin) for end in ends)
        apart = r2 - r1
        distance = math.hypot(*apart)
        along = apart / distance
        pull = (k * (distance - length) + c * (v2 - v1) @ along) * along
        for (body, _), arm, force in zip(ends, (p1, p2), (pull, -pull), strict=True):
            if body:
                total[3 * body - 3 : 3 * body - 1] += force
                total[3 * body - 1] += arm[1] * force[0] - arm[0] * force[1]

    return push


def _torsion(bodies: tuple[int, int], k: float, rest: float, c: float) -> Force:
    def push(time: float, q: np.ndarray, v: np.ndarray, total: np.ndarray) -> None:
        del time
        angles = [q[3 * body - 1] if body else 0.0 for body in bodies]
        rates = [v[3 * body - 1] if body else 0.0 for body in bodies]
        moment = k * (angles[1] - angles[0] - rest) + c * (rates[1] - rates[0])
        for body, part in zip(bodies, (moment, -moment), strict=True):
            if body:
                total[3 * body - 1] += part

    return push


def _point(name: str, points: Mapping[str, Any]) -> tuple[int, np.ndarray]:
    """Body and place of a point in the paper's first spelling."""
    kind, first, second = name[:2], int(name[2]), int(name[3])
    if kind == "GR":
        return 0, np.array(points["GR"][second], float)
    if kind == "CG":
        return first, np.zeros(2)
    return first, np.array(points["BD"][first][second], float)


def _end(
    q: np.ndarray, v: np.ndarray, body: int, arm: np.ndarray, origin: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, float]:
    """Position, velocity, turned arm, ω and θ of a body's point; body 0 is the ground."""
    if body == 0:
        return origin + arm, np.zeros(2), arm, 0.0, 0.0
    i = 3 * (body - 1)
    theta, omega = q[i + 2], v[i + 2]
    turned = _turned(arm, theta)
    return q[i : i + 2] + turned, v[i : i + 2] + omega * _tilde(turned), turned, omega, theta


def _turned(arm: np.ndarray, theta: Any) -> np.ndarray:
    c, s = math.cos(theta), math.sin(theta)
    return np.array([c * arm[0] + s * arm[1], c * arm[1] - s * arm[0]])


def _tilde(arm: np.ndarray) -> np.ndarray:
    return np.array([arm[1], -arm[0]])


def _vector(row: Sequence[Any]) -> np.ndarray:
    return np.nan_to_num(np.array(row, float))
