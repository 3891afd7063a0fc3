"""Wind forces on points of bodies: `kind: wind`. Start reading in `program`."""

from m4e_adapters.wind.program import WindConfig, wind_program

__all__ = ["WindConfig", "wind_program"]
