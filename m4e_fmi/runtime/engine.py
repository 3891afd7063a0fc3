"""Programs run by the C library: evaluations, integrations in calls or as a whole, ensembles.

`Engine` is one instance of a program: it keeps its parameters and inputs. Vectors are in the order
of the program's variables, SI units; arrays are C-contiguous float64.
"""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.program.binary_form import Entry, encode
from m4e_fmi.program.program import Program
from m4e_fmi.runtime.compiler import CompilationError
from m4e_fmi.runtime.declarations import (
    BLOCKS,
    LANES,
    METHODS,
    Counts,
    Events,
    OptionsStruct,
    ReportStruct,
)
from m4e_fmi.runtime.kernel import kernel_source, load_kernel
from m4e_fmi.runtime.library import library

Floats = NDArray[np.float64]

DONE, EVENT, NOT_FINITE, SMALL_STEP, MANY_STEPS, MANY_EVENTS, BAD_ARGUMENT, NO_MEMORY = (
    0, 1, -1, -2, -3, -4, -5, -6,
)  # fmt: skip


@dataclass(frozen=True)
class Control:
    """How to integrate: the method's name (rk45, dop853, rodas, rk4) and its limits.

    The local error per step is at most atol + rtol·|x| in the RMS norm; `max_step` in seconds. The
    last `quadratures` states, on which no rate may depend, have a norm of their own: they may
    shorten steps, and never allow the others a larger error.

    rk4 has no error control: from one output time to the next it takes the fewest equal steps that
    are not longer than `max_step`.
    """

    method: str = "dop853"
    rtol: float = 1e-8
    atol: float = 1e-8
    max_step: float = np.inf
    max_steps: int = 10_000_000
    quadratures: int = 0


@dataclass(frozen=True)
class Watch:
    """An event: output `name` changes sign, rising (direction 1), falling (−1) or both (0)."""

    name: str
    direction: int = 0
    terminal: bool = False


@dataclass(frozen=True)
class Run:
    """Result of a run: `status` DONE or EVENT, or a negative one with `message` saying why.

    `time` (n_times,) [s], `states` (n_times, n_states) and `outputs` (n_times, n_outputs) have the
    rows that were reached; `event_index` (n_events,), position in the watches, `event_time`
    (n_events,) [s] and `event_states` (n_events, n_states) the events in the order of time.
    `stopped_at` [s] is how far the integration came, `component` the state whose value or rate was
    not finite.
    """

    status: int
    message: str
    time: Floats
    states: Floats
    outputs: Floats
    event_index: NDArray[np.uint32]
    event_time: Floats
    event_states: Floats
    stopped_at: float
    component: int
    evaluations: int
    jacobians: int
    accepted: int
    rejected: int


def vector(values: ArrayLike, shape: tuple[int, ...], what: str) -> Floats:
    """A contiguous array with the `values`, which have shape (n,) or (n, m), in their units.

    InputError, which names `what` they are, if their shape is not `shape`.
    """
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != shape:
        raise InputError.single(f"{what}: expected shape {shape}, got {array.shape}")
    return array


def _times(times: ArrayLike) -> Floats:
    array = np.ascontiguousarray(times, dtype=np.float64)
    sound = array.ndim == 1 and array.size > 0 and np.isfinite(array).all()
    if not sound or (np.diff(array) < 0).any():
        raise InputError.single("times must be finite numbers in ascending order, at least one")
    return array


def options_of(control: Control) -> OptionsStruct:
    """`control` for the library; InputError if it is not sound."""
    if control.method not in METHODS:
        known = ", ".join(METHODS)
        raise InputError.single(f"there is no method {control.method!r}", f"methods: {known}")
    tolerances = (control.rtol, control.atol)
    if not all(np.isfinite(v) and v >= 0 for v in tolerances) or sum(tolerances) == 0:
        raise InputError.single(f"rtol and atol must be positive, got {tolerances}")
    if not control.max_step > 0:
        raise InputError.single(f"max_step must be positive, got {control.max_step}")
    return OptionsStruct(
        METHODS[control.method], control.rtol, control.atol, control.max_step, control.max_steps,
        control.quadratures,
    )  # fmt: skip


