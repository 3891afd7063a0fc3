"""A program run by the C runtime that is packed beside this file: the bits of a native FMU.

Declarations: m4e.h.
"""

import weakref
from ctypes import (
    CDLL,
    POINTER,
    Structure,
    byref,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_size_t,
    c_uint32,
    c_uint64,
    c_void_p,
    create_string_buffer,
)
from math import inf, isfinite

LIBRARY, PROGRAM = "runtime.bin", "model.m4e"
DOP853, DONE, SMALL_STEP, MANY_STEPS = 1, 0, -2, -3
MOST_STEPS = 1_000_000  # of one call of advance


class Options(Structure):
    _fields_ = [
        ("method", c_int32),
        ("rtol", c_double),
        ("atol", c_double),
        ("max_step", c_double),
        ("max_steps", c_uint64),
    ]


class Report(Structure):
    _fields_ = [
        ("status", c_int32),
        ("component", c_int32),
        ("time", c_double),
        ("step", c_double),
        *((name, c_uint64) for name in ("evaluations", "jacobians", "accepted", "rejected")),
        *((name, c_uint64) for name in ("rows", "events")),
    ]


_SIGNATURES = {
    "m4e_program_read": (c_void_p, c_char_p, c_size_t, c_char_p, c_size_t),
    "m4e_program_free": (None, c_void_p),
    "m4e_model_new": (c_void_p, c_void_p, c_uint32, c_uint32, c_void_p, c_uint32, c_void_p),
    "m4e_model_free": (None, c_void_p),
    "m4e_set_parameters": (None, c_void_p, c_void_p),
    "m4e_set_inputs": (None, c_void_p, c_void_p),
    "m4e_calculated": (None, c_void_p, c_void_p),
    "m4e_outputs": (None, c_void_p, c_double, c_void_p, c_void_p),
    "m4e_integrator_new": (c_void_p, c_void_p, POINTER(Options), c_void_p),
    "m4e_integrator_free": (None, c_void_p),
    "m4e_start": (None, c_void_p, c_double, c_void_p, c_double),
    "m4e_advance": (c_int, c_void_p, c_double, c_size_t, c_void_p, c_void_p, POINTER(Report)),
}
_loaded = []  # once per process: the folder of the first instance may be gone by now


def _library(path):
    if not _loaded:
        library = CDLL(str(path))
        for name, (result, *arguments) in _SIGNATURES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
        _loaded.append(library)
    return _loaded[0]


def _doubles(values):
    return (c_double * len(values))(*values)


class RuntimeEngine:
    """As PythonEngine. `states` and `outputs` are names, for messages; OSError without library."""

    def __init__(self, folder, tolerance, states, outputs, calculated):
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
        self._integrator = self._release = None
        self._built = 0.0
        self._states, self._outputs, self._calculated = states, outputs, calculated
        self.tolerance = tolerance
        self.step = 0.0

    def set_parameters(self, p):
        self._lib.m4e_set_parameters(self._model, _doubles(p))
        result = (c_double * self._calculated)()
        self._lib.m4e_calculated(self._model, result)
        return list(result)

    def set_inputs(self, u):
        self._lib.m4e_set_inputs(self._model, _doubles(u))

    def outputs(self, t, x):
        """Raises ArithmeticError if one is not finite."""
        result = (c_double * len(self._outputs))()
        self._lib.m4e_outputs(self._model, t, _doubles(x), result)
        for name, value in zip(self._outputs, result, strict=True):
            if not isfinite(value):
                raise ArithmeticError(f"{name} is {value}")
        return list(result)

    def advance(self, t, x, t_end):
        """Raises ArithmeticError if t_end cannot be reached."""
        if self._built != self.tolerance:
            self._build()
        report, end = Report(), c_double(t_end)
        result = (c_double * len(x))()
        lib = self._lib
        lib.m4e_start(self._integrator, t, _doubles(x), self.step)
        status = lib.m4e_advance(self._integrator, t_end, 1, byref(end), result, byref(report))
        self.step = report.step
        if status != DONE:
            raise ArithmeticError(self._failure(report))
        return list(result)

    def _build(self):
        if self._release:
            self._release()
        options = Options(DOP853, self.tolerance, self.tolerance, inf, MOST_STEPS)
        self._integrator = self._lib.m4e_integrator_new(self._model, options, None)
        if not self._integrator:
            raise MemoryError("no memory for the integrator")
        self._release = weakref.finalize(self, self._lib.m4e_integrator_free, self._integrator)
        self._built = self.tolerance

    def _failure(self, report):
        why = {
            SMALL_STEP: "the step size needed is too small to go on",
            MANY_STEPS: "too many steps are needed",
        }.get(report.status, "a state or its rate is not finite")
        known = 0 <= report.component < len(self._states)
        where = f": {self._states[report.component]}" if known else ""
        return f"{why} at t = {report.time:.9g} s{where}"


def _free(lib, program, model):
    lib.m4e_model_free(model)
    program()
