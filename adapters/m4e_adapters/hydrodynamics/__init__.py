"""Linear hydrodynamics of floating bodies in the X-Z plane: from shapes and a sea to a Program.

`program_from_config` goes all the way; its stages can be used alone: `make_hulls` (meshes, checked,
lids), `solve_hulls` (potential flow by Capytaine, cached), `fit_radiation` (the memory as a state
space) and `hydrodynamics_program`, which takes `Coefficients` from any source. Start reading in
`load` for the equation, in `coefficients` for the conventions.

Imports of m4e_fmi only what an adapter may: see `m4e_adapters`.
"""

from m4e_adapters.hydrodynamics.build import (
    coefficients_from_config,
    frequency_table,
    program_from_config,
)
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull, make_hulls
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_adapters.hydrodynamics.memory.group_fit import RadiationGroup
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation
from m4e_adapters.hydrodynamics.refinement import Refinement, refinement
from m4e_adapters.hydrodynamics.requirements import requirements

__all__ = [
    "Coefficients",
    "Hull",
    "HydrodynamicsConfig",
    "RadiationGroup",
    "Refinement",
    "coefficients_from_config",
    "fit_radiation",
    "frequency_table",
    "hydrodynamics_program",
    "make_hull",
    "make_hulls",
    "program_from_config",
    "refinement",
    "requirements",
    "solve_hulls",
]
