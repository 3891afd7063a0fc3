"""One program, integrated in process: the same arithmetic as its FMU, without FMI."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, RunError, suggestion
from m4e_fmi.model import Model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Variable
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import DormandPrince, IntegrationError

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Simulation:
    """What a simulation gave: `time` [s], and per variable (states, outputs) its values over time.

    Values are in the unit of their variable, arrays of the length of `time`.
    """

    program: Program
    time: np.ndarray
    values: dict[str, np.ndarray]
    variables: dict[str, Variable]
    evaluations: int
    accepted: int
    rejected: int
    wall_time: float

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]


def simulate(
    system: Program | Model | str | Path,
    *,
    stop_time: float,
    output_interval: float = 0.01,
    start_values: Mapping[str, float] | None = None,
    tolerance: float = 1e-8,
    progress: Progress | None = None,
) -> Simulation:
    """Integrate from t = 0 to `stop_time` [s]; outputs at every `output_interval` and at the end.

    `start_values` sets parameters, inputs and states by name (SI). The local error per step is at
    most tolerance·(1 + |x|). Output times are met exactly. Raises InputError for an unknown name or
    a bad time, RunError if the integration fails, naming time and cause.
    """
    program = system if isinstance(system, Program) else model_program(system)
    program = _started(program, start_values or {})
    times = output_times(stop_time, output_interval)
    form = load_python(program)
    parameters = [v.start for v in program.parameters]
    inputs = [v.start for v in program.inputs]
    x = [v.start for v in program.states]
    began = time.perf_counter()
    t = 0.0
    rows: list[list[float]] = []
    try:
        constants = form.constants(parameters)
        integrator = DormandPrince(
            lambda s, y: form.rates(s, y, inputs, parameters, constants), tolerance=tolerance
        )
        for target in times:
            x = integrator.advance(t, x, target)
            t = target
            rows.append([*x, *form.outputs(t, x, inputs, parameters, constants)])
            if progress:
                progress(t)
    except (IntegrationError, ArithmeticError, ValueError) as error:
        message = f"{program.name}: the integration stopped after t = {t:.6g} s: {error}"
        remedy = "look for a division by zero, a singular configuration or values far out of scale"
        raise RunError(message, remedy) from error
    variables = {v.name: v for v in (*program.states, *program.outputs)}
    columns = np.array(rows).T
    return Simulation(
        program=program,
        time=np.array(times),
        values=dict(zip(variables, columns, strict=True)),
        variables=variables,
        evaluations=integrator.evaluations,
        accepted=integrator.accepted,
        rejected=integrator.rejected,
        wall_time=time.perf_counter() - began,
    )


def output_times(stop_time: float, interval: float) -> list[float]:
    """0, interval, 2·interval, … and `stop_time` itself [s], whatever their ratio."""
    for name, value in (("stop time", stop_time), ("output interval", interval)):
        if not (value > 0 and np.isfinite(value)):
            raise InputError.single(f"the {name} must be positive, got {value}")
    whole = int(np.floor(stop_time / interval * (1 + 1e-12)))
    times = [k * interval for k in range(whole + 1)]
    if stop_time - times[-1] > 1e-9 * interval:
        return [*times, stop_time]
    return [*times[:-1], stop_time]


def _started(program: Program, values: Mapping[str, float]) -> Program:
    try:
        return program.with_start(dict(values))
    except KeyError as error:
        groups = (program.parameters, program.inputs, program.states)
        names = [v.name for group in groups for v in group]
        first = next(name for name in values if name not in names)
        raise InputError.single(str(error.args[0]), suggestion(first, names)) from None
