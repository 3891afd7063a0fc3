"""What a system file says of a hydraulic power take-off, and what its FMUs say of themselves."""

from typing import Annotated

from pydantic import Field

from m4e_fmi.files.document import Section

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


class Config(Section):
    """The keys of a component besides `kind` and `start`; units are those of `PARAMETERS`."""

    rod: Name
    area: Positive
    gas_volume: Positive
    charge_pressure: Positive
    conductance: Positive
    opening_speed: Positive = 0.1


PARAMETERS = {
    "area": ("m2", "area of the piston"),
    "gas_volume": ("m3", "volume of the gas without oil"),
    "charge_pressure": ("Pa", "pressure of the gas without oil"),
    "conductance": ("m3/(s.Pa)", "flow of the motor per pressure"),
    "opening_speed": ("m/s", "speed of the rod at which the valves open"),
}
STATES = {
    "oil": ("m3", "oil in the accumulator"),
    "energy": ("J", "energy that the motor has delivered"),
}
OUTPUTS = {
    "pressure": ("Pa", "pressure of the oil"),
    "power": ("W", "power that the motor delivers"),
}
TUNABLE = "conductance"
SPEED = "vz", "m/s", "velocity of the rod, up"
FORCE = "force_z", "N", "force on the body at the rod, up"
