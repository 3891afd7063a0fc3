"""Requirements of this adapter on a machine, for `m4e-fmi doctor`."""

from __future__ import annotations

import tempfile
from importlib.metadata import version

from m4e_adapters.hydrodynamics.flow.cache import ENVIRONMENT, cache_folder
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine

REINSTALL = "reinstall it: pip install --force-reinstall capytaine"


def requirements() -> list[tuple[str, bool, str]]:
    """Name, presence, and a detail or a remedy of each requirement."""
    there, told = True, f"version {version('capytaine')}"
    try:
        import_capytaine()
    except Exception as error:  # noqa: BLE001  a broken binary may raise anything
        there, told = False, f"{type(error).__name__}: {error}; {REINSTALL}"
    folder = cache_folder()
    kept, where = True, str(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        kept, where = False, f"{folder}: {error.strerror}; set {ENVIRONMENT} to a writable folder"
    return [
        ("capytaine (potential flow)", there, told),
        ("cache of hydrodynamic coefficients", kept, where),
    ]
