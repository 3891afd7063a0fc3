"""Quantities by their units: names for types, and units to show values in.

Names of quantities are those of the Modelica Standard Library, which importers know.
"""

from __future__ import annotations

from dataclasses import dataclass

from m4e_fmi.units import parse_unit


@dataclass(frozen=True)
class Quantity:
    """A quantity of `unit`; values may be shown in `displays`, and are in `shown` at first."""

    name: str
    unit: str
    displays: tuple[str, ...] = ()
    shown: str | None = None

    @property
    def type_name(self) -> str:
        """Name of the type in the model description."""
        return f"SI.{self.name}"  # no variable may have the name of a type: none begins like this


QUANTITIES = {
    q.unit: q
    for q in (
        Quantity("Length", "m", ("mm", "km")),
        Quantity("Velocity", "m/s", ("kn", "km/h")),
        Quantity("Acceleration", "m/s2"),
        Quantity("Angle", "rad", ("deg",), "deg"),
        Quantity("AngularVelocity", "rad/s", ("rpm", "deg/s"), "rpm"),
        Quantity("AngularAcceleration", "rad/s2", ("deg/s2",), "deg/s2"),
        Quantity("Mass", "kg", ("t",)),
        Quantity("MomentOfInertia", "kg.m2", ("t.m2",)),
        Quantity("Force", "N", ("kN", "MN"), "kN"),
        Quantity("Torque", "N.m", ("kN.m", "MN.m"), "kN.m"),
        Quantity("TranslationalSpringConstant", "N/m", ("kN/m",)),
        Quantity("RotationalSpringConstant", "N.m/rad", ("kN.m/rad", "N.m/deg")),
        Quantity("TranslationalDampingConstant", "N.s/m", ("kN.s/m",)),
        Quantity("RotationalDampingConstant", "N.m.s/rad", ("kN.m.s/rad",)),
        Quantity("Energy", "J", ("kJ", "MJ", "kW.h")),
        Quantity("Power", "W", ("kW", "MW")),
        Quantity("Time", "s", ("min", "h")),
        Quantity("Frequency", "Hz"),
    )
}


def display_factor(unit: str, display: str) -> float:
    """Value in `display` = this · value in `unit`: FMI 2.0.4, section 2.2.2."""
    return parse_unit(unit).factor / parse_unit(display).factor
