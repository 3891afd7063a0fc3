"""Schedules: operations performed in their order; a `StepLoop` repeats one, step by step."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Collection, Sequence
from typing import NoReturn

import numpy as np

from m4e_fmi.cosim.exchange import operations as op
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.native_executor import (
    NOT_A_NUMBER,
    NativeExecutor,
    State,
    ends,
    run_loop,
)
from m4e_fmi.cosim.exchange.operations import Operation
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.fmu.importer.calls import DISCARD

NEVER = 2**63
"""Steps from row to row where there are no rows."""
FAR = 2**62
"""A time [ns] that no run reaches."""


class Schedule:
    """Operations that are performed in their order."""

    def __init__(self, operations: Sequence[Operation]) -> None:
        self.operations = tuple(operations)
        self.executor = NativeExecutor(self.operations)
        stepping = [o for o in self.operations if isinstance(o, op.DoStep)]
        self._stepping = tuple({id(o.instance): o.instance for o in stepping if not o.due}.values())
        self._sampled = tuple((o.instance, o.due) for o in stepping if o.due)
        self._returning = tuple(o.instance for o in self.operations if isinstance(o, op.Restore))

    def run(self, time: float, size: float = 0.0, *, row: int = 0) -> None:
        """Perform all once: a step of `size` [s] from `time` [s]; blocks are filled at `row`.

        RunError with component, variable, time and remedy where an FMU fails or gives no number.
        """
        for instance in self._returning:
            instance.events.ended = math.inf  # in a step that is made again
        status, index = self.executor.perform(time, size, row)
        if status:
            self.go_on(status, index, time, size, row)
        self.arrive(time + size)

    def go_on(self, status: int, index: int, time: float, size: float, row: int) -> None:
        """Perform the rest if the operation failed by which an FMU asks for the end of the run.

        So it is if the FMU has come to the end of the step; in that, nothing is set any more.
        """
        step, end = self.operations[index], time + size
        if status != DISCARD or not isinstance(step, op.DoStep) or not step.instance.ends_at(end):
            self.fail(status, index, time, size, row)
        rest = list(self.operations[index + 1 :])
        again = (isinstance(o, op.Restore) and o.instance is step.instance for o in rest)
        quiet = next((k for k, is_again in enumerate(again) if is_again), len(rest))
        quietly = Schedule(rest[:quiet]).without_sets([step.instance])
        Schedule([*quietly.operations, *rest[quiet:]]).run(time, size, row=row)

    def without_sets(self, instances: Collection[Instance]) -> Schedule:
        """The same, but nothing is set in these."""
        sets = op.Set, op.SetDerivatives, op.SetTyped
        return Schedule(
            [o for o in self.operations if not isinstance(o, sets) or o.instance not in instances]
        )

    def arrive(self, time: float) -> None:
        """All components that step have come to `time` [s]."""
        for instance in self._stepping:
            instance.time = time
        for instance, due in self._sampled:
            if due.at(time):
                instance.time = time

    def fail(self, status: int, index: int, time: float, size: float, row: int) -> NoReturn:
        """Raise what the status of an operation means; those before it are done."""
        for operation in self.operations[:index]:
            if isinstance(operation, op.DoStep):
                if not operation.due or operation.due.at(time + size):
                    operation.instance.time = sum(operation.span(time, size))
            elif isinstance(operation, op.Restore):
                operation.instance.time = time
        match self.operations[index]:
            case op.Get(instance, names, into) | op.Choose(instance, names, into) if (
                status == NOT_A_NUMBER
            ):
                instance.not_finite(names, into if into.ndim == 1 else into[row])
            case op.DoStep(instance) as step:
                instance.time, length = step.span(time, size)
                instance.fail(status, step.function, length)
            case op.GetTyped(instance, access, cells) | op.SetTyped(instance, access, cells):
                instance.fail_typed(status, access, cells)
            case op.Combine() | op.Gather() | op.Choose() | op.Monitor():
                raise AssertionError("these do not fail")
            case call:
                call.instance.fail(status, call.function)


class StepLoop:
    """A schedule for each macro step, and one for each step that is a row of the results.

    `state` has the present time `now`, the step `size` [ns], the next places of blocks that each
    step (`noted`) and each row (`written`) fill, and the steps `since` the last of the rows, which
    are `every` so many steps. All steps that end at `rows_from` [ns] or later may end at a row. One
    of the instances `telling` may ask for the end; one of `stops` (float64) that becomes finite
    ends it, too.
    """

    def __init__(
        self,
        step: Schedule,
        row: Schedule | None,
        *,
        every: int,
        telling: Sequence[Instance],
        stops: np.ndarray,
    ) -> None:
        self.step = step
        self.row = row or Schedule(())
        self.state = State(every=every if row else NEVER, rows_from=FAR)
        self._ends = ends(telling, stops)
        self.state.ends, self.state.end_count = ctypes.addressof(self._ends), len(self._ends)

    def advance(self, steps: int) -> None:
        """Make so many macro steps, up to the end that a component asks for, or to a stop.

        RunError as `Schedule.run`, `state` telling how far it came.
        """
        state, before = self.state, self.state.now
        status = run_loop(self.step.executor, self.row.executor, state, steps)
        now, size = state.now / NS_PER_SECOND, state.size / NS_PER_SECOND
        if state.now > before:
            self.step.arrive(now)
        if status and state.in_row:
            self.row.fail(status, state.failed, now, 0.0, state.written)
        if status:
            self._go_on(status, now, size)

    def _go_on(self, status: int, now: float, size: float) -> None:
        """Complete the step if it is one in which an FMU asks for the end; `Schedule.fail` if not.

        What it left out as it did not seem to end at a row is read now.
        """
        state, step = self.state, self.step
        at_row = state.since + 1 >= state.every or state.now + state.size >= state.rows_from
        step.go_on(status, state.failed, now, size, state.noted)
        if not at_row:
            done = step.operations[: state.failed]
            reading = [o for o in done if isinstance(o, op.Get | op.GetTyped) and o.in_rows]
            Schedule(reading).run(now, size)
        step.arrive(now + size)
        state.now += state.size
        state.noted += 1
        state.since += 1
