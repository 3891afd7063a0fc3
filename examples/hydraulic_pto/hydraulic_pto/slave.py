"""What runs inside the Python FMU: variables to the solver and back. Imports nothing of m4e_fmi."""

from .accumulator import Accumulator
from .circuit import Circuit
from .slave_base import M4eSlave  # type: ignore  # side by side in the FMU

PARAMETERS = ("area", "gas_volume", "charge_pressure", "conductance", "opening_speed")


class HydraulicSlave(M4eSlave):
    """The oil in the accumulator is the state; `energy` goes along with it."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self._rod = (self.resources / "rod.txt").read_text(encoding="utf-8")
        self.initialise()  # a state may be asked for before the start

    def _get(self, name):
        return self.values[self.index[name]]

    def _circuit(self):
        return Circuit(**{name: self._get(name) for name in PARAMETERS})

    def initialise(self):
        self._accumulator = Accumulator(self._circuit(), self._get("oil"), self._get("energy"))

    def step(self, t, h):
        self._accumulator.circuit = self._circuit()  # the conductance may have been changed
        speed = self._get(f"{self._rod}.vz")
        self._accumulator.advance(t, h, speed, tolerance=self.tolerance or 1e-8)

    def update(self):
        circuit, oil = self._circuit(), self._accumulator.oil
        found = {
            "oil": oil,
            "energy": self._accumulator.energy,
            f"{self._rod}.force_z": circuit.force(oil, self._get(f"{self._rod}.vz")),
            "pressure": circuit.pressure(oil),
            "power": circuit.delivered(oil),
        }
        for name, value in found.items():
            self.values[self.index[name]] = value

    def save(self):
        return {"oil": self._accumulator.oil, "energy": self._accumulator.energy}

    def restore(self, saved):
        self._accumulator = Accumulator(self._circuit(), **saved)
