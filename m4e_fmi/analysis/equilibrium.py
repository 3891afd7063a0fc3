"""Equilibria of a system, found with exact derivatives.

Velocities are zero; coordinates (and states that are no part of a motion) are sought such that
every rate is zero: r(q) = q̈(q, q̇ = 0) = 0.

First the start is followed to where it settles: along q' = r(q), on which the potential energy of a
conservative system can only fall. Pseudo-transient continuation takes implicit steps along it that
grow into Newton's as the rates fall: C. T. Kelley, D. E. Keyes, "Convergence analysis of
pseudo-transient continuation", SIAM J. Numer. Anal. 35 (1998), pp. 508–523.

Then, or for the nearest equilibrium as soon as something depends on the coordinates, Newton's
method. Its steps are shortened by the
natural monotonicity test, which does not depend on units or on the scaling of the equations: P.
Deuflhard, "Newton Methods for Nonlinear Problems" (Springer, 2004), section 3.3, algorithm
NLEQ-ERR. Where nothing says how far to move, as along the sea for a body that floats freely, the
shortest step is taken, that is none.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.analysis.balance import RANK, Balance
from m4e_fmi.analysis.local_laws import followed
from m4e_fmi.analysis.points import (
    At,
    Floats,
    OperatingPoint,
    System,
    operating_point,
    program_and_model,
    rate_unit,
)
from m4e_fmi.errors import RunError

MOST_STEPS = 500
LONGEST_STEP = 0.3
"""Of a settling system, as steps are compared."""
LONGEST_NEWTON_STEP = 1.0
"""Of Newton's method, in the same way: a longer one would pass by what is near."""
CLOSE = 0.05
"""Newton steps shorter than this are taken as they are where the system is stable …"""
SETTLED = 1e-8
"""… and shorter than this where it is not: there the start was an equilibrium."""
FAR = 1e4
"""Newton steps longer than this lead nowhere: hardly anything depends on the coordinates yet."""
SMALLEST_STEP = 1e-8
"""Fraction of a Newton step below which the search is given up."""
ACCURACY = 1e-12
"""Relative size of the last Newton step; it converges quadratically, so the result is better."""
ROUNDING = 1e-6
"""The same, where rounding of the rates lets no step lead nearer."""
REST = 1e-9
"""Rates that changes of all states by this much, compared as steps are, could cause are zero."""
HELD = 0.5
"""A Newton step that leaves more than this of the rates does not lead to where they balance."""
TINY = float(np.finfo(float).tiny)
REMEDY = (
    "start nearer to the equilibrium, for instance at the end of a simulation with more damping"
)
ALONE = "; loads of other FMUs (water, moorings) are not in the model"


def equilibrium(
    system: System, *, at: At = None, time: float | None = None, nearest: bool = False
) -> OperatingPoint:
    """The equilibrium found from the point `at`, with its inputs and parameters, at `time` [s].

    `system` and `at` are as for `linearize`. It is the one in which a conservative system settles
    from there if it is damped heavily, or with `nearest` the one that Newton's method finds, which
    may be unstable; a start that is an equilibrium itself is found in either way. Eigenvalues say
    what it is. Parts whose equations hold about a point only (`LocalLaw`) are renewed until that is
    the equilibrium. Raises RunError if none is found, naming the joint that is furthest from
    rest, InputError for an unknown name.
    """
    program, model = program_and_model(system)
    balance = Balance(program)
    point = balance.at_rest(operating_point(program, at, time=time, model=model))
    return followed(balance, point, lambda start: resting(balance, start, nearest=nearest))


def resting(balance: Balance, point: OperatingPoint, *, nearest: bool) -> OperatingPoint:
    """The equilibrium found from `point`, with all parameters as they are there."""
    point = balance.at_rest(point)
    if not balance.unknowns:
        return point
    return _found(balance, _settled(balance, point, nearest=nearest))


