"""A run beside the solution of the same equations as one program, without steps between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.cosim.run.outcome import Outcome
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.program import Program
from m4e_fmi.shown import short
from m4e_fmi.simulate import simulate

TOLERANCE = 1e-11
"""Of the solution, relative and absolute, per step."""
SAME_TIME = 1e-9
"""Difference [s] up to which a row of the results and one of the solution are of one time."""


@dataclass(frozen=True)
class ActualError:
    """The largest difference of a connection's source from the solution, `actual`.

    `stated` is the estimate of the run. Both are shares [1] of the same range.
    """

    connection: str
    source: Port
    actual: float
    stated: float


@short
@dataclass(frozen=True)
class Reference:
    """Differences of a run from the solution of its equations as one program.

    `errors` has those of the connections, the largest first, at `compared` of the `rows` of the
    results; `evaluations` and `wall_time` [s] are of the solution.
    """

    errors: tuple[ActualError, ...]
    compared: int
    rows: int
    evaluations: int
    wall_time: float

    def __str__(self) -> str:
        if not self.errors:
            return "no connection to compare with the solution as one program"
        worst = self.errors[0]
        some = f" at {self.compared} of {self.rows} rows" if self.compared < self.rows else ""
        return (
            f"against the solution as one program{some}: largest error of the stated outputs "
            f"{worst.actual:.1e} of range, at {worst.source} ({worst.connection}), "
            f"stated {worst.stated:.1e}"
        )


def reference(outcome: Outcome, program: Program) -> Reference:
    """A run beside the solution of `program`, that of the same system.

    The outputs with the largest stated error of each connection are compared, at the rows of the
    results that are at an output time.
    """
    report = outcome.certificate
    assert isinstance(report, CouplingErrorReport)
    results, times = outcome.results(), outcome.prepared.system.simulation
    solution = simulate(
        program,
        stop_time=times.stop_time,
        output_interval=times.output_interval or times.step_size,
        tolerance=TOLERANCE,
    )
    places = np.searchsorted(solution.time, results.time - SAME_TIME)
    places = np.minimum(places, len(solution.time) - 1)
    # adaptive steps, events and components' own steps make rows between the output times
    rows = np.abs(np.asarray(solution.time)[places] - results.time) <= SAME_TIME
    same = places[rows]
    errors = []
    for error in report.errors:
        name = str(error.source)
        if name in results.series and name in solution.values and error.span > 0.0:
            off = np.abs(np.asarray(results[name])[rows] - np.asarray(solution[name])[same]).max()
            actual = float(off) / error.span
            errors.append(ActualError(error.connection, error.source, actual, error.error))
    errors.sort(key=lambda found: -found.actual)
    return Reference(tuple(errors), len(same), len(rows), solution.evaluations, solution.wall_time)
