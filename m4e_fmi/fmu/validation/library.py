"""The shared library of the FMU under test, loaded once, and instances from it."""

from __future__ import annotations

import ctypes
import os
from dataclasses import dataclass, field
from pathlib import Path

from fmpy import fmi2, fmi3

from m4e_fmi.fmu.importer.call_journal import Journal
from m4e_fmi.fmu.importer.calls.functions import ERROR
from m4e_fmi.fmu.validation.fmu_under_test import FmuUnderTest
from m4e_fmi.fmu.validation.probe import INSTANTIATE, Probe, RefusedError


@dataclass
class Library:
    """The FMU's library, loaded once; `overruns` are the calls that wrote outside their array."""

    subject: FmuUnderTest
    journal: Journal
    overruns: list[str] = field(default_factory=list)
    _loaded: dict[bool, ctypes.CDLL] = field(default_factory=dict)

    def functions(self, *, exchange: bool) -> ctypes.CDLL:
        """The functions, with the argument types of model exchange or of co-simulation."""
        if exchange not in self._loaded:
            here = Path.cwd()
            kind = self.subject.kind(exchange=exchange)
            ways = (fmi2.FMU2Slave, fmi2.FMU2Model)
            if self.subject.fmi_3:
                ways = (fmi3.FMU3Slave, fmi3.FMU3Model)
            self.journal.write("loading the library")
            try:
                loaded = ways[exchange](
                    guid=self.subject.raw.guid,
                    unzipDirectory=str(self.subject.folder),
                    modelIdentifier=kind.modelIdentifier,
                    instanceName="validation",
                    requireFunctions=False,
                )
            finally:
                os.chdir(here)  # loading leaves the process elsewhere when it fails
            self._loaded[exchange] = loaded.dll
        return self._loaded[exchange]

    def probe(self, *, exchange: bool = False, name: str = "validation") -> Probe:
        """A new instance; RefusedError if there is none."""
        probe = self.attempt(exchange=exchange, name=name)
        if not probe.component:
            raise RefusedError(INSTANTIATE, ERROR, probe.words())
        return probe

    def attempt(
        self, *, exchange: bool, name: str, guid: str | None = None, events: bool = False
    ) -> Probe:
        """The same, but its `component` may be none. Of FMI 3.0, with event mode if `events`."""
        return Probe(self, exchange=exchange, name=name, guid=guid, events=events)
