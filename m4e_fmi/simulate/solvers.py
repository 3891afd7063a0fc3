"""Ways to integrate a program: the C library, plain Python, SciPy.

Each takes a `Task` and returns what is `Solved`. StoppedError names the time and cause of a
failure, and has the rows up to there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.program import Program, rate_entries
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import DormandPrince, IntegrationError
from m4e_fmi.runtime.engine import EVENT, Control, Engine, Watch, failure_text
from m4e_fmi.runtime.integrator import Integrator
from m4e_fmi.signals import Terminated
from m4e_fmi.simulate.instability import instability

if TYPE_CHECKING:
    from scipy.integrate import OdeSolver
    from scipy.optimize import OptimizeResult

Progress = Callable[[float], None] | None
Explain = Callable[[float, Sequence[float]], str]
Function = Callable[[float, Sequence[float]], list[float]]

SCIPY_METHODS = ("RK45", "RK23", "DOP853", "Radau", "BDF", "LSODA")
PARTS = 100  # into which a run is cut to tell its progress
REMEDY = "look for a division by zero, a singular configuration or values far out of scale"


@dataclass(frozen=True)
class Task:
    """Problem to be integrated, and the method.

    `times` [s] ascend from the start. Steps of rk4 are at most `step_size` [s]. The last
    `quadratures` states have an error norm of their own. `watches` name outputs of the program. At
    `kinks` [s], which ascend, rates change their slopes: methods other than SciPy's make no step
    across them. `explain` gives the cause of a failure at a time and states. `leave` is
    called with the rows so far if a signal ends the integration, but by SciPy's methods.
    """

    program: Program
    times: np.ndarray
    method: str
    tolerance: float
    step_size: float
    quadratures: int
    watches: tuple[Watch, ...]
    kinks: Sequence[float]
    progress: Progress
    explain: Explain
    leave: Callable[[Solved], None]

    @property
    def start(self) -> list[float]:
        """Start values of the states, in their units."""
        return [v.start for v in self.program.states]


@dataclass(frozen=True)
class Solved:
    """Result of an integration: `table` has a row of states and outputs per entry of `times` [s].

    `events` are (time [s], position in the watches, states), in the order of time; after a terminal
    one comes nothing but a row at its time. `evaluations` counts those of the rates.
    """

    times: np.ndarray
    table: np.ndarray
    evaluations: int
    events: list[tuple[float, int, np.ndarray]]

    @property
    def finite(self) -> Solved:
        """The rows before the first in which a number is not finite, and the events up to there."""
        bad = np.flatnonzero(~np.isfinite(self.table).all(axis=1))
        return self.first(int(bad[0])) if len(bad) else self

    def first(self, count: int) -> Solved:
        """The first `count` rows, and the events up to there."""
        times = self.times[:count]
        events = [event for event in self.events if count and event[0] <= times[-1]]
        return replace(self, times=times, table=self.table[:count], events=events)


class StoppedError(RunError):
    """An integration has failed; `solved` has the rows up to there, which are finite."""

    def __init__(self, error: RunError, solved: Solved) -> None:
        super().__init__(error.message, error.remedy)
        self.solved = solved


def solve_compiled(task: Task) -> Solved:
    """By the C library; cut into parts only where progress is asked for, which changes no bit.

    The stiff method has the exact Jacobian.
    """
    program, times = task.program, task.times
    stiff = task.method == "rodas"
    jacobian_ = rate_entries(program) if stiff else ()
    engine = Engine(program, jacobian=jacobian_, watches=task.watches)
    limits = Control(
        task.method,
        rtol=task.tolerance,
        atol=task.tolerance,
        max_step=task.step_size,
        quadratures=task.quadratures,
    )
    integrator = Integrator(engine, limits)
    integrator.start(times[0], task.start)
    record, last = integrator.record, task.start
    done = [(times[:0], np.empty((0, len(task.start))))]

    def solved() -> Solved:
        at, x = (np.concatenate(parts) for parts in zip(*done, strict=True))
        count = integrator.report.events
        table = np.hstack([x, engine.outputs_over(at, x)])
        found = zip(record.time[:count], record.index[:count], record.state[:count], strict=True)
        events = [(float(t), int(k), state) for t, k, state in found]
        return Solved(at, table, integrator.report.evaluations, events)

    with _left(task, solved):
        for part, bound, wanted in _parts(task):
            rows = integrator.advance(part, bound=bound)
            report = integrator.report
            if wanted:
                done.append((part[: len(rows)], rows))
            last = rows[-1] if len(rows) else last
            if report.status == EVENT:
                at_end = slice(report.events - 1, report.events)
                done.append((record.time[at_end], record.state[at_end]))
                break
            if len(rows) < part.size:
                why = task.explain(report.time, list(last))
                raise _failure(task, failure_text(program, report), why, solved())
            if task.progress:
                task.progress(part[-1])
    return _checked(task, solved())


@contextmanager
def _left(task: Task, solved: Callable[[], Solved]) -> Generator[None]:
    """Leaves what is `solved` if a signal ends the block."""
    try:
        yield
    except (KeyboardInterrupt, Terminated):
        task.leave(solved().finite)
        raise


def _parts(task: Task) -> Iterator[tuple[np.ndarray, float, bool]]:
    """Times to go to, the time beyond which no step may go, and if they are output times."""
    times, first = task.times, 0
    for end in [*task.kinks, times[-1]]:
        last = int(np.searchsorted(times, end, side="right"))
        inner = times[first:last]
        count = math.ceil(PARTS * len(inner) / len(times)) if task.progress else 1
        yield from ((part, end, True) for part in np.array_split(inner, max(1, count)) if part.size)
        if not inner.size or inner[-1] < end:
            yield np.array([end]), end, False
        first = last


def _failure(task: Task, text: str, why: str, solved: Solved) -> StoppedError:
    """The error that ends an integration, after the rows that are `solved`."""
    text = f"{text}: {why}" if why else text
    rows = solved.table[:, : len(task.program.states) - task.quadratures]
    found = instability(task.program, task.method, solved.times, rows, text)
    return StoppedError(found or RunError(text, REMEDY), solved.finite)


def solve_python(task: Task) -> Solved:
    """By Dormand and Prince's pair on the program's Python form: what its Python FMU does.

    It has no dense output, hence no events.
    """
    if task.watches:
        remedy = "take another, such as scipy.RK45; the runtime's methods need a C compiler once"
        raise InputError.single("the method python finds no events", remedy)
    rates, outputs = _functions(task.program)
    integrator = DormandPrince(rates, tolerance=task.tolerance, quadratures=task.quadratures)
    x, t, rows, wanted = task.start, task.times[0], [], set(task.times.tolist())

    def solved() -> Solved:
        return _solved(task, task.times[: len(rows)], rows, integrator.evaluations)

    try:
        with _left(task, solved):
            for target in sorted({*wanted, *task.kinks}):
                x = integrator.advance(t, x, target)
                t = target
                if t not in wanted:
                    continue
                rows.append([*x, *outputs(t, x)])
                if task.progress:
                    task.progress(t)
    except (IntegrationError, ArithmeticError, ValueError) as error:
        message = f"{task.program.name}: the integration stopped after t = {t:.6g} s: {error}"
        raise _failure(task, message, task.explain(t, x), solved()) from error
    return _checked(task, solved())


def _solved(
    task: Task,
    times: Sequence[float] | np.ndarray,
    rows: list[list[float]],
    evaluations: int,
    events: Sequence[tuple[float, int, np.ndarray]] = (),
) -> Solved:
    """The result of an integration whose `rows` at `times` [s] are states and outputs."""
    width = len(task.program.states) + len(task.program.outputs)
    return Solved(np.array(times), np.array(rows).reshape(-1, width), evaluations, list(events))


def solve_scipy(task: Task) -> Solved:
    """By one of SciPy's `solve_ivp` methods on the program's Python form.

    The tolerance is smaller by so much that quadratures, which count in SciPy's mean, allow the
    others no larger error.
    """
    from scipy.integrate import solve_ivp

    program, times = task.program, task.times
    rates, outputs = _functions(program)
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
        raise _failure(task, message, why, _solved(task, at[: len(rows)], rows, 0)) from error
    return _checked(task, _solved(task, at, rows, solution.nfev, events))


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
    functions = []
    for watch in task.watches:
        k = places[watch.name]
        alone = replace(program, outputs=(program.outputs[k],), results=(program.results[k],))
        _, outputs = _functions(alone)

        def event(t: float, x: Sequence[float], outputs: Function = outputs) -> float:
            return outputs(t, list(x))[0]

        event.__dict__.update(terminal=watch.terminal, direction=watch.direction)
        functions.append(event)
    return functions


def _functions(program: Program) -> tuple[Function, Function]:
    """rates(t, x) and outputs(t, x) at the program's start values of parameters and inputs."""
    form = load_python(program)
    parameters = [v.start for v in program.parameters]
    inputs = [v.start for v in program.inputs]
    try:
        constants = form.constants(parameters)
    except (ArithmeticError, ValueError) as error:
        message = f"{program.name}: values of parameters only cannot be computed: {error}"
        raise RunError(message, "check the parameters") from error
    return (
        lambda t, x: form.rates(t, x, inputs, parameters, constants),
        lambda t, x: form.outputs(t, x, inputs, parameters, constants),
    )


def _checked(task: Task, solved: Solved) -> Solved:
    """`solved`; StoppedError unless all is finite, and no state has grown without bound."""
    program, table, times = task.program, solved.table, solved.times
    bad, rows = np.argwhere(~np.isfinite(table)), len(table)
    count = len(program.states) - task.quadratures
    failure = ""
    if bad.size:
        row, column = bad[0]
        name = [v.name for v in (*program.states, *program.outputs)][column]
        failure = f"{program.name}: {name} is {table[row, column]} at t = {times[row]:.9g} s"
        if why := task.explain(float(times[row]), table[row, :count].tolist()):
            failure += f": {why}"
        rows = row + 1
    found = instability(program, task.method, times[:rows], table[:rows, :count], failure)
    if found or failure:
        raise StoppedError(found or RunError(failure, REMEDY), solved.finite)
    return solved
