"""Slave of the hull_pressure FMU: the pressure of the water on hulls, at their present pose."""

import json

from pythonfmu.enums import Fmi2Status

from .hull_load import HullLoad  # type: ignore  # side by side in the FMU
from .incident_waves import IncidentWaves  # type: ignore
from .slave_base import M4eSlave  # type: ignore

PLANE, SPACE = (0, 2, 4), range(6)  # of force_x, _y, _z, moment_x, _y, _z
FORCES = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")


class HullPressureSlave(M4eSlave):
    """Hulls as `hulls.json` says. They have no state: outputs follow time and pose."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        data = json.loads((self.resources / "hulls.json").read_text(encoding="utf-8"))
        self._bodies, self._depth, self._told = data["bodies"], data["depth"], set()
        self._last = {}  # loads at the outputs that were read last
        self._motions = PLANE if data["dimensions"] == 2 else SPACE
        self._waves = IncidentWaves(data["waves"]) if data["waves"] else None
        self._hulls = {
            body["name"]: HullLoad(
                body["vertices"], body["triangles"], weight=data["weight"], waves=self._waves
            )
            for body in self._bodies
        }

    def _load(self, body):
        """The load on a body at its present pose."""
        known = {"y": body["y"], "phi": 0.0, "psi": 0.0}
        pose = [
            self.values[self.index[name]] if (name := f"{body['name']}.{key}") in self.index
            else known[key]
            for key in ("x", "y", "z", "phi", "theta", "psi")
        ]  # fmt: skip
        return self._hulls[body["name"]].at(pose[:3], pose[3:], self.time)

    def step(self, t, h):  # noqa: ARG002
        """Nothing advances; a hull that has left the water or touches the bed is told once."""
        for name, load in self._last.items():
            if load.wetted_volume <= 0.0:
                text = f"{name} is wholly out of the water (t = {t:.4g} s): no force on it"
                self._tell(f"{name} dry", text)
            if load.lowest < -self._depth:
                text = (
                    f"{name} reaches down to z = {load.lowest:.4g} m (t = {t:.4g} s), below the "
                    f"sea bed at z = {-self._depth:.4g} m: the bed exerts no force on it"
                )
                self._tell(f"{name} aground", text)

    def _tell(self, what, text):
        if what not in self._told:
            self._told.add(what)
            self.log(f"{self.instance_name}: {text}", status=Fmi2Status.warning)

    def update(self):
        """Set the outputs for the present pose and time."""
        for body in self._bodies:
            name = body["name"]
            load = self._last[name] = self._load(body)
            whole = load.hydrostatic + load.froude_krylov
            self._set(f"{name}.neutral_mass", body["neutral_mass"])
            self._set(f"{name}.wetted_volume", load.wetted_volume)
            if self._waves:
                self._set(f"{name}.water_level", load.water_level)
            for k in self._motions:
                self._set(f"{name}.{FORCES[k]}", whole[k])
                self._set(f"{name}.hydrostatic_{FORCES[k]}", load.hydrostatic[k])
                if self._waves:
                    self._set(f"{name}.froude_krylov_{FORCES[k]}", load.froude_krylov[k])
        if self._waves:
            self._set("wave.elevation", self._waves.elevation([[0.0, 0.0]], self.time)[0])

    def _set(self, name, value):
        self.values[self.index[name]] = float(value)