class Engine:
    """One instance of a program in the C library, at the program's start values.

    `outputs` names the outputs to compute (all by default), `watches` the events of `simulate`,
    `jacobian` gives the entries that `rate_entries` finds; `lanes` > 1 is for `ensemble`. Raises
    RunError where the library is missing.
    """

    def __init__(
        self,
        program: Program,
        *,
        outputs: Sequence[str] | None = None,
        watches: Sequence[Watch] = (),
        jacobian: Iterable[Entry] = (),
        lanes: int = 1,
    ) -> None:
        self.library = found = library()
        self.program = program
        self.watches = tuple(watches)
        self.lanes = lanes
        needed = _with_outputs(program, outputs, self.watches)
        positions = {v.name: k for k, v in enumerate(needed.outputs)}
        self.selected = [positions[n] for n in (positions if outputs is None else outputs)]
        self._read(encode(needed, jacobian))
        watched = [positions[w.name] for w in self.watches]
        self.handle = found.m4e_model_new(
            self._program, lanes, *self._indices(self.selected), *self._indices(watched)
        )
        if not self.handle:
            found.m4e_program_free(self._program)
            raise RunError(f"{program.name}: no memory for {self.counts.nodes} operations")
        self._finalizer = weakref.finalize(self, _free, found, self._program, self.handle)
        self._finalizer.atexit = False  # a thread that is left behind may be in the library then
        if lanes == 1:
            self.set_parameters([v.start for v in program.parameters])
            self.set_inputs([v.start for v in program.inputs])

    def _read(self, data: bytes) -> None:
        message = ctypes.create_string_buffer(200)
        self._program = self.library.m4e_program_read(data, len(data), message, len(message))
        if not self._program:
            why = message.value.decode()
            raise RunError(f"{self.program.name}: the program {why}")
        self.counts = Counts()
        self.library.m4e_program_counts(self._program, self.counts)

    @staticmethod
    def _indices(values: Sequence[int]) -> tuple[int, ctypes.Array[ctypes.c_uint32]]:
        return len(values), (ctypes.c_uint32 * max(1, len(values)))(*values)

    def compile(self) -> bool:
        """Use compiled blocks from now on, where they pay; False if no block is compiled.

        That happens without a C compiler, and for programs whose blocks all have more than 5,000
        operations (`kernel.LARGEST`), as of chains of some 15 joints in space: compiling would
        take longer than it saves. Such programs are interpreted, with the same bits.
        """
        blocks = {
            f"m4e_kernel_{name}": self.library.m4e_model_block(self.handle, which).contents
            for name, which in BLOCKS.items()
        }
        source = kernel_source(blocks, self.counts, lanes=self.lanes)
        wide = self.library.m4e_instruction_set().decode()
        if not source:
            return False
        try:
            kernels = load_kernel(source, wide)
        except (CompilationError, OSError):
            return False
        for name, block in blocks.items():
            function = getattr(kernels, name, None)
            block.kernel = ctypes.cast(function, ctypes.c_void_p) if function else None
        return True

    def set_parameters(self, values: ArrayLike) -> None:
        """Set all parameters to `values` (n_parameters,), SI."""
        p = vector(values, (self.counts.parameters,), "parameters")
        self.library.m4e_set_parameters(self.handle, p.ctypes.data)

    def set_inputs(self, values: ArrayLike) -> None:
        """Set all inputs to `values` (n_inputs,), SI."""
        u = vector(values, (self.counts.inputs,), "inputs")
        self.library.m4e_set_inputs(self.handle, u.ctypes.data)

    def rates(self, t: float, x: ArrayLike) -> Floats:
        """Time derivatives (n_states,) of the states at t [s] and states `x` (n_states,), SI."""
        x = vector(x, (self.counts.states,), "states")
        result = np.empty(self.counts.states)
        self.library.m4e_rates(self.handle, t, x.ctypes.data, result.ctypes.data)
        return result

    def outputs(self, t: float, x: ArrayLike) -> Floats:
        """The selected outputs (n_outputs,) at t [s] and states `x` (n_states,), SI."""
        x = vector(x, (self.counts.states,), "states")
        result = np.empty(len(self.selected))
        self.library.m4e_outputs(self.handle, t, x.ctypes.data, result.ctypes.data)
        return result

    def outputs_over(self, times: Floats, states: Floats) -> Floats:
        """The selected outputs (n_times, n_outputs), SI, at `times` (n_times,) [s] and `states`.

        `states` (n_times, n_states), SI.
        """
        n, m = self.counts.states, len(self.selected)
        x = vector(states, (len(times), n), "states")
        result = np.empty((len(times), m))
        at, to, evaluate = x.ctypes.data, result.ctypes.data, self.library.m4e_outputs
        for k, t in enumerate(times.tolist()):
            evaluate(self.handle, t, at + 8 * n * k, to + 8 * m * k)
        return result

    def calculated(self) -> Floats:
        """The calculated parameters (n_calculated,), SI."""
        result = np.empty(self.counts.calculated)
        self.library.m4e_calculated(self.handle, result.ctypes.data)
        return result

    def jacobian(self, t: float, x: ArrayLike) -> Floats:
        """Derivatives (n, n + 1) of the rates by states, then time, SI, at t [s] and `x` (n,), SI.

        InputError if the engine was made without entries of the Jacobian.
        """
        n = self.counts.states
        x = vector(x, (n,), "states")
        result = np.empty((n, n + 1))
        if not self.library.m4e_jacobian(self.handle, t, x.ctypes.data, result.ctypes.data):
            raise InputError.single(f"{self.program.name} was given no Jacobian")
        return result

    def simulate(
        self,
        times: ArrayLike,
        *,
        states: ArrayLike | None = None,
        control: Control | None = None,
        most_events: int = 1000,
    ) -> Run:
        """Integrate over `times` (n_times,) [s] from `states` (n_states,), SI.

        By default `states` are the start values.
        The integration releases the interpreter lock. A run that fails returns what it reached and
        says why in `message`.
        """
        at = _times(times)
        integrator = Integrator(self, control, most_events=most_events)
        start = [v.start for v in self.program.states] if states is None else states
        integrator.start(float(at[0]), start)
        rows = integrator.advance(at, bound=float(at[-1]))
        results = self.outputs_over(at[: len(rows)], rows)
        return self._run(integrator.report, at, rows, results, integrator.record)

    def _run(
        self, report: ReportStruct, at: Floats, rows: Floats, results: Floats, record: EventRecord
    ) -> Run:
        reached, events = report.rows, report.events
        return Run(
            status=report.status,
            message=failure_text(self.program, report),
            time=at[:reached],
            states=rows[:reached],
            outputs=results[:reached],
            event_index=record.index[:events],
            event_time=record.time[:events],
            event_states=record.state[:events],
            stopped_at=report.time,
            component=report.component,
            evaluations=report.evaluations,
            jacobians=report.jacobians,
            accepted=report.accepted,
            rejected=report.rejected,
        )


