"""Saving a system with all its FMUs as an SSP package."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from m4e_fmi.cosim.preparation.prepare import prepare
from m4e_fmi.cosim.ssp.package import SUFFIX
from m4e_fmi.cosim.ssp.write import write_ssp
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError


def save_system(system: System, path: str | Path, *, build_directory: str | Path = "build") -> Path:
    """Write the system with all its FMUs, built where needed, as an SSP package (`*.ssp`).

    InputError and RunError as from `prepare`, and InputError for another suffix.
    """
    if Path(path).suffix.lower() != SUFFIX:
        raise InputError.single(f"a system is saved as {SUFFIX}", f"write {path}{SUFFIX}")
    prepared = prepare(system, build_directory=build_directory)
    sums = [c for c in prepared.system.components if c.name in prepared.wiring.sums]
    whole = replace(system, components=(*system.components, *sums))
    return write_ssp(replace(prepared, system=whole), path)
