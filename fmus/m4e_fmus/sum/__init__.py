"""The sum FMU: signals of several components into one input; README.md says what it computes.

Imports m4e_fmi's document, program and units.
"""

from __future__ import annotations

from m4e_fmi.fmu import FmuKind
from m4e_fmus.sum.config import Config
from m4e_fmus.sum.program import sum_program

KIND = FmuKind(Config, build=lambda config, name, **_: sum_program(config, name=name))
