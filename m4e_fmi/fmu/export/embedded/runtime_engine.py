"""A program run by the C runtime that is packed beside this file: the bits of a native FMU."""

from __future__ import annotations

import sys
import weakref
from collections.abc import Callable
from ctypes import CDLL, Array, byref, c_double, c_int32, c_uint32, create_string_buffer
from math import inf, isfinite
from pathlib import Path

from .declarations import METHODS, Options, Report, kept, load  # type: ignore[import]  # packed, too

LIBRARY, PROGRAM = f"runtime.{sys.platform}", "model.m4e"
DONE, SMALL_STEP, MANY_STEPS = 0, -2, -3
MOST_STEPS = 1_000_000  # of one call of advance
_loaded: list[CDLL] = []  # once per process: the folder of the first instance may be gone by now


def _library(path: Path) -> CDLL:
    if not _loaded:
        _loaded.append(load(path))
    return _loaded[0]


def _doubles(values: list[float]) -> Array[c_double]:
    return (c_double * len(values))(*values)


class RuntimeEngine:
    """As PythonEngine. `states` and `outputs` are names, for messages; OSError without library."""

    def __init__(
        self,
        folder: Path,
        tolerance: float,
        states: list[str],
        outputs: list[str],
        calculated: int,
        *,
        method: str,
        step_size: float,
    ) -> None:
        self._lib = lib = _library(folder / LIBRARY)
        content = (folder / PROGRAM).read_bytes()
        message = create_string_buffer(128)
        self._program = lib.m4e_program_read(content, len(content), message, len(message))
        if not self._program:
            raise OSError(f"{PROGRAM} {message.value.decode()}")
        self._held = weakref.finalize(self, lib.m4e_program_free, self._program)
        chosen = (c_uint32 * len(outputs))(*range(len(outputs)))
        self._model = lib.m4e_model_new(self._program, 1, len(outputs), chosen, 0, None)
        if not self._model:
            raise OSError(f"{PROGRAM} does not fit into memory")
        self._held = weakref.finalize(self, _free, lib, self._held, self._model)
        self._method, self._step_size = method, step_size
        self._integrator: int | None = None
        self._release: Callable[[], object] | None = None
        self._built = 0.0
        self._states, self._outputs, self._calculated = states, outputs, calculated
        self.tolerance = tolerance
        self.step = 0.0
        self._ahead = c_int32(0)

    def set_parameters(self, p: list[float]) -> list[float]:
        """Calculated parameters, after parameters have been set to `p`."""
        self._lib.m4e_set_parameters(self._model, _doubles(p))
        result = (c_double * self._calculated)()
        self._lib.m4e_calculated(self._model, result)
        return list(result)

    def set_inputs(self, u: list[float]) -> None:
        """Set the inputs, which are held during a step."""
        self._lib.m4e_set_inputs(self._model, _doubles(u))

    def outputs(self, t: float, x: list[float]) -> list[float]:
        """Outputs at t [s] and the states x; ArithmeticError if one is not finite."""
        result = (c_double * len(self._outputs))()
        self._lib.m4e_outputs(self._model, t, _doubles(x), result)
        for name, value in zip(self._outputs, result, strict=True):
            if not isfinite(value):
                raise ArithmeticError(f"{name} is {value}")
        return list(result)

    def advance(self, t: float, x: list[float], t_end: float, *, held: bool) -> list[float]:
        """States at t_end [s] from the states x at t; ArithmeticError if it is not reached.

        Where nothing was set since the last call, which is `held`, the integrator cuts no step.
        """
        if self._built != self.tolerance:
            self._build()
        report, result = Report(), _doubles(x)
        status = self._lib.m4e_go_on(
            self._integrator, t, result, t_end, held, self.step, byref(self._ahead), byref(report)
        )
        self.step = report.step
        if status != DONE:
            raise ArithmeticError(self._failure(report))
        return list(result)

    def save(self) -> list[float]:
        """Numbers that `advance` goes on from, besides states, inputs and parameters."""
        numbers = (c_double * kept(len(self._states)))()
        if self._ahead.value:
            self._lib.m4e_keep(self._integrator, numbers)
        return [self.step, *(numbers if self._ahead.value else ())]

    def restore(self, saved: list[float]) -> None:
        """Take back what `save` returned; the tolerance is that of then."""
        self.step, *ahead = saved
        self._ahead.value = bool(ahead)
        if not self._ahead.value:
            return
        if self._built != self.tolerance:
            self._build()
        self._lib.m4e_take_up(self._integrator, _doubles(ahead))

    def _build(self) -> None:
        if self._release:
            self._release()
        options = Options(
            method=METHODS[self._method],
            rtol=self.tolerance,
            atol=self.tolerance,
            max_step=self._step_size if self._method == "rk4" else inf,
            max_steps=MOST_STEPS,
        )
        self._integrator = self._lib.m4e_integrator_new(self._model, options, None)
        if not self._integrator:
            raise MemoryError("no memory for the integrator")
        self._release = weakref.finalize(self, self._lib.m4e_integrator_free, self._integrator)
        self._built = self.tolerance

    def _failure(self, report: Report) -> str:
        why = {
            SMALL_STEP: "the step size needed is too small to go on",
            MANY_STEPS: "too many steps are needed",
        }.get(report.status, "a state or its rate is not finite")
        known = 0 <= report.component < len(self._states)
        where = f": {self._states[report.component]}" if known else ""
        return f"{why} at t = {report.time:.9g} s{where}"


def _free(lib: CDLL, program: Callable[[], object], model: int) -> None:
    lib.m4e_model_free(model)
    program()
