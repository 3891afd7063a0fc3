"""The undisturbed sea at points: elevation, velocity, acceleration and pressure of the water.

Waves are those of `m4e_adapters.hydrodynamics`: the same section gives the same sea. Start reading
in `program`; `config` has the keys.
"""

from m4e_adapters.sea.config import SeaConfig
from m4e_adapters.sea.program import sea_in_waves, sea_program

__all__ = ["SeaConfig", "sea_in_waves", "sea_program"]
