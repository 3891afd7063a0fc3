"""Wind forces on points of bodies: `kind: wind`. Start reading in `program`."""

from m4e_adapters.wind.config import WindConfig
from m4e_adapters.wind.program import wind_program

__all__ = ["WindConfig", "wind_program"]
