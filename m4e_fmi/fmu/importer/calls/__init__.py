"""Calls of FMI 1.0, 2.0 and 3.0, in the vocabulary of FMI 2.0.

`Standard` is one instance of an FMU for co-simulation: start reading at `standard`. `Fmi1`, `Fmi2`
and `Fmi3` are its versions. `functions` with its versions 2 and 3 has the C functions with Python
arguments, for `Standard`, which raises where one fails, and for validation, which judges the
status. `parts`, `typed` and `reals_3` move many values at once.
"""

from __future__ import annotations

from m4e_fmi.fmu.importer.calls.fmi1 import Fmi1
from m4e_fmi.fmu.importer.calls.fmi2 import Fmi2
from m4e_fmi.fmu.importer.calls.fmi3 import Fmi3
from m4e_fmi.fmu.importer.calls.functions import DISCARD, ERROR, FATAL, WARNING, Status
from m4e_fmi.fmu.importer.calls.single import SingleValues
from m4e_fmi.fmu.importer.calls.standard import (
    EARLY,
    NEAR,
    RESTLESS,
    Call,
    Events,
    RawCall,
    Rollback,
    SerializedState,
    Standard,
    Value,
)
from m4e_fmi.fmu.importer.calls.texts import Texts
from m4e_fmi.fmu.importer.calls.typed import DOES_NOT_FIT, Access, Taken, value_in

STANDARDS: dict[str, type[Standard]] = {"1.0": Fmi1, "2.0": Fmi2, "3.0": Fmi3}
"""By the version of FMI that a description names."""

__all__ = [
    "DISCARD",
    "DOES_NOT_FIT",
    "EARLY",
    "ERROR",
    "FATAL",
    "NEAR",
    "RESTLESS",
    "STANDARDS",
    "WARNING",
    "Access",
    "Call",
    "Events",
    "RawCall",
    "Rollback",
    "SerializedState",
    "SingleValues",
    "Standard",
    "Status",
    "Taken",
    "Texts",
    "Value",
    "value_in",
]
