"""Simulating one program in this process.

`simulate` integrates a Program (or a Model, or a model file) with its inputs held at their start
values. Imports `program`, `runtime`, `multibody`. Start with `simulation`.
"""

from m4e_fmi.simulate.simulation import Simulation, simulate, started

__all__ = ["Simulation", "simulate", "started"]
