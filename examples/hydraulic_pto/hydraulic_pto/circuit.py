"""The equations: a rod pumps oil into a gas accumulator, from which it drives a motor.

Every quantity is a scalar of any kind: a float, or what a Program records.
"""

from dataclasses import dataclass
from typing import Any

ADIABATIC = 1.4
"""Exponent of nitrogen that exchanges no heat."""


@dataclass(frozen=True)
class Circuit:
    """Area of the piston [m2], gas volume [m3] and pressure [Pa] of the accumulator without oil,
    flow of the motor per pressure [m3/(s.Pa)], speed at which the valves open [m/s].

    Pressures are differences to the other side of the piston. Speed and force are positive in one
    and the same direction; the force is that on the body at the rod.
    """

    area: Any
    gas_volume: Any
    charge_pressure: Any
    conductance: Any
    opening_speed: Any

    def pressure(self, oil: Any) -> Any:
        """Pressure [Pa] with `oil` [m3] in the accumulator: the gas is compressed by it."""
        squeezed = self.gas_volume / (self.gas_volume - oil)
        return self.charge_pressure * (squeezed**ADIABATIC - 1)

    def valves(self, speed: Any) -> Any:
        """The valves turn either direction of the rod into one: near -1 or 1, 0 at rest."""
        return speed / (speed * speed + self.opening_speed * self.opening_speed) ** 0.5

    def force(self, oil: Any, speed: Any) -> Any:
        """Force on the body [N]: it opposes the `speed` [m/s] of the rod."""
        return -self.area * self.pressure(oil) * self.valves(speed)

    def absorbed(self, oil: Any, speed: Any) -> Any:
        """Power [W] that the rod takes from the body."""
        return -self.force(oil, speed) * speed

    def delivered(self, oil: Any) -> Any:
        """Power [W] that the motor takes from the oil."""
        return self.conductance * self.pressure(oil) ** 2

    def oil_rate(self, oil: Any, speed: Any) -> Any:
        """Oil that the rod brings and the motor takes [m3/s]."""
        pumped = self.area * speed * self.valves(speed)
        return pumped - self.conductance * self.pressure(oil)