def _with_outputs(
    program: Program, outputs: Sequence[str] | None, watches: Sequence[Watch]
) -> Program:
    """The program with the requested and watched outputs; all outputs if `outputs` are None."""
    if outputs is None:
        return program
    wanted = {*outputs, *(w.name for w in watches)}
    pairs = zip(program.outputs, program.results, strict=True)
    kept = [(v, node) for v, node in pairs if v.name in wanted]
    return replace(
        program, outputs=tuple(v for v, _ in kept), results=tuple(node for _, node in kept)
    )


def ensemble(
    program: Program,
    times: ArrayLike,
    *,
    parameters: ArrayLike,
    states: ArrayLike,
    inputs: ArrayLike | None = None,
    outputs: Sequence[str] | None = None,
    control: Control | None = None,
    compiled: bool = False,
) -> list[Run]:
    """Runs of one program from many parameter sets and start states, one row each.

    `parameters` (n_runs, n_parameters), `states` (n_runs, n_states) and `inputs` (n_runs, n_inputs,
    the start values by default) are in SI units, `times` (n_times,) in s.

    Eight runs at a time share one pass over the program; each keeps its own steps, so a run gives
    the same bits as `Engine.simulate` alone. Explicit methods, no events. `compiled` takes seconds
    the first time, and pays for long or many runs.
    """
    engine = Engine(program, outputs=outputs, lanes=LANES)
    if compiled:
        engine.compile()
    counts, at = engine.counts, _times(times)
    count = len(np.atleast_2d(np.asarray(states)))
    x = vector(states, (count, counts.states), "states")
    p = vector(parameters, (count, counts.parameters), "parameters")
    default = np.tile([v.start for v in program.inputs], (count, 1))
    u = vector(default if inputs is None else inputs, (count, counts.inputs), "inputs")
    options = options_of(control or Control())
    if options.method == METHODS["rodas"]:
        raise InputError.single("an ensemble needs an explicit method: dop853, rk45 or rk4")
    rows = np.full((count, at.size, counts.states), np.nan)
    results = np.full((count, at.size, len(engine.selected)), np.nan)
    reports = (ReportStruct * count)()
    status = engine.library.m4e_ensemble(
        engine.handle, options, count, p.ctypes.data, u.ctypes.data, x.ctypes.data, at.size,
        at.ctypes.data, rows.ctypes.data, results.ctypes.data, reports,
    )  # fmt: skip
    if status != DONE:
        raise RunError(f"{program.name}: no memory for an ensemble of {count} runs")
    record = EventRecord((), counts.states, 0)
    return [engine._run(reports[k], at, rows[k], results[k], record) for k in range(count)]  # pyrefly: ignore[protected-access]


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
        self.report = ReportStruct()

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
            self._handle, bound, at.size, at.ctypes.data, rows.ctypes.data, self.report
        )
        return rows[: self.report.rows]


