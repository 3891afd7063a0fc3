"""m4e_fmi: symbolic multibody dynamics, co-simulation units and coupled simulation.

Layers, each importing only what stands before it:
`errors`, `units`, `document`, `results`, `program` → `model` → `multibody` → `simulate` → `fmu` →
`cosim` → `study` → `report` → `cli`.
"""

__version__ = "0.1.0"
