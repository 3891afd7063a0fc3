"""Slave of a program: integrates its states, computes its outputs.

The C runtime does it where its library, which is packed, can be loaded; plain Python elsewhere,
with another integrator unless the method is rk4. Inputs are held during a step. The local error per
step is bounded by the importer's tolerance, or by the one that `layout.json` gives; rk4 takes fixed
steps.
"""

from __future__ import annotations

import json

from .python_engine import PythonEngine
from .runtime_engine import RuntimeEngine
from .slave_base import M4eSlave, Saved

LAYOUT = "layout.json"


class ProgramSlave(M4eSlave):
    """`layout.json` gives the value references of the program's vectors, in their order, the method
    of integration, the tolerance where the importer gives none, and the longest step of rk4."""

    def __init__(self, **kwargs: str) -> None:
        super().__init__(**kwargs)
        layout = json.loads((self.resources / LAYOUT).read_text(encoding="utf-8"))
        self._parameters = layout["parameters"]
        self._inputs = layout["inputs"]
        self._states = layout["states"]
        self._outputs = layout["outputs"]
        self._calculated = layout["calculated"]
        self._fixed = set(self._parameters)
        self._default = layout["tolerance"]
        self._known = False
        self._held = False  # nothing was set since the last step
        self._engine = self._new_engine(layout["method"], layout["step_size"])

    def _new_engine(self, method: str, step_size: float) -> RuntimeEngine | PythonEngine:
        states, outputs = ([self._names[k] for k in vrs] for vrs in (self._states, self._outputs))
        try:
            return RuntimeEngine(
                self.resources,
                self._default,
                states,
                outputs,
                len(self._calculated),
                method=method,
                step_size=step_size,
            )
        except OSError:
            return PythonEngine(self._default, method=method, step_size=step_size)

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        super().setup_experiment(start_time, stop_time, tolerance)
        self._set_tolerance()

    def _set_tolerance(self) -> None:
        self._engine.tolerance = self.tolerance or self._default

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        before = [self.values[k] for k in vrs if k < len(self.values)]
        super().set_real(vrs, values)
        if before != [self.values[k] for k in vrs if k < len(self.values)]:
            self._held = False
        if self._known and not self._fixed.isdisjoint(vrs):
            self._known = False

    def _prepare(self) -> None:
        """Collect the inputs; recompute what depends on parameters if one has changed."""
        values = self.values
        if not self._known:
            found = self._engine.set_parameters([values[k] for k in self._parameters])
            for k, value in zip(self._calculated, found, strict=True):
                values[k] = value
            self._known = True
        self._engine.set_inputs([values[k] for k in self._inputs])

    def step(self, t: float, h: float) -> None:
        self._prepare()
        values = self.values
        x = [values[k] for k in self._states]
        found = self._engine.advance(t, x, t + h, held=self._held)
        for k, value in zip(self._states, found, strict=True):
            values[k] = value
        self._held = True

    def update(self) -> None:
        self._prepare()
        values = self.values
        x = [values[k] for k in self._states]
        results = self._engine.outputs(self.time, x)
        for k, value in zip(self._outputs, results, strict=True):
            values[k] = value

    def save(self) -> Saved:
        return {"held": self._held, "engine": self._engine.save()}

    def restore(self, saved: Saved) -> None:
        self._held = saved["held"]
        self._set_tolerance()
        self._engine.restore(saved["engine"])
        self._known = False
