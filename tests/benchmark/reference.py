"""The right answer: accelerations and energy from the dense equations, in 50 digits where asked.

Independent of every engine: positions are written down, their derivatives taken by hand, and
BᵀmB · u̇ = Bᵀ(f − m Ḃu) is solved by Gaussian elimination in mpmath.
"""

from __future__ import annotations

from typing import Any

from benchmark.systems import GRAVITY, GROUND, Spring, System, Vector

DIGITS = 50

Pair = tuple[Any, Any]


class Motion:
    """Positions, rows of B and Ḃu of a system at one state, over numbers of 50 digits or floats."""

    def __init__(self, system: System, q: Any, u: Any, *, exact: bool) -> None:
        import mpmath

        mpmath.mp.dps = DIGITS
        self.context = mp = mpmath.mp if exact else mpmath.fp
        self.system = system
        self.q = [mp.mpf(v) for v in q]
        self.u = [mp.mpf(v) for v in u]
        self.turns: list[Pair] = []
        self.position: list[Pair] = []
        self.columns: list[dict[int, Pair]] = []
        self.bias: list[Pair] = []
        for k, link in enumerate(system.links):
            parent = link.parent
            slide = (self.q[k] * link.direction[0], self.q[k] * link.direction[1])
            arm = link.parent_to_joint if link.revolute else _sum(link.parent_to_joint, slide)
            joint = self.point(parent, arm)
            own = system.angle_index(k)
            angle = self.q[own] if own != GROUND else mp.zero
            self.turns.append((mp.cos(angle), mp.sin(angle)))
            columns, bias = self.of_point(parent, arm)
            if not link.revolute:
                along = self.turned(parent, link.direction)
                columns[k] = along
                omega = self.omega(parent)
                bias = _sum(bias, _scaled(2 * omega * self.u[k], _tilde(along)))
            lever = self.turned(k, link.joint_to_child)
            if own != GROUND:
                columns[own] = _sum(columns.get(own, (0, 0)), _tilde(lever))
            self.position.append(_sum(joint, lever))
            self.columns.append(columns)
            self.bias.append(_sum(bias, _scaled(-(self.omega(k) ** 2), lever)))

    def omega(self, k: int) -> Any:
        own = self.system.angle_index(k)
        return self.u[own] if own != GROUND else 0

    def turned(self, k: int, v: Pair) -> Pair:
        """A vector of link k's frame in world axes."""
        c, s = self.turns[k] if k != GROUND else (1, 0)
        return c * v[0] + s * v[1], c * v[1] - s * v[0]

    def point(self, k: int, arm: Pair) -> Pair:
        return _sum(self.position[k] if k != GROUND else (0, 0), self.turned(k, arm))

    def of_point(self, k: int, arm: Pair) -> tuple[dict[int, Pair], Pair]:
        """Columns of B and Ḃu of a point fixed in link k."""
        if k == GROUND:
            return {}, (0, 0)
        lever, own = self.turned(k, arm), self.system.angle_index(k)
        columns = dict(self.columns[k])
        if own != GROUND:
            columns[own] = _sum(columns.get(own, (0, 0)), _tilde(lever))
        return columns, _sum(self.bias[k], _scaled(-(self.omega(k) ** 2), lever))

    def velocity(self, columns: dict[int, Pair]) -> Pair:
        total: Pair = (0, 0)
        for j, column in columns.items():
            total = _sum(total, _scaled(self.u[j], column))
        return total


def accelerations(system: System, q: Any, u: Any, *, exact: bool = True) -> list[Any]:
    """u̇ at (q, u), as mpmath numbers of 50 digits, or as floats (dense double precision)."""
    motion = Motion(system, q, u, exact=exact)
    mp, n = motion.context, system.size
    matrix, forcing = mp.zeros(n), mp.zeros(n, 1)
    for k, link in enumerate(system.links):
        force = _scaled(-link.mass, _sum(motion.bias[k], (0, mp.mpf(GRAVITY))))
        columns = motion.columns[k]
        for i, a in columns.items():
            forcing[i] += _dot(a, force)
            for j, b in columns.items():
                matrix[i, j] += link.mass * _dot(a, b)
        own = system.angle_index(k)
        if own != GROUND:
            matrix[own, own] += link.inertia
    for spring in system.springs:
        _add_spring(motion, spring, forcing)
    for torsion in system.torsions:
        k, back = torsion.link, system.angle_index(system.links[torsion.link].parent)
        angle = motion.q[k] - (motion.q[back] if back != GROUND else 0)
        rate = motion.u[k] - (motion.u[back] if back != GROUND else 0)
        moment = -torsion.stiffness * (angle - torsion.angle) - torsion.damping * rate
        forcing[k] += moment
        if back != GROUND:
            forcing[back] -= moment
    return list(mp.lu_solve(matrix, forcing))


def _add_spring(motion: Motion, spring: Spring, forcing: Any) -> None:
    ends: list[tuple[int, Vector]] = [
        (spring.first, spring.first_point),
        (spring.second, spring.second_point),
    ]
    points = [motion.point(k, arm) for k, arm in ends]
    columns = [motion.of_point(k, arm)[0] for k, arm in ends]
    velocities = [motion.velocity(c) for c in columns]
    along = _sum(points[1], _scaled(-1, points[0]))
    distance = motion.context.sqrt(_dot(along, along))
    along = _scaled(1 / distance, along)
    rate = _dot(along, _sum(velocities[1], _scaled(-1, velocities[0])))
    pull = spring.stiffness * (distance - spring.length) + spring.damping * rate
    for sign, of_end in zip((1, -1), columns, strict=True):
        for j, column in of_end.items():
            forcing[j] += sign * pull * _dot(column, along)


def energy(system: System, q: Any, u: Any) -> float:
    """Kinetic and potential energy [J] of a system without springs."""
    motion = Motion(system, q, u, exact=False)
    total: Any = 0
    for k, link in enumerate(system.links):
        v = motion.velocity(motion.columns[k])
        total += link.mass * (_dot(v, v) / 2 + GRAVITY * motion.position[k][1])
        total += link.inertia * motion.omega(k) ** 2 / 2
    return total


def _sum(a: Pair, b: Pair) -> Pair:
    return a[0] + b[0], a[1] + b[1]


def _scaled(factor: Any, a: Pair) -> Pair:
    return factor * a[0], factor * a[1]


def _dot(a: Pair, b: Pair) -> Any:
    return a[0] * b[0] + a[1] * b[1]


def _tilde(a: Pair) -> Pair:
    """Derivative of a turning vector by its angle."""
    return a[1], -a[0]
