"""Requirements of this adapter on a machine, for `m4e-fmi doctor`."""

from __future__ import annotations

import tempfile
from importlib.metadata import version

from m4e_adapters.hydrodynamics.flow.cache import ENVIRONMENT, cache_folder
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine

REINSTALL = "reinstall it: pip install --force-reinstall capytaine"


def requirements() -> list[tuple[str, bool, str]]:
    """Name, presence, and a detail or a remedy of each requirement."""
    return [_core(), _cache()]


def _core() -> tuple[str, bool, str]:
    """Capytaine with its compiled kernels."""
    what = "capytaine (potential flow)"
    try:
        import_capytaine()
    except Exception as error:  # noqa: BLE001  a broken binary may raise anything
        return what, False, f"{type(error).__name__}: {error}; {REINSTALL}"
    return what, True, f"version {version('capytaine')}"


def _cache() -> tuple[str, bool, str]:
    what = "cache of hydrodynamic coefficients"
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        return what, False, f"{folder}: {error.strerror}; set {ENVIRONMENT} to a writable folder"
    return what, True, str(folder)
