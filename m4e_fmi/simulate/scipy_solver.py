"""Integration by SciPy's `solve_ivp`, on the program's Python form."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.simulate.task import Function, Solved, Task, checked, failure, functions, solved_rows

if TYPE_CHECKING:
    from scipy.integrate import OdeSolver
    from scipy.optimize import OptimizeResult

SCIPY_METHODS = ("RK45", "RK23", "DOP853", "Radau", "BDF", "LSODA")


def solve_scipy(task: Task) -> Solved:
    """By one of SciPy's `solve_ivp` methods on the program's Python form.

    The tolerance is smaller by so much that quadratures, which count in SciPy's mean, allow the
    others no larger error.
    """
    from scipy.integrate import solve_ivp

    program, times = task.program, task.times
    rates, outputs = functions(program)
    governing = len(program.states) - task.quadratures
    tolerance = task.tolerance * math.sqrt(governing / len(program.states))

    last = (float(times[0]), task.start)
    accepted = float(times[0])

    def told(t: float, x: np.ndarray) -> list[float]:
        nonlocal last
        last = (t, x.tolist())
        if task.progress:
            task.progress(t)
        return rates(*last)

    def passed(t: float) -> None:
        nonlocal accepted
        accepted = t

    def solution_until(end: float) -> OptimizeResult:
        return solve_ivp(
            told,
            (times[0], end),
            task.start,
            method=_noting(task.method, passed),  # pyright: ignore[reportArgumentType]  or a class
            t_eval=times[times <= end],
            rtol=tolerance,
            atol=tolerance,
            events=_event_functions(task) or None,
        )

    at, rows = [], []
    try:
        solution = solution_until(times[-1])
        at, states = solution.t.tolist(), solution.y.T.tolist()
        events = _scipy_events(solution)
        if solution.status == 1:  # a terminal event
            at, states = [*at, events[-1][0]], [*states, events[-1][2].tolist()]
        for t, x in zip(at, states, strict=True):
            rows.append([*x, *outputs(t, x)])
        if not solution.success:
            raise ArithmeticError(solution.message)
    except (ArithmeticError, ValueError) as error:
        message = f"{program.name}: SciPy's {task.method} failed: {error}"
        why = task.explain(*last)
        with suppress(ArithmeticError, ValueError):
            if not at:  # SciPy keeps no row if the rates cannot be computed: once more, up to there
                solution = solution_until(accepted)
                at = solution.t.tolist()
                rows += [[*x, *outputs(t, x)] for t, x in zip(at, solution.y.T, strict=True)]
        raise failure(task, message, why, solved_rows(task, at[: len(rows)], rows, 0)) from error
    return checked(task, solved_rows(task, at, rows, solution.nfev, events))


def _noting(method: str, note: Callable[[float], None]) -> type[OdeSolver]:
    """SciPy's method of this name, which notes the time [s] at the end of each step."""
    import scipy.integrate

    kind: type[OdeSolver] = getattr(scipy.integrate, method)

    def step(solver: OdeSolver) -> str | None:
        message = kind.step(solver)
        note(float(solver.t))
        return message

    return type(method, (kind,), {"step": step})


def _scipy_events(solution: OptimizeResult) -> list[tuple[float, int, np.ndarray]]:
    """Events of the watches, in the order of time."""
    found = zip(solution.t_events or (), solution.y_events or (), strict=True)
    events = [
        (float(t), k, x)
        for k, (at, states) in enumerate(found)
        for t, x in zip(at, states, strict=True)
    ]
    return sorted(events, key=lambda event: event[0])


def _event_functions(task: Task) -> list[Callable[[float, Sequence[float]], float]]:
    """SciPy's event functions of the watches."""
    program = task.program
    places = {v.name: k for k, v in enumerate(program.outputs)}
    found = []
    for watch in task.watches:
        k = places[watch.name]
        alone = replace(program, outputs=(program.outputs[k],), results=(program.results[k],))
        _, outputs = functions(alone)

        def event(t: float, x: Sequence[float], outputs: Function = outputs) -> float:
            return outputs(t, list(x))[0]

        event.__dict__.update(terminal=watch.terminal, direction=watch.direction)
        found.append(event)
    return found