def _settled(balance: Balance, point: OperatingPoint, *, nearest: bool) -> OperatingPoint:
    """A point from which Newton's method leads to where `point` settles, or the nearest such."""
    start, rates = point, balance.rates(point)
    span = LONGEST_STEP / max(np.max(np.abs(rates) / balance.sizes(point)), TINY)
    held = True
    for _ in range(MOST_STEPS):
        newton, slopes, sizes = balance.newton(point), balance.slopes(point), balance.sizes(point)
        growth = _growth(slopes)
        near = FAR if nearest else SETTLED if growth > 0 else CLOSE
        step = newton @ rates
        # of a bar held out level, to first order no turn changes what gravity does
        left, now = (_unrest(r, slopes, sizes) for r in (rates + slopes @ step, rates))
        held = left <= max(REST, HELD * now)
        if held and np.max(np.abs(step) / sizes) <= near:
            return point
        if growth > 0:  # longer steps would lead to where it is not stable, as Newton's do
            span = 0.5 / growth
        while True:
            matrix = np.eye(len(rates)) / span - slopes
            step = np.asarray(np.linalg.solve(matrix, rates), dtype=float)
            length = float(np.max(np.abs(step) / sizes))
            if not length > LONGEST_STEP:
                break
            span *= min(0.5, LONGEST_STEP / length)
        before, point = np.linalg.norm(rates), balance.moved(point, step)
        rates = balance.rates(point)
        span *= min(10.0, max(0.1, float(before / max(np.linalg.norm(rates), TINY))))
    why = f"it has not settled after {MOST_STEPS} steps" if held else "nothing holds it there"
    raise _lost(balance, point, why + _moves_away(balance, start))


def _moves_away(balance: Balance, start: OperatingPoint) -> str:
    """Words on what has a negative stiffness at the start, "" if nothing has."""
    slopes, sizes = balance.slopes(start), balance.sizes(start)
    growth = _growth(slopes)
    if not growth:
        return ""
    values, vectors = np.linalg.eig(slopes)
    shape = np.abs(vectors[:, int(np.argmax(np.real(values)))]) / sizes
    name = balance.unknown_names[int(np.argmax(shape))]
    return (
        f"; at the start it is unstable: a negative stiffness moves {name} away, as that of a body "
        "that capsizes"
    )


def _unrest(rates: Floats, slopes: Floats, sizes: Floats) -> float:
    """The largest of `rates`, as part of what changes of all states by their sizes could cause."""
    return float(np.max(np.abs(rates) / (1.0 + np.abs(slopes) @ sizes)))


def _growth(slopes: Floats) -> float:
    """Fastest growth along q' = r(q): the largest real part of ∂r/∂q, 0 if that is rounding."""
    growth = float(np.max(np.linalg.eigvals(slopes).real))
    return growth if growth > RANK * np.linalg.norm(slopes) else 0.0


def _found(balance: Balance, point: OperatingPoint) -> OperatingPoint:
    """Newton's method from `point`."""
    damping = 1.0
    for _ in range(MOST_STEPS):
        rates, sizes = balance.rates(point), balance.sizes(point)
        newton = balance.newton(point)
        step = newton @ rates
        size = np.linalg.norm(step / sizes)
        if size <= ACCURACY:
            return balanced(balance, balance.moved(point, step))
        most = LONGEST_NEWTON_STEP / max(np.max(np.abs(step) / sizes), TINY)
        nearer = _nearer(balance, point, newton, step, min(1.0, 2 * damping, most))
        if nearer is None and size <= ROUNDING:
            return balanced(balance, point)
        if nearer is None:
            raise _lost(balance, point, "no step leads nearer")
        point, damping = nearer
    raise _lost(balance, point, f"{MOST_STEPS} steps were taken")


def _nearer(
    balance: Balance, point: OperatingPoint, newton: Floats, step: Floats, damping: float
) -> tuple[OperatingPoint, float] | None:
    """The end of the largest part of `step` that leads nearer, and that part; None if none does."""
    sizes = balance.sizes(point)
    while damping >= SMALLEST_STEP:
        ahead = balance.moved(point, damping * step)
        # the step that is left, as the old derivatives see it, has to be shorter
        left = newton @ balance.rates(ahead)
        if np.linalg.norm(left / sizes) <= (1 - damping / 4) * np.linalg.norm(step / sizes):
            return ahead, damping
        damping /= 2
    return None


def balanced(balance: Balance, point: OperatingPoint) -> OperatingPoint:
    """`point`; RunError unless what is left of the rates is rounding."""
    if not _unrest(balance.rates(point), balance.slopes(point), balance.sizes(point)) <= REST:
        raise _lost(balance, point, "nothing holds it there")
    return point


def _lost(balance: Balance, point: OperatingPoint, why: str) -> RunError:
    """The error for a search that ends without an equilibrium."""
    rates = balance.rates(point)
    k = int(np.argmax(np.where(np.isfinite(rates), np.abs(rates), np.inf)))
    worst = balance.equations[k]
    message = (
        f"{point.program.name}: no equilibrium was found: {why}; "
        f"the rate of {worst.name} is {rates[k]:.6g} {rate_unit(worst.unit)}"
    )
    return RunError(message, REMEDY if point.program.parts else REMEDY + ALONE)
