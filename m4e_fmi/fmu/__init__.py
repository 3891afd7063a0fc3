"""FMUs: what they say of themselves, how they are built, how anyone's are read.

`export/` builds FMUs of Programs and Python slaves; `importer/` reads and calls anyone's, and
`validation/` checks whether they do what they say.
"""

from typing import TYPE_CHECKING

from m4e_fmi.lazy import lazy

if TYPE_CHECKING:
    from m4e_fmi.fmu.export.build import build_fmu
    from m4e_fmi.fmu.export.description import (
        FmuVariable,
        ModelDescription,
        Options,
        PythonSource,
        describe,
        described,
        shown,
    )
    from m4e_fmi.fmu.export.python_fmu import runtime_files
    from m4e_fmi.fmu.export.selection import matching
    from m4e_fmi.fmu.importer.contents import fmu_contents
    from m4e_fmi.fmu.importer.reading import Description, read_description
    from m4e_fmi.fmu.kind import FmuKind, OutputsAtRest
    from m4e_fmi.fmu.validation import Finding, Group, Report, validate_fmu

__all__ = [
    "Description",
    "Finding",
    "FmuKind",
    "FmuVariable",
    "Group",
    "ModelDescription",
    "Options",
    "OutputsAtRest",
    "PythonSource",
    "Report",
    "build_fmu",
    "describe",
    "described",
    "fmu_contents",
    "matching",
    "read_description",
    "runtime_files",
    "shown",
    "validate_fmu",
]

_MODULES = {
    "export.build": ("build_fmu",),
    "export.description": (
        "FmuVariable",
        "ModelDescription",
        "Options",
        "PythonSource",
        "describe",
        "described",
        "shown",
    ),
    "export.python_fmu": ("runtime_files",),
    "export.selection": ("matching",),
    "importer.contents": ("fmu_contents",),
    "importer.reading": ("Description", "read_description"),
    "kind": ("FmuKind", "OutputsAtRest"),
    "validation": ("Finding", "Group", "Report", "validate_fmu"),
}
# modules that build FMUs are not imported where FMUs are only read
__getattr__, __dir__ = lazy(__name__, _MODULES)
