"""What follows from a model: topology, B and Ḃ, loads, energies, the equations of motion.

One source, `assembly.assemble`, runs over SymPy symbols (`Equations`, to read) and over a tape
(`model_program`, to run). Only `planar` knows that the world has two dimensions. Imports `model`
and `program`. Start with `topology`, then `kinematics`, then `assembly`.
"""

from m4e_fmi.multibody.equations import Equations
from m4e_fmi.multibody.recording import model_program
from m4e_fmi.multibody.topology import Topology, topology

__all__ = ["Equations", "Topology", "model_program", "topology"]