class EventRecord:
    """Room for events, and the structure that points to it."""

    def __init__(self, watches: Sequence[Watch], states: int, most: int) -> None:
        most = most if watches else 0
        self.direction = np.array([w.direction for w in watches], dtype=np.int32)
        self.terminal = np.array([w.terminal for w in watches], dtype=np.int32)
        self.index = np.zeros(most, dtype=np.uint32)
        self.time = np.zeros(most)
        self.state = np.zeros((most, states))
        self.events = Events(
            len(watches), self.direction.ctypes.data, self.terminal.ctypes.data, most,
            self.index.ctypes.data, self.time.ctypes.data, self.state.ctypes.data,
        )  # fmt: skip


def failure_text(program: Program, report: ReportStruct) -> str:
    """Why an integration ended as `report` says, in words; empty if it was done."""
    where = f"{program.name} at t = {report.time:.9g} s"
    known = 0 <= report.component < len(program.states)
    state = program.states[report.component] if known else None
    name = f"{state.name} ({state.description})" if state else ""
    return {
        DONE: "",
        EVENT: f"{where}: a terminal event",
        NOT_FINITE: f"{where}: the state {name} or its rate is not finite",
        SMALL_STEP: f"{where}: the step size needed is too small to go on",
        MANY_STEPS: f"{where}: {report.accepted + report.rejected} steps were taken, which is the "
        "limit; stiff equations need fewer by the method rodas",
        MANY_EVENTS: f"{where}: there were more than {report.events} events",
        BAD_ARGUMENT: f"{program.name}: times, tolerances or method are not sound",
        NO_MEMORY: f"{program.name}: no memory",
    }[report.status]


def _free(lib: ctypes.CDLL, program: int, model: int) -> None:
    lib.m4e_model_free(model)
    lib.m4e_program_free(program)
