"""Slave of a program: integrates its states, computes its outputs.

The C runtime does it, whose library is packed, with the bits of a native FMU. Inputs are held
during a step. The local error per step is bounded by the importer's tolerance, or by the one that
`layout.json` gives; rk4 takes fixed steps.
"""

from __future__ import annotations

import json
import sys
import weakref
from collections.abc import Callable
from ctypes import CDLL, Array, byref, c_double, c_int32, c_uint32, create_string_buffer
from math import inf, isfinite
from pathlib import Path

from .declarations import METHODS, OptionsStruct, ReportStruct, load, snapshot_size  # type: ignore[import]  # packed beside this
from .slave_base import M4eSlave, Saved

LAYOUT, LIBRARY, PROGRAM = "layout.json", f"runtime.{sys.platform}", "model.m4e"
DONE, SMALL_STEP, MANY_STEPS = 0, -2, -3
MOST_STEPS = 1_000_000  # of one call of advance
_loaded: list[CDLL] = []  # once per process: the folder of the first instance may be gone by now


class ProgramSlave(M4eSlave):
    """`layout.json` gives the value references of the program's vectors, in their order, the method
    of integration, the tolerance where the importer gives none, and the longest step of rk4."""

    def __init__(self, **kwargs: str) -> None:
        super().__init__(**kwargs)
        self._layout = layout = json.loads((self.resources / LAYOUT).read_text(encoding="utf-8"))
        self._fixed = set(layout["parameters"])
        self._known = False  # what is calculated from parameters, to the engine and here
        self._held = False  # nothing was set since the last step
        self._engine = Engine(self.resources, layout, self._names)

    @property
    def _tolerance(self) -> float:
        return self.tolerance or self._layout["tolerance"]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        before = [self.values[k] for k in vrs if k < len(self.values)]
        super().set_real(vrs, values)
        if before != [self.values[k] for k in vrs if k < len(self.values)]:
            self._held = False
        if not self._fixed.isdisjoint(vrs):
            self._known = False

    def _vector(self, group: str) -> list[float]:
        return [self.values[k] for k in self._layout[group]]

    def _set_vector(self, group: str, found: list[float]) -> None:
        for k, value in zip(self._layout[group], found, strict=True):
            self.values[k] = value

    def _prepare(self) -> None:
        """Collect the inputs; recompute what depends on parameters if one has changed."""
        if not self._known:
            found = self._engine.set_parameters(self._vector("parameters"))
            self._set_vector("calculated", found)
            self._known = True
        self._engine.set_inputs(self._vector("inputs"))

    def step(self, t: float, h: float) -> None:
        self._prepare()
        x = self._vector("states")
        found = self._engine.advance(t, x, t + h, held=self._held, tolerance=self._tolerance)
        self._set_vector("states", found)
        self._held = True

    def update(self) -> None:
        self._prepare()
        self._set_vector("outputs", self._engine.outputs(self.time, self._vector("states")))

    def save(self) -> Saved:
        return {"held": self._held, "engine": self._engine.save()}

    def restore(self, saved: Saved) -> None:
        self._held = saved["held"]
        self._engine.restore(saved["engine"], self._tolerance)
        self._known = False


def _doubles(values: list[float]) -> Array[c_double]:
    return (c_double * len(values))(*values)


