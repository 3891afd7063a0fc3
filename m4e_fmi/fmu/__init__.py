"""FMUs: what they say of themselves, how they are built, how they are checked.

`build_fmu` packages a Program or a Python slave; `embedded/` holds what travels inside. Imports
`program`, `runtime`, `units`, `errors`. Start with `description`, then `build`.
"""

from m4e_fmi.fmu.build import build_fmu
from m4e_fmi.fmu.description import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.fmu.from_program import describe

__all__ = ["FmuVariable", "ModelDescription", "PythonSource", "build_fmu", "describe"]
