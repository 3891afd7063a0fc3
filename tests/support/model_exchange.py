"""Instances of FMI 2.0 FMUs for model exchange, by FMPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
from fmpy import fmi2


def exchange(path: Path, folder: Path) -> tuple[fmi2.FMU2Model, dict[str, int]]:
    """An instance for model exchange in event mode, and its value references."""
    description: Any = fmpy.read_model_description(str(path))
    fmpy.extract(str(path), str(folder))
    model = fmi2.FMU2Model(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="model",
    )
    model.instantiate()
    model.setupExperiment()
    model.enterInitializationMode()
    model.exitInitializationMode()
    return model, {v.name: v.valueReference for v in description.modelVariables}
