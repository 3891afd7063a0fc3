"""Slave of a program: integrates its states, computes its outputs.

Inputs are held during a step. The local error per step is bounded by the importer's tolerance, or
by `DEFAULT_TOLERANCE`.
"""

import json

from . import model  # type: ignore[attr-defined]  # the program's Python form, too
from .dormand_prince import DormandPrince  # type: ignore[import]  # packed beside this file
from .slave_base import M4eSlave

LAYOUT = "layout.json"
DEFAULT_TOLERANCE = 1e-8


class ProgramSlave(M4eSlave):
    """`layout.json` gives the value references of the program's vectors, in their order."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        layout = json.loads((self.resources / LAYOUT).read_text(encoding="utf-8"))
        self._parameters = layout["parameters"]
        self._inputs = layout["inputs"]
        self._states = layout["states"]
        self._outputs = layout["outputs"]
        self._calculated = layout["calculated"]
        self._fixed = set(self._parameters)
        self._p, self._c, self._u = [], [], []
        self._known = False
        self._integrator = DormandPrince(self._rates, tolerance=DEFAULT_TOLERANCE)

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):
        super().setup_experiment(start_time, stop_time, tolerance)
        self._set_tolerance()

    def _set_tolerance(self):
        self._integrator.tolerance = self.tolerance or DEFAULT_TOLERANCE

    def set_real(self, vrs, values):
        super().set_real(vrs, values)
        if self._known and not self._fixed.isdisjoint(vrs):
            self._known = False

    def _rates(self, t, x):
        return model.rates(t, x, self._u, self._p, self._c)

    def _prepare(self):
        """Collect the inputs; recompute what depends on parameters if one has changed."""
        values = self.values
        if not self._known:
            self._p = [values[k] for k in self._parameters]
            self._c = model.constants(self._p)
            for k, value in zip(self._calculated, model.calculated(self._p, self._c), strict=True):
                values[k] = value
            self._known = True
        self._u = [values[k] for k in self._inputs]

    def step(self, t, h):
        self._prepare()
        values = self.values
        x = [values[k] for k in self._states]
        for k, value in zip(self._states, self._integrator.advance(t, x, t + h), strict=True):
            values[k] = value

    def update(self):
        self._prepare()
        values = self.values
        x = [values[k] for k in self._states]
        results = model.outputs(self.time, x, self._u, self._p, self._c)
        for k, value in zip(self._outputs, results, strict=True):
            values[k] = value

    def save(self):
        return {"step": self._integrator.step}

    def restore(self, saved):
        self._integrator.step = saved["step"]
        self._set_tolerance()
        self._known = False
