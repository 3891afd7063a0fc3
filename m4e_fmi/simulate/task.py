"""A program to be integrated, and the result, which every solver checks in the same way."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.program import Program
from m4e_fmi.results.growth import FACTOR, Growth
from m4e_fmi.runtime.engine import Watch
from m4e_fmi.signals import Terminated

HUGE = 1e20
"""No state of a working system is so large, in SI units."""
_FIXED = "take a smaller step_size, or a method that controls its error, as dop853"
_SYSTEM = (
    "look at the signs of stiffness, damping and feedback, or give it damping; what is meant to "
    "grow without end needs an earlier stop_time"
)


def instability(
    program: Program, method: str, times: np.ndarray, states: np.ndarray, failure: str
) -> RunError | None:
    """The error to raise if a state had grown without bound when the `failure` came.

    `states` are the program's first states, shape (n, states), in their units, at `times` (n,)
    [s]. With an empty `failure`, at the end of a simulation, a state must have become huge besides.
    """
    sizes = np.abs(states)
    bad = np.flatnonzero(~np.isfinite(sizes).all(axis=1))
    sizes = sizes[: int(bad[0])] if len(bad) else sizes
    if not sizes.size:
        return None
    last, high = len(sizes) - 1, sizes[-1]
    half = int(np.searchsorted(times[: last + 1], (times[0] + times[last]) / 2))
    low = sizes[: half + 1].max(axis=0)
    least = np.maximum(FACTOR * low, 1.0) if failure else np.full(len(low), HUGE)
    if not (high > least).any():
        return None
    worst = int(np.argmax(high / least))
    state = program.states[worst]
    found = times[half], low[worst], times[last], high[worst]
    grown = Growth(state.name, *map(float, found))
    then = f"; then {failure}" if failure else ""
    message = f"{program.name} is unstable: {grown.text(state.description, state.unit)}{then}"
    return RunError(message, _FIXED if method == "rk4" else _SYSTEM)


Progress = Callable[[float], None] | None
Explain = Callable[[float, Sequence[float]], str]

REMEDY = "look for a division by zero, a singular configuration or values far out of scale"


@dataclass(frozen=True)
class Task:
    """Problem to be integrated, and the method.

    `times` [s] ascend from the start. Steps of rk4 are at most `step_size` [s]. The last
    `quadratures` states have an error norm of their own. `watches` name outputs of the program. At
    `kinks` [s], which ascend, rates change their slopes: no step goes across them. `explain`
    gives the cause of a failure at a time and states. `leave` is called with the rows so far if a
    signal ends the integration.
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


@contextmanager
def leaving(task: Task, solved: Callable[[], Solved]) -> Generator[None]:
    """Leaves what is `solved` if a signal ends the block."""
    try:
        yield
    except (KeyboardInterrupt, Terminated):
        task.leave(solved().finite)
        raise


def failure(task: Task, text: str, why: str, solved: Solved) -> StoppedError:
    """The error that ends an integration, after the rows that are `solved`."""
    text = f"{text}: {why}" if why else text
    rows = solved.table[:, : len(task.program.states) - task.quadratures]
    found = instability(task.program, task.method, solved.times, rows, text)
    return StoppedError(found or RunError(text, REMEDY), solved.finite)


def checked(task: Task, solved: Solved) -> Solved:
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
