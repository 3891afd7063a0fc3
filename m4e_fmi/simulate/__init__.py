"""Simulating one program in this process.

`simulate` integrates a Program (or a Model, or a model file) with its inputs held at their start
values, and audits its energy. Imports `program`, `runtime`, `multibody`. Start with `simulation`,
then `audit`. The package itself can be called as `simulate` is: ``m4e_fmi.simulate(model, …)``.
"""

from m4e_fmi.lazy import as_verb
from m4e_fmi.runtime.engine import Watch
from m4e_fmi.simulate.audit import EnergyAudit
from m4e_fmi.simulate.simulation import Event, Simulation, SimulationError, simulate
from m4e_fmi.simulate.start import started

__all__ = [
    "EnergyAudit",
    "Event",
    "Simulation",
    "SimulationError",
    "Watch",
    "simulate",
    "started",
]

__doc__ = simulate.__doc__


as_verb(__name__, simulate)
