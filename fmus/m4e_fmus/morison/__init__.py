"""FMU of slender members: `kind: morison`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from m4e_adapters.morison import MorisonConfig, morison_program
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program

Config = MorisonConfig


def make(
    config: MorisonConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured members as a Program; files of waves are looked for in `folder`."""
    return morison_program(config, name=name, folder=folder, progress=progress)


def make_in_waves(
    config: MorisonConfig,  # noqa: ARG001  part of every kind's interface
    *,
    name: str,
    folder: Path,  # noqa: ARG001
    highest: float,  # noqa: ARG001
    progress: Callable[[str], object] = print,  # noqa: ARG001
) -> NoReturn:
    """InputError: forces that end at the surface, wherever it is, have no linear form here."""
    raise InputError.single(
        f"{name}: forces of waves on members by Morison's equation are not linearised",
        "simulate the system (m4e-fmi run), or remove the component from its file",
    )
