"""Base of every Python slave: what PythonFMU's own base leaves open.

Variables live in one list of floats, read and written by value reference. No exception ever leaves
this class, because the binary turns each into fmi2Fatal and the host may crash after it: an error
is kept, logged, readable as the string variable `last_error`; outputs then read as nan and every
later step answers fmi2Discard.
"""

from __future__ import annotations

import base64
import copy
import json
import sys
import traceback
from binascii import crc32
from collections.abc import Callable
from math import inf, isfinite, nan
from pathlib import Path
from typing import Any, TypeVar

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

if sys.version_info < (3, 10):  # noqa: UP036  not the version that builds
    raise ImportError(f"this FMU needs Python 3.10 or newer; here is {sys.version.split()[0]}")

DESCRIPTION = "description.json"
LAST_ERROR = "last_error"
IDENTITY = __package__
"""Of states: the package's name ends in a hash of the FMU's code, variables and data."""
CHECKSUM = 8  # hexadecimal digits before a state as bytes
Saved = dict[str, Any]
"""JSON values and, of a state, bytes, by name."""
_T = TypeVar("_T")
_KEPT = ("text", "time", "tolerance", "_error", "_initialised", "_initialising", "_premature",
         "_stale", "_terminated")  # fmt: skip
"""Attributes that a state has, besides the values."""


