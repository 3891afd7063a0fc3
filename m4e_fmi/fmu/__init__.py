"""FMUs: what they say of themselves, how they are built, how anyone's are read.

`export/` builds FMUs of Programs and Python slaves; `importer/` reads and calls anyone's, and
`validation/` checks whether they do what they say.
"""

from importlib import import_module
from typing import TYPE_CHECKING

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
    from m4e_fmi.fmu.export.selection import matching, renamed
    from m4e_fmi.fmu.importer.contents import fmu_contents
    from m4e_fmi.fmu.importer.reading import Description, read_description
    from m4e_fmi.fmu.validation import Finding, Group, Report, validate_fmu

__all__ = [
    "Description",
    "Finding",
    "FmuVariable",
    "Group",
    "ModelDescription",
    "Options",
    "PythonSource",
    "Report",
    "build_fmu",
    "describe",
    "described",
    "fmu_contents",
    "matching",
    "read_description",
    "renamed",
    "shown",
    "validate_fmu",
]

_NAMES = {
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
    "export.selection": ("matching", "renamed"),
    "importer.contents": ("fmu_contents",),
    "importer.reading": ("Description", "read_description"),
    "validation": ("Finding", "Group", "Report", "validate_fmu"),
}
_PLACES = {name: place for place, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> object:
    """A name of the package; modules that build FMUs are not imported where they are only read."""
    if name not in _PLACES:
        raise AttributeError(f"module 'm4e_fmi.fmu' has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f"m4e_fmi.fmu.{_PLACES[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
