"""FMUs: what they say of themselves, how they are built, how anyone's are read.

`build_fmu` packages a Program or a Python slave; `embedded/` holds what travels inside.
`read_description` reads what an FMU file says, before anything of it is unpacked or run. Imports
`program`, `runtime`, `units`, `errors`. Start with `description`, then `build`; or with `reading`.
"""

from m4e_fmi.fmu.build import build_fmu
from m4e_fmi.fmu.description import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.fmu.from_program import describe
from m4e_fmi.fmu.reading import Description, read_description

__all__ = [
    "Description",
    "FmuVariable",
    "ModelDescription",
    "PythonSource",
    "build_fmu",
    "describe",
    "read_description",
]