class M4eSlave(Fmi2Slave):
    """Override `initialise`, `step`, `update`, `save`, `restore`, `finish`; raise on failure.

    Available to them: `values` (list of floats by value reference), `index` (name → value
    reference), `text` (string variables by name), `resources` (folder of the data files), `time`
    [s], `tolerance` (relative, None if the importer gave none).
    """

    def __init__(self, **kwargs: str) -> None:
        super().__init__(**kwargs)
        # not Path(__file__): in a second instance that is the first one's folder, perhaps deleted
        self.resources = Path(kwargs["resources"]) / Path(__file__).parent.name
        description = json.loads((self.resources / DESCRIPTION).read_text(encoding="utf-8"))
        self.values = [variable["start"] for variable in description["reals"]]
        self.index = {variable["name"]: k for k, variable in enumerate(description["reals"])}
        self.text = {variable["name"]: variable["start"] for variable in description["strings"]}
        self._strings = [variable["name"] for variable in description["strings"]]
        self._names = [variable["name"] for variable in description["reals"]]
        self._limits = {
            k: (variable.get("minimum", -inf), variable.get("maximum", inf))
            for k, variable in enumerate(description["reals"])
            if "minimum" in variable or "maximum" in variable
        }
        settable = [variable["settable"] for variable in description["reals"]]
        self._closed = {k for k, always in enumerate(settable) if not always}
        self.time = 0.0
        self._stop = inf
        self.tolerance: float | None = None
        self._error = ""
        self._initialised = False
        self._initialising = False
        self._premature = False  # the error was met during initialization, with inputs yet to come
        self._stale = True
        self._terminated = False
        self._finished = False

    def initialise(self) -> None:
        """Make the state fit parameters and inputs; may be called again before the first step."""

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h [s] with the inputs as they are set."""

    def update(self) -> None:
        """Write the outputs into `values` from the state and the inputs."""

    def save(self) -> Saved:
        """The internal state as a dict of JSON values and bytes, also before `initialise`."""
        return {}

    def restore(self, saved: Saved) -> None:
        """Take back what `save` returned."""

    def finish(self) -> None:
        """Release all resources; called once, by terminate or when the instance is freed."""

    def _guard(self, action: Callable[..., None], *arguments: object) -> bool:
        """Run one of the methods above; False, and the error kept, if it raises."""
        if self._error:
            return False
        try:
            action(*arguments)
        except BaseException as error:  # noqa: BLE001  SystemExit, too, would end the host
            self._fail(f"{type(error).__name__}: {error}", traceback.format_exc())
        return not self._error

    def _fail(self, message: str, detail: str = "") -> None:
        """Keep the error, unless there is one already: the first is the cause of the others."""
        if not self._error:
            self._error = _printable(f"{message} (t = {self.time:.9g} s)")
            self.log(f"{self.instance_name}: {self._error}", status=Fmi2Status.error)
            if detail:
                self.log(detail)

    def log(
        self,
        msg: str,
        status: Fmi2Status = Fmi2Status.ok,
        category: str | None = None,
        debug: bool | None = None,
    ) -> None:
        """Queue a message for the importer."""
        # the binary uses the text as a printf format
        super().log(_printable(msg).replace("%", "%%"), status, category, debug)

    def _allowed(self, function: str, now: bool) -> None:
        """Fail unless `function` may be called now; the binary knows no phases."""
        if not now:
            self._fail(f"{function} cannot be called now")

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Keep the times [s] and the relative tolerance of the experiment."""
        self._allowed("fmi2SetupExperiment", not (self._initialising or self._initialised))
        self.time = start_time
        self._stop = inf if stop_time is None else stop_time
        self.tolerance = tolerance

    def enter_initialization_mode(self) -> None:
        """Enter initialization mode, in which inputs are set and outputs read."""
        fresh = not (self._initialising or self._initialised)
        self._allowed("fmi2EnterInitializationMode", fresh)
        self._initialising = True

    def exit_initialization_mode(self) -> None:
        """Exit initialization mode, with state and outputs computed."""
        self._allowed("fmi2ExitInitializationMode", self._initialising)
        self._refresh()
        self._premature = False
        self._initialising = False
        self._initialised = True

    def _refresh(self) -> None:
        """Bring the outputs up to date with what was set or stepped."""
        if not self._stale:
            return
        if self._premature:
            self._error, self._premature = "", False
        failed_before = bool(self._error)
        if not self._initialised:
            self._guard(self.initialise)
        self._guard(self.update)
        self._premature = self._initialising and bool(self._error) and not failed_before
        self._stale = False

    def do_step(self, current_time: float, step_size: float) -> bool:
        """True if the step from `current_time` over `step_size` [s] was made."""
        self._allowed("fmi2DoStep", self._initialised and not self._terminated)
        if not 0 < step_size < inf:
            self._fail(f"no step from {current_time} s over {step_size} s")
        elif current_time + step_size > self._stop + 1e-6 * step_size + 1e-12 * abs(current_time):
            self._fail(f"a step over {step_size} s, but the stop time is {self._stop} s")
        self.time = current_time
        if self._guard(self.step, current_time, step_size):
            self.time = current_time + step_size
        self._stale = True
        return not self._error

    def terminate(self) -> None:
        """End the simulation and release all resources."""
        self._allowed("fmi2Terminate", self._initialised and not self._terminated)
        if self._initialised:
            self._refresh()  # outputs may be read after this
        self._terminated = True
        self._finish()

    def __del__(self) -> None:
        self._finish()

    def _finish(self) -> None:
        if getattr(self, "_finished", True):  # not there: __init__ failed
            return
        self._finished = True
        try:
            self.finish()
        except BaseException as error:  # noqa: BLE001  as in _guard; the run is over, only tell
            self.log(f"{self.instance_name}: while finishing: {error}", status=Fmi2Status.warning)

    def get_real(self, vrs: list[int]) -> list[float]:
        """Values of real variables, computed anew if inputs have changed; nan after an error."""
        if self._stale and (self._initialised or self._initialising):
            self._refresh()
        if self._error:
            return [nan] * len(vrs)
        values = self.values
        try:
            return [float(values[vr]) for vr in vrs]
        except IndexError:
            return self._unknown(vrs, nan)
        except TypeError as error:  # the binary would leave it to the host
            self._fail(f"an output is no number: {error}")
            return [nan] * len(vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set real variables; values must be finite and in their ranges."""
        self._stale = True
        if self._terminated:
            self._allowed("fmi2SetReal", False)
        elif self._initialised and not self._closed.isdisjoint(vrs):
            name = self._names[min(self._closed.intersection(vrs))]
            self._fail(f"{name} cannot be set after initialization")
        try:
            for vr, value in zip(vrs, values, strict=True):
                self.values[vr] = value
        except IndexError:
            self._unknown(vrs, nan)
            return
        if all(map(isfinite, values)) and self._limits.keys().isdisjoint(vrs):
            return
        for vr, value in zip(vrs, values, strict=True):
            if not isfinite(value):
                self._fail(f"{self._names[vr]} was set to {value}")
            low, high = self._limits.get(vr, (value, value))
            if not low <= value <= high:
                where = f"outside its range from {low:g} to {high:g}"
                self._fail(f"{self._names[vr]} was set to {value:g}, {where}")

    def get_string(self, vrs: list[int]) -> list[str]:
        """Values of string variables."""
        self.text[LAST_ERROR] = self._error
        try:
            return [self.text[self._strings[vr]] for vr in vrs]
        except IndexError:
            return self._unknown(vrs, "")

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Set string variables."""
        self._stale = True
        try:
            for vr, value in zip(vrs, values, strict=True):
                self.text[self._strings[vr]] = value
        except IndexError:
            self._unknown(vrs, "")

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Fails: there are no integers."""
        return self._unknown(vrs, 0)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Fails: there are no Booleans."""
        return self._unknown(vrs, False)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:  # noqa: ARG002
        """Fails: there are no integers."""
        self._unknown(vrs, 0)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:  # noqa: ARG002
        """Fails: there are no Booleans."""
        self._unknown(vrs, False)

    def _unknown(self, vrs: list[int], answer: _T) -> list[_T]:
        """Fail because no variable of this type has one of these value references."""
        if vrs:
            self._fail(f"not all of these are value references of the type: {list(vrs)}")
        return [answer] * len(vrs)

    def _get_fmu_state(self) -> Saved:
        own: Saved = {}
        self._guard(lambda: own.update(copy.deepcopy(self.save())))
        return {
            "identity": IDENTITY,
            "values": list(self.values),
            **{name: copy.copy(getattr(self, name)) for name in _KEPT},
            "own": own,
        }

    def _set_fmu_state(self, state: Saved) -> None:
        # the stop time stays that of this instance: a state may be one of a shorter run
        if state.get("identity") != IDENTITY:
            self._fail("a state was set that is damaged or not of this FMU")
            return
        self.values[:] = state["values"]
        for name in _KEPT:
            setattr(self, name, copy.copy(state[name]))
        self._guard(self.restore, copy.deepcopy(state["own"]))

    @staticmethod
    def _fmu_state_to_bytes(state: Saved) -> bytes:
        try:
            text = json.dumps(state, default=_encoded, sort_keys=True)
        except (TypeError, ValueError) as error:  # what is restored from this, tells
            text = json.dumps({**state, "own": {}, "_error": f"the state was not saved: {error}"})
        content = text.encode("utf-8")
        return _checksum(content) + content

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> Saved:
        checksum, content = state[:CHECKSUM], state[CHECKSUM:]
        if checksum != _checksum(content):
            return {}  # there is no instance here to keep an error: it is told when this is set
        return json.loads(content.decode("utf-8"), object_hook=_decoded)


def _checksum(content: bytes) -> bytes:
    return f"{crc32(content):0{CHECKSUM}x}".encode("ascii")


def _printable(text: str) -> str:
    """`text` as the binary can pass it on: UTF-8 without lone surrogates."""
    return str(text).encode("utf-8", "backslashreplace").decode("utf-8")


def _encoded(value: object) -> dict[str, str]:
    if isinstance(value, bytes):
        return {"base64": base64.b64encode(value).decode("ascii")}
    raise TypeError(f"{type(value).__name__} cannot be saved; use JSON values and bytes")


def _decoded(value: Saved) -> Saved | bytes:
    return base64.b64decode(value["base64"]) if set(value) == {"base64"} else value
