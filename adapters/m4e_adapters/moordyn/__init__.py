"""Mooring lines by MoorDyn: from a description or a ready file to what an FMU runs.

`config` has the keys of a system file, `from_config` makes a `Mooring` of them, `line_system` steps
that. Imports m4e_fmi's document and errors; `line_system` and the modules that it imports travel in
FMUs and import moordyn, NumPy and SciPy only. Start reading in `from_config.py`.
"""

from m4e_adapters.moordyn.config import MooringConfig
from m4e_adapters.moordyn.from_config import mooring
from m4e_adapters.moordyn.mooring import Failure, Fairlead, Mooring
from m4e_adapters.moordyn.ready_files.ready_file import ready_mooring

__all__ = [
    "Failure",
    "Fairlead",
    "Mooring",
    "MooringConfig",
    "mooring",
    "ready_mooring",
    "requirements",
]

MOORDYN = "2.7.2"


def requirements() -> list[tuple[str, bool, str]]:
    """Name, presence and remedy of MoorDyn, in the version whose behaviour was measured."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        found = version("moordyn")
    except PackageNotFoundError:
        return [("moordyn", False, f"pip install moordyn=={MOORDYN}")]
    if found != MOORDYN:
        return [("moordyn", False, f"{found} is installed: pip install moordyn=={MOORDYN}")]
    return [("moordyn", True, found)]
