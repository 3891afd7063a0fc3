"""Calls of FMI 1.0, 2.0 and 3.0, in the vocabulary of FMI 2.0.

`Standard` is one instance of an FMU: start reading at `standard`. `Fmi1`, `Fmi2` and `Fmi3` are its
versions. The master's calls raise where one fails; validation has a journal of its calls, and
judges the statuses. `access` moves many values at once.
"""

from __future__ import annotations

from m4e_fmi.fmu.importer.calls.access import DOES_NOT_FIT, Access, Taken, Texts, value_in
from m4e_fmi.fmu.importer.calls.fmi2 import Fmi1, Fmi2
from m4e_fmi.fmu.importer.calls.fmi3 import Fmi3
from m4e_fmi.fmu.importer.calls.standard import (
    EARLY,
    NEAR,
    RESTLESS,
    Loaded,
    RawCall,
    SerializedState,
    Standard,
    Value,
)
from m4e_fmi.fmu.importer.messages import DISCARD, ERROR, FATAL, WARNING, Status

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
    "Fmi2",
    "Loaded",
    "RawCall",
    "SerializedState",
    "Standard",
    "Status",
    "Taken",
    "Texts",
    "Value",
    "value_in",
]
