"""Co-simulation: the master that couples FMUs.

    System ──prepare──► Prepared (FMUs built, connections checked, order known) ──run──► Outcome

Start reading at `system` (what is coupled), then `connect` and `structure` (what follows from it),
`network` and `master` (the time loop; `execution` steps it from Python), `algorithms` (how a step
is made; `corrector` is the default). Imports m4e_fmi.errors, document, units and,
to build components, m4e_fmi.fmu.
"""

from m4e_fmi.cosim.certificate import Certificate, CouplingError
from m4e_fmi.cosim.components import fmu_files
from m4e_fmi.cosim.connect import Bond, Link, Port, Wiring
from m4e_fmi.cosim.energy import BondEnergy
from m4e_fmi.cosim.execution import CommunicationPoint, Execution
from m4e_fmi.cosim.journal import FmuMessage
from m4e_fmi.cosim.master import State
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.preparation import Prepared, prepare
from m4e_fmi.cosim.run import ExportError, Outcome, run, start
from m4e_fmi.cosim.system import Component, FmuFile, Kind, ModelFile, Simulation, System
from m4e_fmi.cosim.system_file import read_parameters
from m4e_fmi.cosim.timing import Timing
from m4e_fmi.results import Results, Series, load

__all__ = [
    "Bond",
    "BondEnergy",
    "Certificate",
    "CommunicationPoint",
    "Component",
    "CouplingError",
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
    "fmu_files",
    "load",
    "prepare",
    "read_parameters",
    "run",
    "start",
]
