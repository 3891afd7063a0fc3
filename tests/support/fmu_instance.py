"""An FMU in this process, by FMPy's own classes: independent of m4e_fmi's master."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import fmpy
from fmpy import fmi2

from m4e_fmi.fmu.importer.messages import Messages

DISCARD = 2


def dependency_kinds(unknowns: Iterable[Any]) -> dict[str, dict[str, str]]:
    """The kinds of dependencies by name, of each of FMPy's `unknowns` by name."""
    return {
        u.variable.name: dict(
            zip([v.name for v in u.dependencies], u.dependenciesKind, strict=True)
        )
        for u in unknowns
    }


class Instance:
    """An instance of the FMU at `path`, unpacked into `folder`; variables are called by name.

    Use it as a context manager: it is terminated, freed and its folder deleted at the end. A
    `description` that was read before saves reading it.
    """

    def __init__(
        self, path: Path, folder: Path, *, name: str = "instance", description: Any = None
    ) -> None:
        self._heard: list[tuple[int, str]] = []
        self.folder = folder
        self.description: Any = description or fmpy.read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        fmpy.extract(str(path), str(folder))
        self.fmu = fmi2.FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        # FMPy's proxy logs through the logger it was given last, for all FMUs of the process, also
        # once that one is gone: the logger of Messages stays
        self._messages = Messages()
        self.callbacks = self._messages.callbacks
        self.fmu.instantiate(loggingOn=True, callbacks=self.callbacks)

    @property
    def messages(self) -> list[tuple[int, str]]:
        """Status and text of what was logged since the list was cleared."""
        self._heard += self._messages.take()
        return self._heard

    def __enter__(self) -> Instance:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)

    def initialise(self, start: Mapping[str, float] | None = None, **experiment: Any) -> Instance:
        """Set `start` values and go through initialization mode."""
        self.set(start or {})
        self.fmu.setupExperiment(**{"startTime": 0.0, **experiment})
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, values: Mapping[str, float]) -> None:
        if values:
            self.fmu.setReal([self.references[name] for name in values], list(values.values()))

    def get(self, names: Iterable[str]) -> dict[str, float]:
        names = list(names)
        return dict(zip(names, self.fmu.getReal([self.references[n] for n in names]), strict=True))

    def __getitem__(self, name: str) -> float:
        return self.get([name])[name]

    def reals(self, *causalities: str) -> list[str]:
        """Names of the Real variables of these causalities, of all if none is given."""
        return [
            v.name
            for v in self.description.modelVariables
            if v.type == "Real" and (not causalities or v.causality in causalities)
        ]

    def step(self, t: float, h: float) -> None:
        self.fmu.doStep(t, h)

    @property
    def last_error(self) -> str:
        return self.fmu.getString([self.references["last_error"]])[0].decode("utf-8")
