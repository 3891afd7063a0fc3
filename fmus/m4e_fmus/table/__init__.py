"""The time table FMU: signals given at certain times; what it computes is said in README.md.

`config` is what a system file says, `rows` the numbers of it, from there or from a CSV file, and
`program` records them. Imports m4e_fmi's columns, document, errors, program and units.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_fmi.program import Program
from m4e_fmus.table.config import Config
from m4e_fmus.table.program import table_program
from m4e_fmus.table.rows import read_rows

__all__ = ["Config", "make"]


def make(
    config: Config,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], None] = print,  # noqa: ARG001  part of every kind's interface
) -> Program:
    """The program of the table called `name`; its file is relative to `folder`.

    InputError with all problems of the file.
    """
    return table_program(config, read_rows(config, folder), name=name)
