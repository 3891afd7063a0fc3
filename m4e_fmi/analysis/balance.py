"""Rates that are zero at rest, and their derivatives by the states that are sought."""

from __future__ import annotations

import numpy as np

from m4e_fmi.analysis.attitudes import attitudes, rotated, tangent_of
from m4e_fmi.analysis.points import (
    Evaluation,
    Floats,
    Matrix,
    OperatingPoint,
    motion,
    observed,
)
from m4e_fmi.program import Program, jacobian

RANK = 1e-12
"""Singular values of the scaled Jacobian below this, relative to the largest, are zero."""


class Balance:
    """The rates that must be zero at rest, and their derivatives by what may move."""

    def __init__(self, program: Program) -> None:
        self.program = program
        pairs = motion(program)
        self._attitudes = attitudes(program)
        turning = [k for a in self._attitudes for k in a.turning]
        quaternions = [k for a in self._attitudes for k in a.quaternion]
        self.velocities = [*(v for _, v in pairs), *turning]
        partner = dict(pairs)
        passed = {*self.velocities, *quaternions}
        self._plain = [k for k in range(len(program.states)) if k not in passed]
        self.unknowns = [*self._plain, *quaternions]
        """States that are sought: coordinates, and those that are no part of a motion.

        Quaternions are sought by small rotations, three each."""
        places = [*(partner.get(k, k) for k in self._plain), *turning]
        self.equations = tuple(program.states[k] for k in places)
        names = [program.states[k].name for k in places]
        self.observed = observed(program, [f"der({name})" for name in names])
        """The program with the equations as outputs."""
        units = np.array([program.states[k].unit for k in self._plain], dtype=str)
        self._alike = (units[:, None] == units) & (units != "rad")
        turned = [v.name for a in self._attitudes for v in a.rotations]
        self.unknown_names = [*(program.states[k].name for k in self._plain), *turned]
        """Names of what a step is of: of quaternions of their small rotations."""
        self._rates = Evaluation(self.observed)
        by = [program.states[k].name for k in self.unknowns]
        self._slopes = Matrix(jacobian(self.observed, "outputs", by))

    def at_rest(self, point: OperatingPoint) -> OperatingPoint:
        """`point` with all velocities zero."""
        states = point.states.copy()
        states[self.velocities] = 0.0
        return point.with_states(states)

    def moved(self, point: OperatingPoint, step: Floats) -> OperatingPoint:
        """`point` with `step` (n,), in SI, added to the unknowns."""
        states, size = point.states.copy(), len(self._plain)
        states[self._plain] += step[:size]
        for number, attitude in enumerate(self._attitudes):
            turn = step[size + 3 * number : size + 3 * number + 3]
            places = list(attitude.quaternion)
            states[places] = rotated(states[places], turn)
        return point.with_states(states)

    def rates(self, point: OperatingPoint) -> Floats:
        """Rates that are zero at rest, shape (n,), in SI."""
        return self._rates.at(point)

    def tangent(self, point: OperatingPoint) -> Floats:
        """T (m, n) [1]: a small `step` (n,) of `moved` changes the unknowns (m,) by T step."""
        from scipy.linalg import block_diag

        turns = (tangent_of(point.states[list(a.quaternion)]) for a in self._attitudes)
        return np.asarray(block_diag(np.eye(len(self._plain)), *turns), dtype=np.float64)

    def slopes(self, point: OperatingPoint) -> Floats:
        """Derivatives of the rates by a step of the unknowns, shape (n, n), in SI."""
        return self._slopes.at(point) @ self.tangent(point)

    def sizes(self, point: OperatingPoint) -> Floats:
        """Scales of the unknowns, shape (n,): 1 rad; 1 + the largest unknown of the same unit."""
        values = np.abs(point.states[self._plain])
        plain = 1.0 + np.max(np.where(self._alike, values, 0.0), axis=1, initial=0.0)
        return np.concatenate([plain, np.ones(3 * len(self._attitudes))])

    def distance(self, one: OperatingPoint, other: OperatingPoint) -> float:
        """The largest difference of an unknown, over its size at `other` [1]."""
        size = len(self._plain)
        off = np.abs(other.states - one.states)
        plain = off[self._plain] / self.sizes(other)[:size]
        turned = off[self.unknowns[size:]]
        return float(np.max(np.concatenate([plain, turned]), initial=0.0))

    def newton(self, point: OperatingPoint) -> Floats:
        """N (n, n) at `point`, in SI: N r is the shortest change that makes rates r zero.

        To first order; changes of the unknowns are compared by their `sizes`.
        """
        slopes, sizes = self.slopes(point), self.sizes(point)
        # rows and columns are scaled, so that the rank does not depend on units
        rows = np.linalg.norm(slopes * sizes, axis=1)
        rows[rows <= RANK * np.max(rows)] = np.inf  # rounding, which would count as the others
        inverse: Floats = np.linalg.pinv(slopes * sizes / rows[:, None], rcond=RANK)
        return np.asarray(-(sizes[:, None] * inverse) / rows, dtype=np.float64)
