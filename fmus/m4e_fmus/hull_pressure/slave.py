"""Slave of the hull_pressure FMU: the pressure of the water on hulls, at their present pose."""

import json

from pythonfmu.enums import Fmi2Status

from .hull_load import HullOutputs  # type: ignore  # side by side in the FMU
from .slave_base import M4eSlave  # type: ignore


class HullPressureSlave(M4eSlave):
    """Hulls as `hulls.json` says. They have no state: outputs follow time and pose."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        data = json.loads((self.resources / "hulls.json").read_text(encoding="utf-8"))
        self._hulls = HullOutputs(data)

    def step(self, t, h):  # noqa: ARG002
        """Nothing advances; what is odd is told once."""
        for text in self._hulls.doubts(t):
            self.log(f"{self.instance_name}: {text}", status=Fmi2Status.warning)

    def update(self):
        """Set the outputs for the present pose and time."""
        given = {name: self.values[k] for name, k in self.index.items()}
        for name, value in self._hulls.at(given, self.time).items():
            self.values[self.index[name]] = value
