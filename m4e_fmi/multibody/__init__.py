"""Equations of motion of a model: topology, B and Ḃ, loads, energies, the equations of motion.

One source runs over SymPy symbols (`Equations`, to read) and over a tape (`model_program`, to run):
`assembly` sets a model in motion, `recursion` or `closed_form` gives the accelerations, `recording`
the program. Joints and vectors are those of `joints` and `space`. Imports `model` and `program`.
Start with `topology`, then `assembly`.
"""

from m4e_fmi.multibody.recording import mass_matrix_program, model_program
from m4e_fmi.multibody.symbolic.equations import Equations
from m4e_fmi.multibody.topology import Topology, topology

__all__ = ["Equations", "Topology", "mass_matrix_program", "model_program", "topology"]
