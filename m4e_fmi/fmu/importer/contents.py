"""Everything an FMU of any kind says of itself, as JSON values; nothing of it is run."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

from fmpy.model_description import InterfaceType
from lxml import etree

from m4e_fmi.fmu.importer.elements import FmpyUnknown, add_directional, unit_of
from m4e_fmi.fmu.importer.opening import check_archive
from m4e_fmi.fmu.importer.reading import raw_description

_KINDS = {
    "modelExchange": "model exchange",
    "coSimulation": "co-simulation",
    "scheduledExecution": "scheduled execution",
}
_FMI_3 = {
    "canGetAndSetFMUstate": "canGetAndSetFMUState",
    "canSerializeFMUstate": "canSerializeFMUState",
    "providesDirectionalDerivative": "providesDirectionalDerivatives",
}
"""FMI 2.0's name, as FMPy has it, and FMI 3.0's own."""
_IDENTITY = ("fmiVersion", "modelName", "description", "generationTool", "generationDateAndTime")
_EXPERIMENT = ("startTime", "stopTime", "stepSize", "tolerance")
_OF_A_VARIABLE = (
    "name",
    "valueReference",
    "type",
    "causality",
    "variability",
    "initial",
    "start",
    "min",
    "max",
    "nominal",
    "description",
)


def fmu_contents(path: str | Path) -> dict[str, Any]:
    """Identity, platforms, size [bytes], experiment, capabilities, variables and structure.

    `kinds` has the capabilities of each kind that are not at their default, by the names of the
    FMU's version; `structure` the dependencies of outputs, derivatives and initial unknowns with
    their kinds, None where the FMU declares none. InputError if the file is no FMU or cannot be
    understood.
    """
    path = Path(path)
    names, text = check_archive(path)
    raw = raw_description(path, text)
    fmi_3 = raw.fmiVersion.startswith("3.")
    if fmi_3:
        add_directional(raw, etree.fromstring(text))
    parts = [name.split("/") for name in sorted(names)]
    kinds = {text: getattr(raw, key) for key, text in _KINDS.items()}
    return {
        **{key: getattr(raw, key) for key in _IDENTITY},
        "instantiationToken": raw.guid or raw.instantiationToken,
        "platforms": sorted({p[1] for p in parts if p[0] == "binaries" and len(p) > 2}),
        "sources": any(p[0] == "sources" for p in parts),
        "size": path.stat().st_size,
        "unpacked": sum(info.file_size for info in zipfile.ZipFile(path).infolist()),
        "experiment": {
            key: float(value)
            for key in _EXPERIMENT
            if (value := getattr(raw.defaultExperiment, key, None))
        },
        "kinds": {
            text: _capabilities(kind, _FMI_3 if fmi_3 else {})
            for text, kind in kinds.items()
            if kind is not None
        },
        "variables": [_variable(v) for v in raw.modelVariables],
        "structure": {
            key: [_unknown(u) for u in getattr(raw, key)]
            for key in ("outputs", "derivatives", "initialUnknowns")
        },
    }


def _capabilities(kind: InterfaceType, names: dict[str, str]) -> dict[str, object]:
    default = type(kind)()
    told = {key: getattr(kind, key) for key in dir(kind) if not key.startswith("_")}
    return {
        names.get(key, key): value for key, value in told.items() if value != getattr(default, key)
    }


def _variable(raw: Any) -> dict[str, object]:
    of_type = raw.declaredType
    found = {key: getattr(raw, key) for key in _OF_A_VARIABLE}
    found["unit"] = unit_of(raw) or None
    found["derivative"] = raw.derivative.name if raw.derivative is not None else None
    found["shape"] = list(raw.shape) if raw.shape else None
    items = of_type.items if of_type is not None else None
    found["items"] = {item.name: int(item.value) for item in items} if items else None
    return {key: value for key, value in found.items() if value is not None}


def _unknown(raw: FmpyUnknown) -> dict[str, object]:
    needs = raw.dependencies
    return {
        "name": raw.variable.name,
        "dependencies": None if needs is None else [v.name for v in needs],
        "kinds": raw.dependenciesKind,
    }