class Engine:
    """The program run by the C runtime's library in `folder`; OSError where it cannot be loaded.

    `layout` is that of `ProgramSlave`, `names` are the variables', for messages.
    """

    def __init__(self, folder: Path, layout: Saved, names: list[str]) -> None:
        if not _loaded:
            _loaded.append(load(folder / LIBRARY))
        self._lib = lib = _loaded[0]
        content = (folder / PROGRAM).read_bytes()
        message = create_string_buffer(128)
        program = lib.m4e_program_read(content, len(content), message, len(message))
        if not program:
            raise OSError(f"{PROGRAM} {message.value.decode()}")
        count = len(layout["outputs"])
        self._model = lib.m4e_model_new(
            program, 1, count, (c_uint32 * count)(*range(count)), 0, None
        )
        if not self._model:
            lib.m4e_program_free(program)
            raise OSError(f"{PROGRAM} does not fit into memory")
        weakref.finalize(self, _free, lib, program, self._model)
        self._layout, self._names = layout, names
        self._integrator: int | None = None
        self._release: Callable[[], object] | None = None
        self._built = 0.0  # tolerance of the integrator
        self._step = 0.0
        self._ahead = c_int32(0)

    def set_parameters(self, p: list[float]) -> list[float]:
        """Calculated parameters, after parameters have been set to `p`."""
        self._lib.m4e_set_parameters(self._model, _doubles(p))
        result = (c_double * len(self._layout["calculated"]))()
        self._lib.m4e_calculated(self._model, result)
        return list(result)

    def set_inputs(self, u: list[float]) -> None:
        """Set the inputs, which are held during a step."""
        self._lib.m4e_set_inputs(self._model, _doubles(u))

    def outputs(self, t: float, x: list[float]) -> list[float]:
        """Outputs at t [s] and the states x; ArithmeticError if one is not finite."""
        result = (c_double * len(self._layout["outputs"]))()
        self._lib.m4e_outputs(self._model, t, _doubles(x), result)
        for k, value in zip(self._layout["outputs"], result, strict=True):
            if not isfinite(value):
                raise ArithmeticError(f"{self._names[k]} is {value}")
        return list(result)

    def advance(
        self, t: float, x: list[float], t_end: float, *, held: bool, tolerance: float
    ) -> list[float]:
        """States at t_end [s] from the states x at t; ArithmeticError if it is not reached.

        Where nothing was set since the last call, which is `held`, the integrator cuts no step.
        """
        self._build(tolerance)
        report, result = ReportStruct(), _doubles(x)
        status = self._lib.m4e_go_on(
            self._integrator, t, result, t_end, held, self._step, byref(self._ahead), byref(report)
        )
        self._step = report.step
        if status != DONE:
            raise ArithmeticError(self._failure(report))
        return list(result)

    def save(self) -> list[float]:
        """Numbers that `advance` goes on from, besides states, inputs and parameters."""
        numbers = (c_double * snapshot_size(len(self._layout["states"])))()
        if self._ahead.value:
            self._lib.m4e_keep(self._integrator, numbers)
        return [self._step, *(numbers if self._ahead.value else ())]

    def restore(self, saved: list[float], tolerance: float) -> None:
        """Take back what `save` returned, in a run to `tolerance`."""
        self._step, *ahead = saved
        self._ahead.value = bool(ahead)
        if ahead:
            self._build(tolerance)
            self._lib.m4e_take_up(self._integrator, _doubles(ahead))

    def _build(self, tolerance: float) -> None:
        """Make the integrator for a tolerance, unless it is there."""
        if self._built == tolerance:
            return
        if self._release:
            self._release()
        method = self._layout["method"]
        options = OptionsStruct(
            method=METHODS[method],
            rtol=tolerance,
            atol=tolerance,
            max_step=self._layout["step_size"] if method == "rk4" else inf,
            max_steps=MOST_STEPS,
        )
        self._integrator = self._lib.m4e_integrator_new(self._model, options, None)
        if not self._integrator:
            raise MemoryError("no memory for the integrator")
        self._release = weakref.finalize(self, self._lib.m4e_integrator_free, self._integrator)
        self._built = tolerance

    def _failure(self, report: ReportStruct) -> str:
        why = {
            SMALL_STEP: "the step size needed is too small to go on",
            MANY_STEPS: "too many steps are needed",
        }.get(report.status, "a state or its rate is not finite")
        states = self._layout["states"]
        known = 0 <= report.component < len(states)
        where = f": {self._names[states[report.component]]}" if known else ""
        return f"{why} at t = {report.time:.9g} s{where}"


def _free(lib: CDLL, program: int, model: int) -> None:
    lib.m4e_model_free(model)
    lib.m4e_program_free(program)
