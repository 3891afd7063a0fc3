"""An integration that is cut into calls: for progress reports and co-simulation steps."""

from __future__ import annotations

import ctypes
import weakref

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError
from m4e_fmi.runtime.engine import (
    Control,
    Engine,
    EventRecord,
    Floats,
    Report,
    options_of,
    vector,
)


class Integrator:
    """Advances one engine; keeps step size and dense output between calls.

    Cutting one integration into calls of `advance` with the same `bound` changes no bit. After a
    change of inputs, parameters or states call `start` again, with `report.step` as the first step.
    `record` has the events of the engine's watches, `report.events` of them, up to `most_events`.
    """

    def __init__(
        self, engine: Engine, control: Control | None = None, *, most_events: int = 1000
    ) -> None:
        self.engine = engine
        lib = engine.library
        self.record = EventRecord(engine.watches, engine.counts.states, most_events)
        options = options_of(control or Control())
        self._handle = lib.m4e_integrator_new(engine.handle, options, self.record.events)
        if not self._handle:
            raise InputError.single(f"{engine.program.name}: options that are not sound")
        self._finalizer = weakref.finalize(self, lib.m4e_integrator_free, self._handle)
        self.report = Report()

    def start(self, t: float, states: ArrayLike, *, step: float = 0.0) -> None:
        """Begin at t [s] and `states` (n_states,), SI; try `step` [s] first, 0: by the rates."""
        x = vector(states, (self.engine.counts.states,), "states")
        self.engine.library.m4e_start(self._handle, t, x.ctypes.data, step)

    def advance(self, times: ArrayLike, *, bound: float) -> Floats:
        """States (n_times, n_states), SI, at `times` (n_times,) [s], ascending and ≤ `bound` [s].

        No step goes beyond `bound`. `report` has status, steps and evaluations since the start;
        after a failure the rows not reached are missing.
        """
        at = np.ascontiguousarray(times, dtype=np.float64)
        rows = np.empty((at.size, self.engine.counts.states))
        self.engine.library.m4e_advance(
            self._handle, bound, at.size, at.ctypes.data, rows.ctypes.data,
            ctypes.byref(self.report),
        )  # fmt: skip
        return rows[: self.report.rows]
