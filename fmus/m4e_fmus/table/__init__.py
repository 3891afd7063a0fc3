"""The time table FMU: signals given at certain times; what it computes is said in README.md.

`config` is what a system file says, `rows` the numbers of it, from there or from a CSV file, and
`program` records them. Imports m4e_fmi's columns, document, errors, program and units.
"""

from __future__ import annotations

from m4e_fmi.fmu import FmuKind
from m4e_fmus.table.config import Config
from m4e_fmus.table.program import table_program
from m4e_fmus.table.rows import read_rows

KIND = FmuKind(
    Config,
    build=lambda config, name, folder, **_: table_program(
        config, read_rows(config, folder), name=name
    ),
)
