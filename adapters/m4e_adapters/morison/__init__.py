"""Slender members in waves and currents by Morison's equation, fixed or on moving bodies.

Waves and currents are those of `m4e_adapters.hydrodynamics`. Start reading in `program`; `config`
has the keys, `strips` the points of members, `loads` the forces there, `buoyancy` that of still
water, `added_mass` the inertia of the water that moves with a body, `waves` the response to waves.
"""

from m4e_adapters.morison.config import MorisonConfig
from m4e_adapters.morison.program import members_in_waves, morison_program

__all__ = ["MorisonConfig", "members_in_waves", "morison_program"]
