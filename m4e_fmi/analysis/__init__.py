"""Linear equations of a system about a point of its motion, and sensitivities.

`linearize` gives M, C, K and A, B, C, D from exact derivatives, `equilibrium` a point to do it at;
`modes` and `frequency_response` evaluate the linear equations. `sensitivity` and its kin give the
derivatives of outputs, eigenvalues and trajectories with respect to parameters. `Linearizer` and
`Sensitivities` do it at many points of one system.
Start with `points`, then `linearization`.
"""

from m4e_fmi.analysis.equilibrium import equilibrium
from m4e_fmi.analysis.linearization import Linearization, Linearizer, Mechanical, linearize
from m4e_fmi.analysis.modes import FrequencyResponse, Modes, frequency_response, modes
from m4e_fmi.analysis.points import OperatingPoint
from m4e_fmi.analysis.sensitivity import (
    EigenvalueSensitivity,
    Sensitivities,
    Sensitivity,
    eigenvalue_sensitivity,
    sensitivity,
)
from m4e_fmi.analysis.trajectory import TrajectorySensitivity, trajectory_sensitivity
from m4e_fmi.analysis.trim import trimmed

__all__ = [
    "EigenvalueSensitivity",
    "FrequencyResponse",
    "Linearization",
    "Linearizer",
    "Mechanical",
    "Modes",
    "OperatingPoint",
    "Sensitivities",
    "Sensitivity",
    "TrajectorySensitivity",
    "eigenvalue_sensitivity",
    "equilibrium",
    "frequency_response",
    "linearize",
    "modes",
    "sensitivity",
    "trajectory_sensitivity",
    "trimmed",
]
