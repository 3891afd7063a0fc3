"""One program, integrated in process: the same arithmetic as its FMU, without FMI."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import (
    InputError,
    Named,
    RunError,
    suggestion,
    unknown_names,
)
from m4e_fmi.files.limits import beyond_limits
from m4e_fmi.model import Model, as_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import TIME, Program, Variable, evaluated, kinks
from m4e_fmi.results.series import Series, as_dataset
from m4e_fmi.runtime.engine import Watch
from m4e_fmi.shown import listing, short, span, views
from m4e_fmi.simulate.audit import EnergyAudit, energy_audit, with_works
from m4e_fmi.simulate.loops import check_start, explained, singular_row, with_shares
from m4e_fmi.simulate.solvers import solve_compiled
from m4e_fmi.simulate.start import started
from m4e_fmi.simulate.task import Solved, StoppedError, Task

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from m4e_fmi.results.results_file import Animation

Progress = Callable[[float], None]
FIXED = "rk4"
METHODS = ("dop853", "rk45", "rodas", FIXED)


@short
@dataclass(frozen=True)
class Event:
    """The variable `name` changed sign at `time` [s], the program's states being `states`."""

    name: str
    time: float
    states: np.ndarray
    terminal: bool


@dataclass(frozen=True)
class Simulation:
    """Result of a simulation: `time` [s], shape (n,), and states and outputs over time.

    `values` by name have shape (n,), and the unit of their variable. `load.<name>.work` and
    `inputs.work` [J] are the integrals of the powers. `events` are in the order of time.
    `start_values` are those that were given; `tolerance` is None of a method that has none, `model`
    of a program.
    """

    program: Program
    method: str
    time: Series
    values: dict[str, Series]
    variables: dict[str, Variable]
    evaluations: int
    wall_time: float
    events: tuple[Event, ...] = ()
    start_values: Mapping[str, float | str] = field(default_factory=dict)
    tolerance: float | None = None
    model: Model | None = field(default=None, repr=False)

    def __getitem__(self, name: str) -> Series:
        """A variable over time, shape (n,), in its unit; UnknownNameError if there is none."""
        return self.values[name]

    def to_xarray(self) -> xarray.Dataset:
        """All states and outputs as a dataset over `time`, with their units."""
        return as_dataset(self.time, self.values, {"title": self.program.name})

    def plot(self, *names: str) -> Figure:
        """A figure of the variables of these names; without names, of the main ones.

        InputError for a name that is not there.
        """
        return views().figure(self, names)

    def animate(self) -> Animation:
        """The animation of a model's motion; it is shown by a notebook, and written by its `save`.

        InputError of a program, which has no bodies.
        """
        return views().animation(self)

    def __repr__(self) -> str:
        work = [name for name in self.values if name.endswith(".work")]
        return listing(
            f"Simulation of {self.program.name!r}: {span(self.time)}, {self.method}, "
            f"{self.evaluations} evaluations in {self.wall_time:.2g} s",
            states=self.program.states,
            outputs=self.program.outputs,
            works=work,
            events=self.events,
        )

    @cached_property
    def energy(self) -> EnergyAudit | None:
        """The energy balance; None of a program that has no total energy."""
        return energy_audit(self.values)


class SimulationError(RunError):
    """A simulation has failed; `simulation` has its rows up to there, at least one."""

    def __init__(self, error: RunError, simulation: Simulation) -> None:
        super().__init__(error.message, error.remedy)
        self.simulation = simulation

    def __reduce__(self) -> tuple[type[RunError], tuple[str, str]]:
        """In another process it is a RunError: programs of models stay where they are."""
        return RunError, (self.message, self.remedy)


def simulate(
    system: Program | Model | str | Path,
    *,
    stop_time: float,
    output_interval: float = 0.01,
    start_values: Mapping[str, float | str] | None = None,
    tolerance: float = 1e-8,
    method: str = METHODS[0],
    step_size: float | None = None,
    events: Sequence[Watch | str] = (),
    needed: Sequence[str] = (),
    progress: Progress | None = None,
    interrupted: Callable[[Simulation], None] | None = None,
) -> Simulation:
    """Integrate from t = 0 to `stop_time` [s]; outputs at every `output_interval` and at the end.

    `start_values` sets parameters, inputs and states by name: numbers in SI, or texts with a unit,
    as ``"5 mm"``; inputs of a model that are not set are zero, and left out of its program.
    `tolerance` is relative and absolute, per step. `method` is dop853, rk45, rodas (stiff) or rk4
    (fixed steps). Output times are met exactly, and steps end at kinks and jumps
    that depend on time alone, such as those of tables.

    rk4 has no error control and no tolerance: from one output time to the next it takes the fewest
    equal steps that are not longer than `step_size` [s]; one step by default.

    `events` are outputs or states whose changes of sign are found, such as `load.<stop>.gap`, by
    name for both directions; a terminal `Watch` ends the simulation, with a last row at its time.
    `interrupted` is called with the rows so far, at least one, before KeyboardInterrupt and
    Terminated pass. `needed` names variables that the caller will look
    at. Raises InputError, before the simulation, for unknown names and bad times, RunError if the
    integration fails, naming time and cause: a SimulationError, which has the rows up to there, if
    there are any.
    """
    _check_method(method, step_size)
    given = start_values or {}
    source = system if isinstance(system, Program) else as_model(system)
    model = None if isinstance(source, Program) else source
    program = model_program(source, inputs=tuple(given)) if isinstance(source, Model) else source
    program = started(program, given, model)
    began = time.perf_counter()
    # the integrals of powers are its last states, the watched and shares of loops its last outputs
    audited, works = with_works(program)
    check_start(program)
    wanted = [Watch(event) if isinstance(event, str) else event for event in events]
    watched, watches = _watched(audited, wanted)
    integrated, shares = with_shares(watched)
    variables = {v.name: v for v in (*audited.states, *audited.outputs)}
    if unknown := unknown_names(needed, variables, "there is no variable", "variables"):
        raise InputError(unknown)
    times = output_times(stop_time, output_interval, step_size)

    def simulation(solved: Solved) -> Simulation:
        """The simulation with these rows, until now."""
        # the last columns, which are there to be watched only, have no variable
        columns = zip(variables.values(), solved.table.T, strict=False)
        values = {v.name: Series(v.name, v.unit, v.description, column) for v, column in columns}
        count = len(program.states)
        found = [(wanted[k], t, states[:count]) for t, k, states in solved.events]
        return Simulation(
            program=program,
            method=method,
            time=Series("time", "s", "simulated time", solved.times),
            values=Named(f"{program.name} has no state, output or work", values),
            variables=dict(variables),
            evaluations=solved.evaluations,
            wall_time=time.perf_counter() - began,
            events=tuple(Event(one.name, t, states, one.terminal) for one, t, states in found),
            start_values=given,
            tolerance=None if method == FIXED else tolerance,
            model=model,
        )

    def leave(solved: Solved) -> None:
        if interrupted and len(solved.times):
            interrupted(simulation(solved))

    task = Task(
        program=integrated,
        times=times,
        method=method,
        tolerance=tolerance,
        step_size=step_size or np.inf,
        quadratures=works,
        watches=watches,
        kinks=kinks(program, times[-1].item()),
        progress=progress,
        explain=functools.partial(_explained, source, program),
        leave=leave,
    )
    try:
        return simulation(_solved(task, program, shares))
    except StoppedError as error:
        if not len(error.solved.times):
            raise
        raise SimulationError(error, simulation(error.solved)) from error


