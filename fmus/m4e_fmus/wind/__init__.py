"""FMU of wind on points of bodies: `kind: wind`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_adapters.wind import WindConfig, wind_program
from m4e_fmi.program import Program

Config = WindConfig


def make(
    config: WindConfig,
    *,
    name: str,
    folder: Path,  # noqa: ARG001  part of every kind's interface
    progress: Callable[[str], object] = print,  # noqa: ARG001
) -> Program:
    """The configured wind as a Program."""
    return wind_program(config, name=name)
