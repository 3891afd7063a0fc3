"""Slave of a component in one Python file: the user's object, its state and its integration."""

import json
import math

from .saved_values import CannotBeSavedError, decoded, encoded  # in the FMU
from .slave_base import M4eSlave  # type: ignore
from .user_class import Declared, UserClass, UserCodeError, Values, loaded

TOLERANCE = 1e-8
SMALLEST = 1e-9  # size of a state that counts


class PythonFileSlave(M4eSlave):
    """`component.json` says which file and which variables; states are integrated by SciPy."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        data = json.loads((self.resources / "component.json").read_text(encoding="utf-8"))
        parameters, inputs, outputs, states = (
            {v["name"]: Declared(**v) for v in data["variables"][group]}
            for group in ("parameters", "inputs", "outputs", "states")
        )
        self._held_outputs, self._calculated = (outputs, {}) if data["holds"] else ({}, outputs)
        self._states = states
        self._elements = [name for v in states.values() for name in v.elements]
        self._seen = Values({**parameters, **inputs, **states})
        self._path, self._shown = self.resources / "user" / data["file"], data["file"]
        self._begin()

    def _begin(self):
        module = loaded(self._path, self._shown, f"{__package__}.{self._path.stem}")
        self._user = UserClass(module, self._path, self._shown)
        self._held = {name: 0.0 for v in self._held_outputs.values() for name in v.elements}
        self._sizes = [0.0] * len(self._elements)  # of the states so far

    def _values(self, changed=()):
        found = {name: self.values[k] for name, k in self.index.items()}
        found.update(changed)
        return self._seen.filled(found)

    def _hold(self, method, returned):
        """Keep the outputs that a step or the start has returned."""
        if self._held_outputs:
            found = self._user.taken(method, returned, self._held_outputs)
            self._held = self._checked(method, found)
        elif returned is not None:
            place = f"{self._shown}:{self._user.line(method)}"
            raise UserCodeError(f"{place}: {method} returns outputs, but calculate has them")

    def initialise(self):
        """A fresh object, which sees parameters and inputs."""
        self._begin()
        if self._user.has("start"):
            returned = self._user.called(self._user.object.start, self._values())
            if returned is not None:
                self._hold("start", returned)

    def step(self, t, h):
        """Let the user's object make the step, or integrate its rates over it."""
        if self._user.has("step"):
            self._hold("step", self._user.called(self._user.object.step, t, h, self._values()))
        elif self._states:
            self._integrate(t, h)

    def _integrate(self, t, h):
        import numpy as np
        from scipy.integrate import solve_ivp

        def rates(time, x):
            values = self._values(zip(self._elements, x.tolist(), strict=True))
            found = self._checked("rates", self._user.results("rates", self._states, time, values))
            return [found[name] for name in self._elements]

        x = [self.values[self.index[name]] for name in self._elements]
        moved = [h * rate for rate in rates(t, np.array(x))]
        sizes = zip(self._sizes, x, moved, strict=True)
        self._sizes = [max(size, abs(a), abs(b)) for size, a, b in sizes]
        tolerance = self.tolerance or TOLERANCE
        absolute = [tolerance * max(size, SMALLEST) for size in self._sizes]
        solved = solve_ivp(rates, (t, t + h), x, method="LSODA", rtol=tolerance, atol=absolute)
        if not solved.success:
            raise UserCodeError(f"{self._shown}:{self._user.line('rates')}: {solved.message}")
        for name, value in zip(self._elements, solved.y[:, -1].tolist(), strict=True):
            self.values[self.index[name]] = value

    def update(self):
        """Set the outputs for the present time, inputs and states."""
        found = dict(self._held)
        if self._calculated:
            returned = self._user.results("calculate", self._calculated, self.time, self._values())
            found |= self._checked("calculate", returned)
        for name, value in found.items():
            self.values[self.index[name]] = value

    def _checked(self, method, found):
        """`found` as finite floats."""
        for name, value in found.items():
            try:
                found[name] = float(value)
            except (TypeError, ValueError):
                found[name] = math.nan
            if not math.isfinite(found[name]):
                place = f"{self._shown}:{self._user.line(method)}"
                raise UserCodeError(f"{place}: {method} returns {value!r} for {name}")
        return found

    def save(self):
        """The attributes of the user's object; states and outputs are among the values."""
        user = self._user
        try:
            if user.has("save"):
                own = encoded(user.called(user.object.save), "what save() returns")
            else:
                own = {
                    key: encoded(value, f"self.{key}") for key, value in vars(user.object).items()
                }
        except CannotBeSavedError as error:
            raise UserCodeError(f"{self._shown}: {error}") from error
        return {"object": own, "held": self._held, "sizes": self._sizes}

    def restore(self, saved):
        """Take it back."""
        own, user = decoded(saved["object"]), self._user
        self._held, self._sizes = saved["held"], saved["sizes"]
        if user.has("save"):
            user.called(user.object.restore, own)
        else:
            vars(user.object).clear()
            vars(user.object).update(own)
