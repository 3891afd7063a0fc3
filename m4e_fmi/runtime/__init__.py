"""What runs a program: the integrator, in plain Python.

The modules here use the standard library only, because they also travel inside FMUs. The room is
kept for the C library that will do the same faster. Start with `dormand_prince`.
"""

from m4e_fmi.runtime.dormand_prince import DormandPrince, IntegrationError

__all__ = ["DormandPrince", "IntegrationError"]
