"""The FMU under test in this process: its instances, and what a group of checks knows of it.

Value references are the keys of `elements`. Where only some elements of an
array are set, the others get what they were last set to, or their start values: FMI 3.0 sets whole
arrays only.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.calls import STANDARDS, Loaded
from m4e_fmi.fmu.importer.calls.access import Arrays
from m4e_fmi.fmu.importer.messages import (
    ERROR,
    FATAL,
    NO_STATUS,
    OK,
    PENDING,
    STATUS,
    WARNING,
    Messages,
    Status,
)
from m4e_fmi.fmu.validation.findings import Finding
from m4e_fmi.fmu.validation.subject import CLASSES, FmuUnderTest, scale, start, within

INSTANTIATE = "instantiation"
TOLERANCE = 1e-8
"""Relative tolerance that the FMU is asked for."""
MOST_ITERATIONS = 100
"""Event iterations at one time."""
FACTS = "facts.json"
"""File of what the first group has found for the others; without it, the FMU does not start."""
SEED = 20

SavedState = tuple[float, ctypes.c_void_p]
"""Time [s] of a saved state, and the FMU's pointer to it."""
_Fill = Callable[[np.ndarray], Status]
"""Writes all elements of an array (n,), and tells the status."""


class RefusedError(Exception):
    """A call that the standard allows was answered with `status`."""

    def __init__(self, call: str, status: Status, words: Sequence[str]) -> None:
        self.call, self.status, self.words = call, status, tuple(words)
        super().__init__(f"{call} answered {STATUS.get(status, status)}")


def refused(group: str, error: RefusedError, how: str = "") -> Finding:
    """The finding that an allowed call was refused."""
    basis = "the call is allowed here: FMI 2.0.4, section 3.2.3 and 4.2.4"
    name = "fatal" if error.status in (FATAL, NO_STATUS) else "refused"
    if error.call == INSTANTIATE:
        basis = "is the GUID of modelDescription.xml that of the binary? FMI 2.0.4, section 2.1.5"
    return Finding(f"{group}.{name}", "error", f"{error}{how}", basis, error.words)


@dataclass
class Context:
    """One group's process: `folder` is for files that the next group reads.

    From the first group, inputs may vary by `amplitude` times their scale, and `works` names the
    declared capabilities that are really there.
    """

    subject: FmuUnderTest
    journal: Callable[[str], None]
    folder: Path
    amplitude: float = 0.0
    works: list[str] = field(default_factory=list)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(SEED))
    _loaded: dict[bool, Loaded] = field(default_factory=dict)

    def loaded(self, *, exchange: bool) -> Loaded:
        """The library, loaded once, with the functions of model exchange or of co-simulation."""
        if exchange not in self._loaded:
            here, raw = Path.cwd(), self.subject.raw
            self.journal("loading the library")
            try:
                found = CLASSES[raw.fmiVersion][exchange](
                    guid=raw.guid,
                    unzipDirectory=str(self.subject.folder),
                    modelIdentifier=self.subject.kind(exchange=exchange).modelIdentifier,
                    instanceName="validation",
                )
            finally:
                os.chdir(here)  # loading leaves the process elsewhere when it fails
            self._loaded[exchange] = Loaded(found.dll, "", raw.guid, self.subject.folder)
        return self._loaded[exchange]

    @contextmanager
    def probe(
        self, *, exchange: bool = False, name: str = "validation"
    ) -> Generator[Probe, None, None]:
        """An instance that is freed afterwards, whatever happened."""
        probe = Probe(self, exchange=exchange, name=name)
        try:
            yield probe
        finally:
            probe.free()

    def random_inputs(self, count: int = 1) -> np.ndarray:
        """Random continuous inputs (count, n_inputs), in their units.

        Declared derivatives of inputs stay 0.
        """
        held = [v.derivative is not None for v in self.subject.inputs]
        values = self.random(self.subject.inputs, count)
        values[:, held] = 0.0
        return values

    def random(self, variables: list[ModelVariable], count: int = 1) -> np.ndarray:
        """Random values (count, n_variables) around the start values and in the limits, in SI."""
        size = self.amplitude * np.array([scale(v) for v in variables])
        middle = np.array([start(v) for v in variables])
        values = middle + size * self.rng.uniform(-1, 1, (count, len(variables)))
        for k, variable in enumerate(variables):
            values[:, k] = [within(variable, value) for value in values[:, k]]
        return values


