"""Co-simulation: the master that couples FMUs.

    System ──prepare──► Prepared (FMUs built, connections checked, order known) ──run──► Outcome

Start reading at `system/` (components and connections), then `wiring/` (order of exchange),
`network/` and `time_loop/`, `algorithms/` (methods of stepping), and `error/`. `run/`
runs it all. See docs/architecture.md.
"""

from m4e_fmi.cosim.composition.compose import at_equilibrium, system_in_waves, system_program
from m4e_fmi.cosim.composition.moorings import mooring
from m4e_fmi.cosim.error.report import CouplingError, CouplingErrorReport
from m4e_fmi.cosim.network.fmu_log import FmuMessage
from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.preparation.components import fmu_files
from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.results.system_scene import scene_without_build
from m4e_fmi.cosim.run.checkpoint import State
from m4e_fmi.cosim.run.execution import CommunicationPoint, Execution
from m4e_fmi.cosim.run.outcome import ExportError, Outcome
from m4e_fmi.cosim.run.verbs import run, start
from m4e_fmi.cosim.save import save_system
from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, ModelFile
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.system.system import Action, System
from m4e_fmi.cosim.system_file import load_system, read_parameters
from m4e_fmi.cosim.time_loop.energy import BondEnergy
from m4e_fmi.cosim.wiring.links import Bond, Link, Port, Wiring
from m4e_fmi.cosim.wiring.prepared import Prepared, Timing
from m4e_fmi.results.results_file import Results, Series
from m4e_fmi.results.results_file import load_results as load

__all__ = [
    "Action",
    "Bond",
    "BondEnergy",
    "CommunicationPoint",
    "Component",
    "CouplingError",
    "CouplingErrorReport",
    "Execution",
    "ExportError",
    "FmuFile",
    "FmuMessage",
    "Kind",
    "Link",
    "ModelFile",
    "Network",
    "Outcome",
    "Port",
    "Prepared",
    "Results",
    "Series",
    "Simulation",
    "State",
    "System",
    "Timing",
    "Wiring",
    "at_equilibrium",
    "fmu_files",
    "load",
    "load_system",
    "mooring",
    "prepare",
    "read_parameters",
    "run",
    "save_system",
    "scene_without_build",
    "start",
    "system_in_waves",
    "system_program",
]
