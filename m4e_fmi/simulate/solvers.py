"""Ways to integrate a program: the C library, plain Python, SciPy.

Each takes the program, the output times [s] (ascending, from the start), the method's name, the
tolerance, a progress callable and one that says what is wrong at a time and state, and returns one
row of states and outputs per time, and how often the rates were evaluated. RunError names the time
and the cause of a failure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.program import Program, rate_entries
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import DormandPrince, IntegrationError

Progress = Callable[[float], None] | None
Explain = Callable[[float, Sequence[float]], str]
Solution = tuple[np.ndarray, int]

SCIPY_METHODS = ("RK45", "RK23", "DOP853", "Radau", "BDF", "LSODA")
PARTS = 100  # into which a run is cut to tell its progress
REMEDY = "look for a division by zero, a singular configuration or values far out of scale"


def solve_compiled(
    program: Program,
    times: np.ndarray,
    method: str,
    tolerance: float,
    progress: Progress,
    explain: Explain,
) -> Solution:
    """By the C library; cut into parts only where progress is asked for, which changes no bit.

    The stiff method has the exact Jacobian.
    """
    from m4e_fmi.runtime.engine import Control, Engine, failure_text
    from m4e_fmi.runtime.integrator import Integrator

    engine = Engine(program, jacobian=rate_entries(program) if method == "rodas" else ())
    integrator = Integrator(engine, Control(method, rtol=tolerance, atol=tolerance))
    integrator.start(times[0], [v.start for v in program.states])
    last = [v.start for v in program.states]
    rows = []
    for part in np.array_split(times, PARTS if progress else 1):
        if not part.size:
            continue
        states = integrator.advance(part, bound=times[-1])
        last = states[-1] if len(states) else last
        if len(states) < part.size:
            report = integrator.report
            raise _failure(failure_text(program, report), explain(report.time, list(last)))
        rows.append(np.hstack([states, engine.outputs_over(part, states)]))
        if progress:
            progress(part[-1])
    table = np.concatenate(rows)
    _check_finite(program, times, table)
    return table, integrator.report.evaluations


def _failure(text: str, why: str) -> RunError:
    return RunError(f"{text}: {why}" if why else text, REMEDY)


def solve_python(
    program: Program,
    times: np.ndarray,
    method: str,
    tolerance: float,
    progress: Progress,
    explain: Explain,
) -> Solution:
    """By Dormand and Prince's pair on the program's Python form: what its Python FMU does."""
    del method
    rates, outputs = _functions(program)
    integrator = DormandPrince(rates, tolerance=tolerance)
    x = [v.start for v in program.states]
    t, rows = times[0], []
    try:
        for target in times.tolist():
            x = integrator.advance(t, x, target)
            t = target
            rows.append([*x, *outputs(t, x)])
            if progress:
                progress(t)
    except (IntegrationError, ArithmeticError, ValueError) as error:
        message = f"{program.name}: the integration stopped after t = {t:.6g} s: {error}"
        raise _failure(message, explain(t, x)) from error
    return np.array(rows), integrator.evaluations


def solve_scipy(
    program: Program,
    times: np.ndarray,
    method: str,
    tolerance: float,
    progress: Progress,
    explain: Explain,
) -> Solution:
    """By one of SciPy's `solve_ivp` methods on the program's Python form."""
    from scipy.integrate import solve_ivp

    rates, outputs = _functions(program)

    def told(t: float, x: np.ndarray) -> list[float]:
        if progress:
            progress(t)
        return rates(t, x.tolist())

    try:
        solution = solve_ivp(
            told,
            (times[0], times[-1]),
            [v.start for v in program.states],
            method=method,
            t_eval=times,
            rtol=tolerance,
            atol=tolerance,
        )
        if not solution.success:
            raise ArithmeticError(solution.message)
        states = solution.y.T.tolist()
        rows = [[*x, *outputs(t, x)] for t, x in zip(times.tolist(), states, strict=True)]
    except (ArithmeticError, ValueError) as error:
        message = f"{program.name}: SciPy's {method} failed: {error}"
        start = [v.start for v in program.states]
        raise _failure(message, explain(times[0], start)) from error
    return np.array(rows), solution.nfev


def _functions(program: Program) -> tuple[Callable, Callable]:
    """rates(t, x) and outputs(t, x) at the program's start values of parameters and inputs."""
    form = load_python(program)
    parameters = [v.start for v in program.parameters]
    inputs = [v.start for v in program.inputs]
    try:
        constants = form.constants(parameters)
    except (ArithmeticError, ValueError) as error:
        message = f"{program.name}: what depends on parameters only cannot be computed: {error}"
        raise RunError(message, "check the parameters") from error
    return (
        lambda t, x: form.rates(t, x, inputs, parameters, constants),
        lambda t, x: form.outputs(t, x, inputs, parameters, constants),
    )


def _check_finite(program: Program, times: np.ndarray, table: np.ndarray) -> None:
    if np.isfinite(table).all():
        return
    row, column = np.argwhere(~np.isfinite(table))[0]
    name = [v.name for v in (*program.states, *program.outputs)][column]
    value = table[row, column]
    raise RunError(f"{program.name}: {name} is {value} at t = {times[row]:.9g} s", REMEDY)
