"""The scalars of an FMI 3.0 description: each element of an array is a variable of its own.

So what works with scalars need not know of arrays. An element's `valueReference` is a key: the
value reference of its array plus its index times `_BASE`; `locate` takes it apart. Elements are
called ``array[1,2]``.

Also the description of an FMI 1.0 FMU for co-simulation in the words of FMI 2.0. FMPy reads its
variables; capabilities, dependencies and whether a start value is exact are read here. Source: FMI
for Co-Simulation 1.0, sections 3 and 4.3; FMI for Model Exchange 1.0, section 3.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from attrs import evolve
from fmpy.model_description import CoSimulation, ModelVariable, Unknown
from lxml import etree

from m4e_fmi.fmu.importer.flaws import Element

FmpyDescription = Any
"""FMPy's description of an FMU; FMPy's own types leave open what is always there."""
FmpyUnknown = Any
"""FMPy's entry of ModelStructure, likewise."""

_BASE = 2**32  # value references have 32 bits
REALS = {"Float64": "Real"}
"""The arrays that validation looks into, and what their elements are called in FMI 2.0."""
SCALARS = {
    **REALS,
    "Float32": "Real",
    **{f"{sign}Int{bits}": "Integer" for sign in ("", "U") for bits in (8, 16, 32, 64)},
    "Boolean": "Boolean",
    "Enumeration": "Enumeration",
    "String": "String",
    "Binary": "Binary",
}
"""All types that have values, likewise."""


def locate(key: int) -> tuple[int, int]:
    """Value reference and index, row by row, that an element's key stands for."""
    index, reference = divmod(key, _BASE)
    return reference, index


def owner(variable: ModelVariable) -> int:
    """The value reference of the variable, or of the array that it is an element of."""
    return locate(variable.valueReference)[0]


def unit_of(variable: ModelVariable) -> str:
    """The variable's own unit, or that of its type; "" without a unit."""
    return variable.unit or getattr(variable.declaredType, "unit", None) or ""


def flattened(
    raw: FmpyDescription, text: bytes, types: Mapping[str, str] = REALS
) -> FmpyDescription:
    """FMPy's FMI 3.0 description `raw`, with elements in place of variables of `types`.

    `text` is the XML that it was read from. An unknown of ModelStructure becomes one entry per
    element, each with all elements of the array's dependencies. Names that differ in FMI 3.0 become
    those of FMI 2.0.
    """
    root = etree.fromstring(text)
    found = {v.name: _elements(v, types) for v in raw.modelVariables}
    elements = {v.valueReference: found[v.name] for v in reversed(raw.modelVariables)}
    for v in raw.modelVariables:
        if v.derivative is not None and v.type in types:
            bases = elements[v.derivative.valueReference]
            for rate, base in zip(found[v.name], bases, strict=False):
                rate.derivative = base
    lists = {
        name: [e for unknown in getattr(raw, name) for e in _entries(unknown, elements)]
        for name in ("outputs", "derivatives", "initialUnknowns")
    }
    add_directional(raw, root)
    variables = [e for v in raw.modelVariables for e in found[v.name]]
    return evolve(raw, modelVariables=variables, **lists)


def add_directional(raw: FmpyDescription, root: Element) -> None:
    """Complete FMPy's FMI 3.0 description by providesDirectionalDerivatives, which it leaves out.

    Under the name of FMI 2.0. `root` is the XML it was read from.
    """
    for name, kind in (("CoSimulation", raw.coSimulation), ("ModelExchange", raw.modelExchange)):
        told = root.find(name)
        if kind is not None and told is not None:
            provided = told.get("providesDirectionalDerivatives") in ("true", "1")
            kind.providesDirectionalDerivative = provided


def _elements(variable: ModelVariable, types: Mapping[str, str]) -> list[ModelVariable]:
    if variable.type not in types:
        return [variable]
    type_ = types[variable.type]
    if not variable.shape:
        return [evolve(variable, type=type_)]
    numbers = type_ not in ("String", "Binary")
    starts = (variable.start or "").split() if numbers else [variable.start]
    places = [",".join(str(n + 1) for n in place) for place in np.ndindex(*variable.shape)]
    return [
        evolve(
            variable,
            name=f"{variable.name}[{place}]",
            valueReference=variable.valueReference + k * _BASE,
            type=type_,
            start=starts[min(k, len(starts) - 1)] if starts else None,
        )
        for k, place in enumerate(places)
    ]


def _entries(unknown: FmpyUnknown, elements: dict[int, list[ModelVariable]]) -> list[FmpyUnknown]:
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


# ---- FMI 1.0 ----

_WAYS = ("CoSimulation_StandAlone", "CoSimulation_Tool")
_CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "canBeInstantiatedOnlyOncePerProcess",
)
_TRUE = ("true", "1")


def translate_1(raw: FmpyDescription, text: bytes) -> str:
    """Complete FMPy's description `raw` by what `text`, the XML that it was read from, says.

    Negated aliases are left out: they have no value reference of their own. The MIME type or file
    of the tool that the FMU couples; "" where it needs none.
    """
    root = etree.fromstring(text)
    elements = {e.get("name"): e for e in root.iterfind("ModelVariables/ScalarVariable")}
    kept = [v for v in raw.modelVariables if elements[v.name].get("alias") != "negatedAlias"]
    raw.modelVariables = kept
    variables = {v.name: v for v in kept}
    for v in kept:
        if v.causality == "none":
            v.causality = "local"
        v.initial = _initial_1(v, elements[v.name])
    parameters = [v for v in kept if v.causality == "parameter"]
    for v in kept:
        needs = _dependencies_1(elements[v.name], variables)
        if v.causality == "output" and needs is not None:
            raw.outputs.append(Unknown(variable=v, dependencies=needs))
            raw.initialUnknowns.append(Unknown(variable=v, dependencies=needs + parameters))
    return _capabilities_1(root, raw.coSimulation)


def _initial_1(variable: ModelVariable, element: Element) -> str | None:
    """FMI 2.0's `initial`: what has a start value may be set before the start, inputs always."""
    if variable.causality == "input":
        return None
    value = next(iter(element.iterfind(variable.type)))
    if value.get("start") is None or variable.variability == "constant":
        return "calculated"
    return "exact" if value.get("fixed", "true") in _TRUE else "approx"


def _dependencies_1(
    element: Element, variables: Mapping[str, ModelVariable]
) -> list[ModelVariable] | None:
    """The inputs that an output depends on; None where nothing is declared."""
    declared = element.find("DirectDependency")
    if declared is None:
        return None
    names = [name.text or "" for name in declared.iterfind("Name")]
    return [variables[name] for name in names if name in variables]


def _capabilities_1(root: Element, stepping: CoSimulation | None) -> str:
    for way in _WAYS:
        found = root.find(f"Implementation/{way}")
        if found is None:
            continue
        told = found.find("Capabilities")
        for name in _CAPABILITIES:
            setattr(stepping, name, told is not None and told.get(name) in _TRUE)
        model = found.find("Model")
        if way == "CoSimulation_Tool":
            return (model.get("type") or "a tool") if model is not None else "a tool"
    return ""
