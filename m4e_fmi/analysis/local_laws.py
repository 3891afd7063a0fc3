"""Points of a program that has parts whose equations hold about a point only.

With the laws of such parts about one point another point is found, with those about that the next:
Newton's method, as far as these parts go. A step that does not lead nearer is shortened: the one
that is left, as the old derivatives see it, has to be shorter (the natural monotonicity test of
`equilibrium`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from m4e_fmi.analysis.balance import Balance
from m4e_fmi.analysis.points import OperatingPoint, local_parts, renewed
from m4e_fmi.errors import RunError

Solve = Callable[[OperatingPoint], OperatingPoint]
"""Finds a point from another one, with the equations that hold about that."""

MOST_POINTS = 40
STILL = 1e-8
"""Distance of points, over the sizes of the unknowns, that is none …"""
ROUNDING = 1e-4
"""… and that is none where no step leads nearer: laws that are measured have noise."""
SHORTEST = 1e-2
"""Part of a step below which the search is given up."""
REMEDY = "start nearer to the equilibrium (--start-value, `at`), or keep it open (--open)"


def followed(balance: Balance, start: OperatingPoint, solve: Solve) -> OperatingPoint:
    """The point that `solve` finds from itself, from `start` on, whose equations hold about it.

    RunError if there is none.
    """
    if not local_parts(start.program):
        return solve(start)
    point, part = start, 1.0
    found, move = start, np.inf
    for _ in range(MOST_POINTS):
        found = solve(point)
        move = balance.distance(point, found)
        if move <= STILL:
            return found
        ahead, failure = _nearer(balance, point, found, part)
        if ahead is None and failure is None and move <= ROUNDING:
            return found
        if ahead is None:
            raise _lost(point, move, failure)
        point, taken = ahead
        part = min(1.0, 2.0 * taken)
    raise _lost(point, move, None)


def _nearer(
    balance: Balance, point: OperatingPoint, found: OperatingPoint, part: float
) -> tuple[tuple[OperatingPoint, float] | None, RunError | None]:
    """The end of the largest part of the way to `found` that leads nearer, and that part.

    None if no part does, and the error of the laws there, if they have failed at the last one.
    """
    newton, sizes = balance.newton(found), balance.sizes(found)
    now = float(np.linalg.norm(newton @ balance.rates(point) / sizes))
    failure = None
    while part >= SHORTEST:
        try:
            ahead, failure = renewed(_between(point, found, part)), None
            left = float(np.linalg.norm(newton @ balance.rates(ahead) / sizes))
            if left <= max(STILL, (1.0 - part / 4.0) * now):
                return (ahead, part), None
        except RunError as error:
            failure = error
        part /= 2.0
    return None, failure


def _between(one: OperatingPoint, other: OperatingPoint, part: float) -> OperatingPoint:
    """The point that is `part` of the way from one to another; quaternions need no length."""
    if part == 1.0:
        return other
    states, inputs, parameters = (
        (1.0 - part) * getattr(one, group) + part * getattr(other, group)
        for group in ("states", "inputs", "parameters")
    )
    return replace(other, states=states, inputs=inputs, parameters=parameters)


def _lost(point: OperatingPoint, move: float, failure: RunError | None) -> RunError:
    """The error of a search that ends at `point`, after a step by `move` or a failure."""
    names = ", ".join(part.name for part, _ in local_parts(point.program))
    message = f"{point.program.name}: no equilibrium with {names} was found"
    if failure is not None:
        return RunError(f"{message}: on the way, {failure.message}", failure.remedy or REMEDY)
    return RunError(f"{message}: the last step was {move:.2g} of the size of a state", REMEDY)
