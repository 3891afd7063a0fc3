"""The scalars of an FMI 3.0 description: each element of an array of Float64 is a Real of its own.

So the checks, which are made for scalars, need not know of arrays. An element's `valueReference`
is a key: the value reference of its array plus its index times `_BASE`; `locate` takes it apart.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve

_BASE = 2**32  # value references have 32 bits


def locate(key: int) -> tuple[int, int]:
    """Value reference and index, row by row, that an element's key stands for."""
    index, reference = divmod(key, _BASE)
    return reference, index


def owner(variable: Any) -> int:
    """The value reference of the variable, or of the array that it is an element of."""
    return locate(variable.valueReference)[0]


def array_name(variable: Any) -> str:
    """Name of the variable, or of the array that it is an element of."""
    return variable.name.rpartition("[")[0] if variable.shape else variable.name


def flattened(raw: Any, folder: Path) -> Any:
    """FMPy's description `raw` of the FMI 3.0 FMU in `folder`, with elements in place of arrays.

    An unknown of ModelStructure becomes one entry per element, each with all elements of what is
    declared for the array. What FMI 3.0 calls otherwise gets the name that it has in FMI 2.0.
    """
    elements = {v.valueReference: _elements(v) for v in raw.modelVariables}
    for v in raw.modelVariables:
        if v.derivative is not None and v.type == "Float64":
            rates, bases = elements[v.valueReference], elements[v.derivative.valueReference]
            for rate, base in zip(rates, bases, strict=False):
                rate.derivative = base
    lists = {
        name: [e for unknown in getattr(raw, name) for e in _entries(unknown, elements)]
        for name in ("outputs", "derivatives", "initialUnknowns")
    }
    root = ET.parse(folder / "modelDescription.xml").getroot()
    for name, kind in (("CoSimulation", raw.coSimulation), ("ModelExchange", raw.modelExchange)):
        if kind is not None:
            told = root.find(name)
            assert told is not None
            provided = told.get("providesDirectionalDerivatives") in ("true", "1")
            kind.providesDirectionalDerivative = provided
    variables = [e for v in raw.modelVariables for e in elements[v.valueReference]]
    return evolve(raw, modelVariables=variables, **lists)


def _elements(variable: Any) -> list[Any]:
    if variable.type != "Float64":
        return [variable]
    if not variable.shape:
        return [evolve(variable, type="Real")]
    starts: Sequence[str | None] = (variable.start or "").split() or [None]
    found = []
    for k, place in enumerate(np.ndindex(*variable.shape)):
        name = f"{variable.name}[{','.join(str(n + 1) for n in place)}]"
        start = starts[k] if k < len(starts) else starts[-1]
        key = variable.valueReference + k * _BASE
        found.append(evolve(variable, name=name, valueReference=key, type="Real", start=start))
    return found


def _entries(unknown: Any, elements: dict[int, list[Any]]) -> list[Any]:
    dependencies, kinds = unknown.dependencies, unknown.dependenciesKind
    if dependencies is not None:
        of_each = [elements[v.valueReference] for v in dependencies]
        dependencies = [e for several in of_each for e in several]
        if kinds is not None:
            pairs = zip(of_each, kinds, strict=False)
            kinds = [kind for several, kind in pairs for _ in several]
    return [
        evolve(unknown, variable=e, dependencies=dependencies, dependenciesKind=kinds)
        for e in elements[unknown.variable.valueReference]
    ]
