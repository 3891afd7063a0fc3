"""FMU of linear hydrodynamics: `kind: hydrodynamics`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_adapters.hydrodynamics.build import program_from_config
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_fmi.program import Program

Config = HydrodynamicsConfig


def make(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured load on all bodies as a Program; mesh files are looked for in `folder`."""
    return program_from_config(config, name=name, folder=folder, progress=progress)
