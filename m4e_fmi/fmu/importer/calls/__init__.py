"""FMI as its versions have it: what one instance of an FMU is told and asked, in one vocabulary.

`Instance` speaks FMI 2.0; `Fmi1`, `Fmi2` and `Fmi3` translate. Start reading at `standard`, which
lists what each of them does. Imports m4e_fmi.fmu and m4e_fmi.runtime.
"""

from __future__ import annotations

from m4e_fmi.fmu.importer.calls.fmi1 import Fmi1
from m4e_fmi.fmu.importer.calls.fmi2 import Fmi2
from m4e_fmi.fmu.importer.calls.fmi3 import Fmi3
from m4e_fmi.fmu.importer.calls.standard import (
    DISCARD,
    EARLY,
    ERROR,
    FATAL,
    NEAR,
    RESTLESS,
    WARNING,
    Call,
    Events,
    RawCall,
    Standard,
    Status,
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
    "Standard",
    "Status",
    "Taken",
    "Texts",
    "Value",
    "value_in",
]
