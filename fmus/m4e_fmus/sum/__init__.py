"""The sum FMU: signals of several components into one input; README.md says what it computes.

Imports m4e_fmi's document, program and units.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_fmi.program import Program
from m4e_fmus.sum.config import Config
from m4e_fmus.sum.program import sum_program

__all__ = ["Config", "make"]


def make(
    config: Config,
    *,
    name: str,
    folder: Path,  # noqa: ARG001  part of the interface of every kind of FMU
    progress: Callable[[str], None] = print,  # noqa: ARG001
) -> Program:
    """The program of the sum called `name`; it reads no files and takes no time."""
    return sum_program(config, name=name)
