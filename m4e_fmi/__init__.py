"""m4e_fmi: symbolic multibody dynamics, co-simulation units and coupled simulation.

The verbs and what they need are here, imported when they are first used:

    model = m4e_fmi.load_model("buoy.model.yaml")
    motion = m4e_fmi.simulate(model, stop_time=60.0)
    outcome = m4e_fmi.run(m4e_fmi.load_system("system.yaml"), results="buoy.nc")

Packages, and the order in which they import each other: docs/architecture.md.
"""

from typing import TYPE_CHECKING

from m4e_fmi.lazy import lazy

if TYPE_CHECKING:
    from m4e_fmi.analysis import (
        equilibrium,
        frequency_response,
        linearize,
        modes,
        sensitivity,
        trajectory_sensitivity,
        trimmed,
    )
    from m4e_fmi.analysis.comparison import compare
    from m4e_fmi.analysis.decay import fit_decay
    from m4e_fmi.analysis.response import sea_response, wave_response
    from m4e_fmi.cosim import (
        System,
        load_system,
        mooring,
        prepare,
        run,
        save_system,
        start,
        system_in_waves,
        system_program,
    )
    from m4e_fmi.errors import InputError, M4eError, RunError, UnknownNameError
    from m4e_fmi.fmu import build_fmu, read_description, validate_fmu
    from m4e_fmi.model import Model, load_model
    from m4e_fmi.multibody import Equations, model_program
    from m4e_fmi.results.results_file import load
    from m4e_fmi.simulate import simulate
    from m4e_fmi.study import load_study, study, write_report

__version__ = "0.1.0"

__all__ = [
    "Equations",
    "InputError",
    "M4eError",
    "Model",
    "RunError",
    "System",
    "UnknownNameError",
    "build_fmu",
    "compare",
    "equilibrium",
    "fit_decay",
    "frequency_response",
    "linearize",
    "load",
    "load_model",
    "load_study",
    "load_system",
    "model_program",
    "modes",
    "mooring",
    "prepare",
    "read_description",
    "run",
    "save_system",
    "sea_response",
    "sensitivity",
    "simulate",
    "start",
    "study",
    "system_in_waves",
    "system_program",
    "trajectory_sensitivity",
    "trimmed",
    "validate_fmu",
    "wave_response",
    "write_report",
]

_MODULES = {
    "analysis": (
        "equilibrium",
        "frequency_response",
        "linearize",
        "modes",
        "sensitivity",
        "trajectory_sensitivity",
        "trimmed",
    ),
    "analysis.comparison": ("compare",),
    "analysis.decay": ("fit_decay",),
    "analysis.response": ("sea_response", "wave_response"),
    "cosim": (
        "System",
        "load_system",
        "mooring",
        "prepare",
        "run",
        "save_system",
        "start",
        "system_in_waves",
        "system_program",
    ),
    "errors": ("InputError", "M4eError", "RunError", "UnknownNameError"),
    "fmu": ("build_fmu", "read_description", "validate_fmu"),
    "model": ("Model", "load_model"),
    "multibody": ("Equations", "model_program"),
    "report": ("report",),
    "simulate": ("simulate",),
    "study": ("load_study", "study", "write_report"),
    "results.results_file": ("load",),
}
# the package `simulate` is its verb, too
__getattr__, __dir__ = lazy(__name__, _MODULES)