def _solved(task: Task, program: Program, shares: int) -> Solved:
    """The rows of a task, whose last outputs are the `shares` of the program's algebraic loops.

    StoppedError if it fails, or a loop becomes singular.
    """
    solved = solve_compiled(task)
    if shares:
        table = solved.table[:, -shares:]
        found = singular_row(program, solved.times, table, fixed=task.method == FIXED)
        if found:
            raise StoppedError(found[1], solved.first(found[0]))
    return solved


def _check_method(method: str, step_size: float | None) -> None:
    """InputError unless there is such a method, and it takes this step size."""
    if method not in METHODS:
        remedy = suggestion(method, METHODS, "methods")
        raise InputError.single(f"there is no method {method!r}", remedy)
    if step_size is not None and not (step_size > 0 and np.isfinite(step_size)):
        raise InputError.single(f"the step size must be positive, got {step_size}")
    if step_size is not None and method != FIXED:
        message = f"{method} chooses its steps: it takes no step size"
        raise InputError.single(message, f"give a tolerance, or the method {FIXED}")


def _watched(program: Program, events: Sequence[Watch]) -> tuple[Program, tuple[Watch, ...]]:
    """The program with outputs that are the states to be watched, and the watches of outputs."""
    outputs = {v.name for v in program.outputs}
    states = {v.name: v for v in program.states}
    more: dict[str, Variable] = {}
    for name in (watch.name for watch in events):
        if name not in outputs and name not in states:
            names = [*outputs, *states]
            raise InputError.single(
                f"{program.name} has no output or state {name!r}", suggestion(name, names)
            )
        if name not in outputs:
            more[name] = replace(states[name], name=f"watched.{name}")
    nodes = [program.tape.symbol(name).index for name in more]
    watched = replace(
        program,
        outputs=(*program.outputs, *more.values()),
        results=(*program.results, *nodes),
    )
    new = {name: variable.name for name, variable in more.items()}
    return watched, tuple(replace(w, name=new.get(w.name, w.name)) for w in events)


def _explained(system: Program | Model, program: Program, t: float, x: Sequence[float]) -> str:
    """Defect of a model at time t [s] and states x, works after them; "" if there is none.

    Of a program of several parts, that of the first model which has one, with the part's name, or
    an algebraic loop between them.
    """
    from m4e_fmi.multibody.diagnosis import diagnosis

    values = {v.name: v.start for v in (*program.parameters, *program.inputs)}
    values |= {v.name: value for v, value in zip(program.states, x, strict=False)}
    if not isinstance(system, Program):
        return diagnosis(system, values, t)
    for part in program.parts:
        if isinstance(part.origin, Model):
            found = evaluated(program.tape, list(part.nodes.values()), {**values, TIME: t})
            own = {name: found[node] for name, node in part.nodes.items()}
            if why := diagnosis(part.origin, own, t):
                return f"{part.name}: {why}"
    return explained(program, {**values, TIME: t})


def output_times(stop_time: float, interval: float, step_size: float | None = None) -> np.ndarray:
    """0, interval, 2·interval, … and `stop_time` itself (n,) [s], whatever their ratio.

    InputError unless `stop_time` and `interval` are above 0, and for more rows or steps than the
    limits; the solver checks `step_size`.
    """
    for name, value in (("stop time", stop_time), ("output interval", interval)):
        if np.ndim(value) or not isinstance(np.asarray(value).item(), int | float):
            message = f"the {name} must be a number, got {value!r}"
            raise InputError.single(message, "give it in seconds, without a unit")
        if not (value > 0 and np.isfinite(value)):
            message = f"the {name} must be positive, got {value}"
            raise InputError.single(message, "give a number of seconds above 0")
    for _, *told in beyond_limits(stop_time, output_interval=interval, step_size=step_size):
        raise InputError.single(*told)
    times = np.arange(int(stop_time / interval) + 1) * interval
    return np.append(times[times < stop_time - 1e-9 * interval], stop_time)
