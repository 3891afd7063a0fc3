"""An FMU for co-simulation in this process, by FMPy."""

from __future__ import annotations

from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


class Running:
    """An FMU in this process, its variables by name."""

    def __init__(self, file: Path, folder: Path) -> None:
        extract(str(file), str(folder))
        description = read_model_description(str(file))
        assert description.coSimulation is not None
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=folder.name,
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def get(self, name: str) -> float:
        return self.slave.getReal([self.references[name]])[0]

    def set(self, **values: float) -> None:
        for name, value in values.items():
            self.slave.setReal([self.references[name.replace("__", ".")]], [value])

    def close(self) -> None:
        self.slave.terminate()
        self.slave.freeInstance()
