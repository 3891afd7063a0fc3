"""Failures of FMUs: errors, and explanations in the FMU's own words."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.calls import (
    DISCARD,
    EARLY,
    ERROR,
    FATAL,
    RESTLESS,
    Access,
    Standard,
    Status,
)
from m4e_fmi.fmu.importer.messages import STATUS, Messages
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Worker

LAST_ERROR = "last_error"
"""Name of the string variable in which an FMU may explain an error."""
KEEP = (
    "; in its process it has few variables of the environment: name those that it needs under "
    "`environment: {keep: […]}` of the system"
)
"""Remedy for FMUs that cannot begin in a process of their own."""
ANSWERS = {**STATUS, 5: "Pending", EARLY: "an event", RESTLESS: "events without end"}
"""Texts of statuses."""


class DiscardedError(RunError):
    """An FMU discarded a step; `reached` is the time [s] up to which it could, None if not told.

    `component` is its name, `size` that of the step [s].
    """

    def __init__(
        self, message: str, remedy: str, reached: float | None, component: str, size: float
    ) -> None:
        super().__init__(message, remedy)
        self.reached, self.component, self.size = reached, component, size


class EventWithinError(DiscardedError):
    """An FMU has an event within the step, at `reached`."""


class EndWithinError(DiscardedError):
    """An FMU asked for the end of the simulation within the step, at `reached`."""


class LostError(RunError):
    """The process of an FMU is gone."""


class WarnedSteps(ctypes.Structure):
    """`m4e_warned` of loop.h: steps answered with Warning; when [s] the first and last began."""

    _fields_ = [("count", ctypes.c_uint64), ("first", ctypes.c_double), ("last", ctypes.c_double)]


def failed_step(time: float, size: float) -> str:
    """Text about a step of `size` [s] from `time` [s] that failed."""
    begin, end = f"{time:.9g} s", f"{time + size:.9g} s"
    if begin == end:
        return f"a step of {size:.3g} s from t = {begin} failed"
    return f"the step from t = {begin} to {end} failed"


def worker_lost(origin: str, when: str, worker: Worker, further: str) -> LostError:
    """The error of an FMU, `origin`, whose process is gone; `when` says at what time, or step.

    `further` is a remedy beside that which follows from the process's ending.
    """
    words = f": {worker.words}" if worker.words else ""
    message = f"{origin}: {when}: its process {worker.ending} in {worker.call}{words}"
    return LostError(message, _remedy(worker) + further)


def _remedy(worker: Worker) -> str:
    """Remedy for an FMU whose process is gone, the likeliest first."""
    if "return" in worker.ending:
        return "give it more time (`limits` of the system), or look for what it waits for"
    if "SIGKILL" in worker.ending:
        return (
            "an FMU seldom does that itself: the system may have been out of memory, or somebody "
            "ended the process"
        )
    remedy = "the FMU is faulty: `m4e-fmi validate` on the file tells more"
    if worker.host.memory is None:
        return remedy
    limit = f"{worker.host.memory / 1e6:g} MB"
    return f"it may have met its limit of memory, {limit} (`limits` of the system); else {remedy}"


def value_out_of_range(
    description: Description, component: str, when: str, access: Access, cells: np.ndarray
) -> RunError:
    """The error of an access to `cells` (n_cells,), int64 codes: one does not fit its input."""
    name, taken = access.names[access.failed], access.taken[access.failed]
    variable = description.variables[name]
    cell = int(cells[taken.source])
    given = cell % 2**64 if taken.large else cell
    kind = variable.fmi_type + (f" ({', '.join(variable.items)})" if variable.items else "")
    return RunError(
        f"{taken.origin} {when} is {given}, which {component}.{name} cannot store: it is of "
        f"type {kind}, here from {taken.low} to {taken.high}",
        "keep the value in that range, or connect another input",
    )


class Explanation:
    """Explanation of a failure by the FMU itself, which logs under `told_name`."""

    def __init__(
        self, description: Description, fmu: Standard, messages: Messages, told_name: str
    ) -> None:
        self._description, self._fmu = description, fmu
        self._messages, self._told_name = messages, told_name

    def words(self, status: Status = FATAL) -> str:
        """The FMU's words on a failure with this status, to stand behind our own message.

        Where they begin with a variable, as in ``f is inf``, its description comes after them.
        """
        text = self.last_error() if status in (DISCARD, ERROR) else ""
        text = (text or self._messages.last()).removeprefix(f"{self._told_name}: ")
        variable = self._description.variables.get(text.partition(" is ")[0])
        told = f" ({variable.description})" if variable and variable.description else ""
        return f": {text}{told}" if text else ""

    def last_error(self) -> str:
        """The text of the variable `last_error`; empty where the FMU has none."""
        variable = self._description.variables.get(LAST_ERROR)
        if variable is None or variable.type != "String":
            return ""
        return self._fmu.text(variable)

    @property
    def asks_for_end(self) -> bool:
        """True if the step was discarded by an FMU that is done, and not by one that has failed.

        PythonFMU's library has no other answer to a step that fails but to ask for the end, or
        Fatal, after which nothing can be asked: that it has failed, its FMU can say in words only.
        """
        return self._fmu.wants_end() and not self.last_error()

    def not_finite(
        self, component: str, when: str, names: Sequence[str], values: np.ndarray
    ) -> RunError:
        """The error of the first of the outputs `names` whose value is nan or infinite.

        `component` is the FMU's name in the system; `values` (n_names,) are in the FMU's units.
        """
        name, value = next(
            (n, v) for n, v in zip(names, values, strict=True) if not math.isfinite(v)
        )
        what = self._description.variables[name].description
        told = f" ({what})" if what else ""
        message = f"{component}.{name} {when} is {value}{told}{self.words(DISCARD)}"
        remedy = (
            "try a smaller step_size; check parameters and start values; an output that nobody "
            "takes may be left out of the results (--variables)"
        )
        if self.last_error() or self._messages.tell_why:
            remedy = f"fix the problem stated by the FMU first; otherwise {remedy}"
        return RunError(message, remedy)

    def step_remedy(self, status: Status, size: float, *, first_step: bool) -> str:
        """Remedy for a step of `size` [s] that has failed, the likeliest first."""
        reason = self._messages.tell_why or (status in (DISCARD, ERROR) and self.last_error())
        own = (
            f"if {size:g} s is not the step that it was made for, give the component that as its "
            "own step_size"
        )
        first = "fix the problem stated by the FMU first"
        if self._description.constant_step:
            only = f"it accepts one step size only: {own}"
            return f"{first}; {only}" if reason else only
        if reason and status != DISCARD:
            return f"{first}; {own}" if first_step else first
        smaller = f"try a step_size below {size:g} s, or other parameters and start values"
        return f"{first}; else {smaller}" if reason else f"{smaller}; {own}"
