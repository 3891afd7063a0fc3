"""FMU of linear hydrodynamics: `kind: hydrodynamics`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_adapters.hydrodynamics.build import check_config, program_from_config
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_fmi.program import Program

Config = HydrodynamicsConfig
TAKES_LONG = True


def check(config: HydrodynamicsConfig, *, folder: Path) -> Program:
    """The variables of the FMU, in a program without potential flow, within a second.

    InputError with all that is wrong with the configuration and its mesh files.
    """
    return check_config(config, folder=folder)


def make(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured load on all bodies as a Program; mesh files are looked for in `folder`."""
    return program_from_config(config, name=name, folder=folder, progress=progress)
