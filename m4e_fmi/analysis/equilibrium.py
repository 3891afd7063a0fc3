"""Where a system stays at rest: Newton's method with exact derivatives.

Velocities are zero; coordinates (and states that are no part of a motion) are sought such that
every rate is zero. Steps are shortened by the natural monotonicity test, which does not depend on
units or on the scaling of the equations: P. Deuflhard, "Newton Methods for Nonlinear Problems"
(Springer, 2004), section 3.3, algorithm NLEQ-ERR. Where nothing says how far to move, as along the
sea for a body that floats freely, the shortest step is taken, that is none.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.analysis.points import (
    At,
    Evaluation,
    Floats,
    Matrix,
    OperatingPoint,
    System,
    motion,
    observed,
    operating_point,
    program_and_model,
)
from m4e_fmi.errors import RunError
from m4e_fmi.program import Program, jacobian

MOST_STEPS = 100
SMALLEST_STEP = 1e-8
"""Fraction of a Newton step below which the search is given up."""
ACCURACY = 1e-12
"""Relative size of the last Newton step; it converges quadratically, so the result is better."""
REST = 1e-9
"""Rates that a change of all states by this much of 1 + |state| could cause are zero."""
RANK = 1e-12
"""Singular values of the scaled Jacobian below this, relative to the largest, are zero."""
REMEDY = (
    "start nearer to the equilibrium: `at`, for instance the end of a simulation with more damping"
)


class Balance:
    """The rates that must be zero at rest, and their derivatives by what may move."""

    def __init__(self, program: Program) -> None:
        self.program = program
        pairs = motion(program)
        self.velocities = [v for _, v in pairs]
        partner = dict(pairs)
        moving = [k for k in range(len(program.states)) if k not in set(self.velocities)]
        self.unknowns = moving
        """States that are sought: coordinates, and what is no part of a motion."""
        names = [program.states[partner.get(k, k)].name for k in moving]
        self.equations = tuple(program.states[partner.get(k, k)] for k in moving)
        self.observed = observed(program, [f"der({name})" for name in names])
        """The program with the equations as outputs."""
        self._rates = Evaluation(self.observed)
        by = [program.states[k].name for k in moving]
        self._slopes = Matrix(jacobian(self.observed, "outputs", by))

    def at_rest(self, point: OperatingPoint) -> OperatingPoint:
        """`point` with all velocities zero."""
        states = point.states.copy()
        states[self.velocities] = 0.0
        return point.with_states(states)

    def moved(self, point: OperatingPoint, step: Floats) -> OperatingPoint:
        states = point.states.copy()
        states[self.unknowns] += step
        return point.with_states(states)

    def rates(self, point: OperatingPoint) -> Floats:
        return self._rates.at(point)

    def slopes(self, point: OperatingPoint) -> Floats:
        return self._slopes.at(point)

    def sizes(self, point: OperatingPoint) -> Floats:
        """1 + |unknown|: what a change is compared with."""
        return 1.0 + np.abs(point.states[self.unknowns])

    def newton(self, point: OperatingPoint) -> Floats:
        """N: to first order, N r is the shortest change of the unknowns that takes rates r to zero.

        LinAlgError if a derivative is not finite.
        """
        slopes, sizes = self.slopes(point), self.sizes(point)
        # rows and columns are scaled, so that the rank does not depend on units
        rows = np.linalg.norm(slopes * sizes, axis=1)
        rows[rows == 0.0] = 1.0
        inverse = np.linalg.pinv(slopes * sizes / rows[:, None], rcond=RANK)
        return -(sizes[:, None] * inverse) / rows


def equilibrium(system: System, *, at: At = None, time: float | None = None) -> OperatingPoint:
    """The equilibrium found from the point `at`, with its inputs and parameters, at `time` [s].

    `system` and `at` are as for `linearize`. Which equilibrium is found depends on where the search
    starts; whether it is stable is seen from the eigenvalues there. Raises RunError if none is
    found, naming the joint that is furthest from rest, InputError for an unknown name.
    """
    program, _ = program_and_model(system)
    balance = Balance(program)
    point = balance.at_rest(operating_point(program, at, time=time))
    return _found(balance, point)


def _found(balance: Balance, point: OperatingPoint) -> OperatingPoint:
    """Newton's method from `point`."""
    damping = 1.0
    for _ in range(MOST_STEPS):
        rates, sizes = balance.rates(point), balance.sizes(point)
        try:
            newton = balance.newton(point)
        except np.linalg.LinAlgError:
            raise _lost(balance, point, "something is not finite there") from None
        step = newton @ rates
        if np.linalg.norm(step / sizes) <= ACCURACY:
            point = balance.moved(point, step)
            _check_rest(balance, point)
            return point
        point, damping = _nearer(balance, point, newton, step, min(1.0, 2 * damping))
    raise _lost(balance, point, f"{MOST_STEPS} steps were taken")


def _nearer(
    balance: Balance, point: OperatingPoint, newton: Floats, step: Floats, damping: float
) -> tuple[OperatingPoint, float]:
    """The end of the largest part of `step` that leads nearer, and that part."""
    sizes = balance.sizes(point)
    while damping >= SMALLEST_STEP:
        ahead = balance.moved(point, damping * step)
        # the step that is left, as the old derivatives see it, has to be shorter
        left = newton @ balance.rates(ahead)
        if np.linalg.norm(left / sizes) <= (1 - damping / 4) * np.linalg.norm(step / sizes):
            return ahead, damping
        damping /= 2
    raise _lost(balance, point, "no step leads nearer")


def _check_rest(balance: Balance, point: OperatingPoint) -> None:
    """RunError unless what is left of the rates is rounding."""
    allowed = REST * (1.0 + np.abs(balance.slopes(point)) @ balance.sizes(point))
    if not (np.abs(balance.rates(point)) <= allowed).all():
        raise _lost(balance, point, "nothing holds it there")


def _lost(balance: Balance, point: OperatingPoint, why: str) -> RunError:
    """What to say where the search ends without an equilibrium."""
    rates = balance.rates(point)
    k = int(np.argmax(np.where(np.isfinite(rates), np.abs(rates), np.inf)))
    worst = balance.equations[k]
    message = (
        f"{point.program.name}: no equilibrium was found: {why}; "
        f"the rate of {worst.name} is {rates[k]:.6g} {worst.unit}/s"
    )
    return RunError(message, REMEDY)
