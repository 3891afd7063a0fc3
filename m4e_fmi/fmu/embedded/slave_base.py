"""Base of every Python slave: what PythonFMU's own base leaves open.

Variables live in one list of floats, read and written by value reference. No exception ever leaves
this class, because the binary turns each into fmi2Fatal and the host may crash after it: an error
is kept, logged, readable as the string variable `last_error`; outputs then read as nan and every
later step answers fmi2Discard.
"""

import base64
import json
import traceback
from math import isfinite, nan
from pathlib import Path

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

DESCRIPTION = "description.json"
LAST_ERROR = "last_error"


class M4eSlave(Fmi2Slave):
    """Override `initialise`, `step`, `update`, `save`, `restore`, `finish`; raise on failure.

    Available to them: `values` (list of floats by value reference), `index` (name → value
    reference), `text` (string variables by name), `resources` (folder of the data files), `time`
    [s], `tolerance` (relative, None if the importer gave none).
    """

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        # not Path(__file__): in a second instance that is the first one's folder, perhaps deleted
        self.resources = Path(kwargs["resources"]) / Path(__file__).parent.name
        description = json.loads((self.resources / DESCRIPTION).read_text(encoding="utf-8"))
        self.values = [variable["start"] for variable in description["reals"]]
        self.index = {variable["name"]: k for k, variable in enumerate(description["reals"])}
        self.text = {variable["name"]: variable["start"] for variable in description["strings"]}
        self._strings = [variable["name"] for variable in description["strings"]]
        self._names = [variable["name"] for variable in description["reals"]]
        self.time = 0.0
        self.tolerance = None
        self._error = ""
        self._initialised = False
        self._initialising = False
        self._stale = True

    def initialise(self):
        """Make the state fit parameters and inputs; may be called again before the first step."""

    def step(self, t, h):
        """Advance from t to t + h [s] with the inputs as they are set."""

    def update(self):
        """Write the outputs into `values` from the state and the inputs."""

    def save(self):
        """The internal state as a dict of JSON values and bytes."""
        return {}

    def restore(self, saved):
        """Take back what `save` returned."""

    def finish(self):
        """Release what is held; called once, also after an error."""

    def _guard(self, action, *arguments):
        """Run one of the methods above; False, and the error kept, if it raises."""
        if self._error:
            return False
        try:
            action(*arguments)
        except Exception as error:  # noqa: BLE001  an exception here would end the host's process
            self._fail(f"{type(error).__name__}: {error}", traceback.format_exc())
        return not self._error

    def _fail(self, message, detail=""):
        self._error = f"{message} (t = {self.time:.9g} s)"
        self.log(f"{self.instance_name}: {self._error}\n{detail}", status=Fmi2Status.error)

    def log(self, msg, status=Fmi2Status.ok, category=None, debug=None):
        # the binary uses the text as a printf format
        super().log(str(msg).replace("%", "%%"), status, category, debug)

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):  # noqa: ARG002
        self.time = start_time
        self.tolerance = tolerance

    def enter_initialization_mode(self):
        self._initialising = True

    def exit_initialization_mode(self):
        self._refresh()
        self._initialising = False
        self._initialised = True

    def _refresh(self):
        """Bring the outputs up to date with what was set or stepped."""
        if not self._stale:
            return
        if not self._initialised:
            self._guard(self.initialise)
        self._guard(self.update)
        self._stale = False

    def do_step(self, current_time, step_size):
        self.time = current_time
        if self._guard(self.step, current_time, step_size):
            self.time = current_time + step_size
        self._stale = True
        return not self._error

    def terminate(self):
        self._finish()

    def _finish(self):
        try:
            self.finish()
        except Exception as error:  # noqa: BLE001  as in _guard; the run is over, only tell
            self.log(f"{self.instance_name}: while finishing: {error}", status=Fmi2Status.warning)

    def get_real(self, vrs):
        if self._stale and (self._initialised or self._initialising):
            self._refresh()
        if self._error:
            return [nan] * len(vrs)
        values = self.values
        return [values[vr] for vr in vrs]

    def set_real(self, vrs, values):
        for vr, value in zip(vrs, values, strict=True):
            if not isfinite(value):
                self._fail(f"{self._names[vr]} was set to {value}")
            self.values[vr] = value
        self._stale = True

    def get_string(self, vrs):
        self.text[LAST_ERROR] = self._error
        return [self.text[self._strings[vr]] for vr in vrs]

    def set_string(self, vrs, values):
        for vr, value in zip(vrs, values, strict=True):
            self.text[self._strings[vr]] = value
        self._stale = True

    def _get_fmu_state(self):
        return {
            "values": list(self.values),
            "text": dict(self.text),
            "time": self.time,
            "tolerance": self.tolerance,
            "error": self._error,
            "phase": [self._initialised, self._initialising, self._stale],
            "own": self.save(),
        }

    def _set_fmu_state(self, state):
        self.values[:] = state["values"]
        self.text = dict(state["text"])
        self.time = state["time"]
        self.tolerance = state["tolerance"]
        self._error = state["error"]
        self._initialised, self._initialising, self._stale = state["phase"]
        self._guard(self.restore, state["own"])

    @staticmethod
    def _fmu_state_to_bytes(state):
        return json.dumps(state, default=_encoded, sort_keys=True).encode("utf-8")

    @staticmethod
    def _fmu_state_from_bytes(state):
        return json.loads(bytes(state).decode("utf-8"), object_hook=_decoded)


def _encoded(value):
    if isinstance(value, bytes):
        return {"base64": base64.b64encode(value).decode("ascii")}
    raise TypeError(f"{type(value).__name__} cannot be saved; use JSON values and bytes")


def _decoded(value):
    return base64.b64decode(value["base64"]) if set(value) == {"base64"} else value