class Probe:
    """One instance, in co-simulation without event mode; RefusedError if the FMU makes none.

    All calls are allowed, and raise RefusedError if the answer is not OK or Warning.
    """

    def __init__(self, context: Context, *, exchange: bool, name: str = "validation") -> None:
        self.subject, self.exchange, self.time = context.subject, exchange, 0.0
        self._messages = Messages()
        self._last_set: dict[int, np.ndarray] = {}
        starts = self.subject.array_starts if self.subject.fmi_3 else {}
        self.fmu = STANDARDS[self.subject.raw.fmiVersion](
            context.loaded(exchange=exchange),
            {},
            self._refused,
            sizes={reference: len(values) for reference, values in starts.items()},
            journal=context.journal,
        )
        context.journal(f"instantiation({name!r})")
        with suppress(RuntimeError):
            self.fmu.instantiate(name, self._messages, exchange=exchange)
        if not self.fmu.component:
            raise RefusedError(INSTANTIATE, ERROR, self.words())

    # ---- calls ----

    def _refused(self, status: Status, _: str = "", deed: str = "") -> NoReturn:
        status = status if OK <= status <= PENDING else NO_STATUS
        if status in (FATAL, NO_STATUS):
            self.fmu.component, deed = None, ""  # which must not be called any more
        raise RefusedError(deed or self.fmu.last_call, status, self.words())

    def require(self, status: Status, deed: str = "") -> None:
        """RefusedError about an allowed `deed`, the last call, if its status is above Warning."""
        if not OK <= status <= WARNING:
            self._refused(status, deed=deed)

    def words(self) -> tuple[str, ...]:
        """The FMU's messages since the last time, troubles only if there are any."""
        told = self._messages.take()
        trouble = [text for status, text in told if status != OK]
        return tuple(text[:300] for text in (trouble or [text for _, text in told])[-3:])

    # ---- the life of an instance ----

    def begin(
        self,
        changed: Sequence[ModelVariable] = (),
        values: np.ndarray | None = None,
    ) -> Probe:
        """This instance at its first step or, in model exchange, in continuous-time mode.

        It has other start `values` (n_changed,), in their units, for Reals that are `changed`.
        """
        self.setup()
        if values is not None:
            self.put(changed, values)
        self.fmu.enter_initialization()
        self.fmu.exit_initialization()
        if self.exchange:
            self._settle()
            self.fmu.do("EnterContinuousTimeMode")
        return self

    def setup(self) -> None:
        """Tell the experiment: the FMU's start time."""
        self.time = self.subject.start_time
        self.fmu.setup(start=self.time, stop=None, tolerance=TOLERANCE)

    def _settle(self) -> None:
        """Event iteration until nothing changes any more."""
        for _ in range(MOST_ITERATIONS):
            status, again = self.fmu.needs_new_discrete_states()
            self.require(status)
            if not again:
                return
        self._refused(WARNING, deed=f"{self._last_function}, {MOST_ITERATIONS} times,")

    def advance(self, size: float) -> None:
        """One communication step of `size` [s]; RefusedError if it is not made."""
        self.require(self.fmu.do_step(self.time, size))
        self.time += size

    def reset(self) -> None:
        """Bring the instance back to where it was when it was made."""
        self.fmu.do("Reset")
        self._last_set.clear()

    def free(self) -> None:
        """Free the instance, if there is one."""
        if self.fmu.component:
            self.fmu.free()

    # ---- values ----

    def put(
        self, variables: Sequence[ModelVariable], values: np.ndarray, deed: str = "setting values"
    ) -> None:
        """Set Reals to `values` (n_variables,), in their units; RefusedError if not allowed."""
        if not variables:
            return
        arrays, starts = self._arrays(variables), self.subject.array_starts
        last = [self._last_set.get(r, starts.get(r, np.zeros(1))) for r in arrays.references]
        data = np.concatenate([row[:n] for row, n in zip(last, arrays.sizes, strict=True)])
        data[list(arrays.places)] = values
        self.require(self.fmu.set_reals(arrays, data), deed)
        parts = np.split(data, np.cumsum(arrays.sizes)[:-1])
        self._last_set |= dict(zip(arrays.references, parts, strict=True))

    def read(self, variables: Sequence[ModelVariable]) -> np.ndarray:
        """Values (n_variables,) of Reals, in their units; RefusedError if they cannot be had."""
        if not variables:
            return np.zeros(0)
        y = self._arrays(variables)
        return self._elements(y, lambda to: self.fmu.get_reals(y, to), "getting values")

    def _arrays(self, variables: Sequence[ModelVariable]) -> Arrays:
        return self.fmu.arrays([v.valueReference for v in variables])

    def _elements(self, arrays: Arrays, fill: _Fill, deed: str = "") -> np.ndarray:
        """The wanted elements of arrays that `fill` fills; RefusedError if it does not."""
        return self._filled(arrays.count, fill, deed)[list(arrays.places)]

    def _filled(self, count: int, fill: _Fill, deed: str = "") -> np.ndarray:
        """An array (count,) that `fill` fills."""
        room = np.full(count, np.nan)
        self.require(fill(room), deed or self._last_function)
        return room

    @property
    def _last_function(self) -> str:
        return self.fmu.last_call.partition("(")[0]

    # ---- model exchange ----

    def vector(self, function: str = "GetContinuousStates") -> np.ndarray:
        """Continuous states (n_states,), in their units, or what else a function says of them."""
        count, kind = len(self.subject.states), ctypes.POINTER(ctypes.c_double)
        call = self.fmu.call
        return self._filled(count, lambda to: call(function, to.ctypes.data_as(kind), count))

    def rates(self) -> np.ndarray:
        """Time derivatives (n_states,) of the continuous states, in their units per second."""
        return self.vector("GetDerivatives")

    def set_states(self, x: np.ndarray) -> None:
        """Set the continuous states to `x` (n_states,), in their units."""
        data = np.ascontiguousarray(x, dtype=np.float64)
        kind = ctypes.POINTER(ctypes.c_double)
        self.fmu.do("SetContinuousStates", data.ctypes.data_as(kind), len(data))

    # ---- derivatives ----

    def sensitivity(
        self, unknowns: Sequence[ModelVariable], knowns: Sequence[ModelVariable]
    ) -> np.ndarray:
        """Change (n_unknowns,) of `unknowns` for the change of each of `knowns` by 1, in SI."""
        z, v = self._arrays(unknowns), self._arrays(knowns)
        seed = np.zeros(v.count)
        seed[list(v.places)] = 1.0
        return self._elements(z, lambda to: self.fmu.sensitivity(z, v, seed, to))

    # ---- state ----

    def save(self) -> SavedState:
        """A saved state of the instance."""
        state = ctypes.c_void_p()
        self.fmu.do("GetFMUstate", ctypes.byref(state))
        return self.time, state

    def restore(self, saved: SavedState) -> None:
        """Return the instance to a saved state."""
        self.time, state = saved
        self.fmu.do("SetFMUstate", state)

    def free_state(self, saved: SavedState) -> None:
        """Free a saved state."""
        self.fmu.do("FreeFMUstate", ctypes.byref(saved[1]))
