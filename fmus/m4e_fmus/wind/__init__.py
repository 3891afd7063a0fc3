"""FMU of wind on points of bodies: `kind: wind`. Equations and variables: README.md here."""

from __future__ import annotations

from m4e_adapters.wind import WindConfig, wind_program
from m4e_fmi.fmu import FmuKind

KIND = FmuKind(WindConfig, build=lambda config, name, **_: wind_program(config, name=name))
