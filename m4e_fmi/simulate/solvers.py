"""Integration of a program by the C library: a `Task` in, what is `Solved` out.

StoppedError names the time and cause of a failure, and has the rows up to there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from m4e_fmi.program import rate_entries
from m4e_fmi.runtime.engine import EVENT, Control, Engine, Integrator, failure_text
from m4e_fmi.simulate.task import Solved, Task, checked, failure, leaving

PARTS = 100  # into which a run is cut to tell its progress


def solve_compiled(task: Task) -> Solved:
    """The rows of a task, cut into parts only where progress is asked for, which changes no bit.

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

    with leaving(task, solved):
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
                raise failure(task, failure_text(program, report), why, solved())
            if task.progress:
                task.progress(part[-1])
    return checked(task, solved())


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
