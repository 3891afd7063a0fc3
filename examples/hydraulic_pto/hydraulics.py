"""A hydraulic power take-off in one file."""

import math


class HydraulicPto:
    """A rod pumps oil into a gas accumulator, which drives a motor."""

    parameters = {
        "area": (0.02, "m2", "area of the piston"),
        "gas_volume": (0.2, "m3", "volume of the gas without oil"),
        "charge_pressure": (5.0e6, "Pa", "pressure of the gas without oil"),
        "conductance": (2.4e-9, "m3/(s.Pa)", "flow of the motor per pressure"),
        "opening_speed": (0.1, "m/s", "speed of the rod at which the valves open"),
    }
    inputs = {"rod.vz": "m/s"}
    outputs = {"rod.force_z": ("N", "force on the body"), "pressure": "Pa", "power": "W"}
    states = {"oil": (0.0, "m3"), "energy": (0.0, "J")}

    def pressure(self, v):
        squeezed = v.gas_volume / (v.gas_volume - v.oil)
        return v.charge_pressure * (squeezed**1.4 - 1)

    def valves(self, v):
        return v.rod.vz / math.sqrt(v.rod.vz**2 + v.opening_speed**2)

    def rates(self, t, v):
        pumped = v.area * v.rod.vz * self.valves(v)
        flow = v.conductance * self.pressure(v)
        return {"oil": pumped - flow, "energy": flow * self.pressure(v)}

    def calculate(self, t, v):
        p = self.pressure(v)
        force = -v.area * p * self.valves(v)
        return {"rod.force_z": force, "pressure": p, "power": v.conductance * p**2}
