"""The description of an FMI 1.0 FMU for co-simulation in the words of FMI 2.0.

FMPy reads the variables; capabilities, dependencies and whether a start value is exact are read
here. Source: FMI for Co-Simulation 1.0, sections 3 and 4.3; FMI for Model Exchange 1.0, section 3.
"""

from __future__ import annotations

from collections.abc import Mapping

from fmpy.model_description import CoSimulation, ModelVariable, Unknown
from lxml import etree

from m4e_fmi.fmu.importer.elements import FmpyDescription
from m4e_fmi.fmu.importer.flaws import Element

_WAYS = ("CoSimulation_StandAlone", "CoSimulation_Tool")
_CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "canBeInstantiatedOnlyOncePerProcess",
)
_TRUE = ("true", "1")


def translate(raw: FmpyDescription, text: bytes) -> str:
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
        v.initial = _initial(v, elements[v.name])
    parameters = [v for v in kept if v.causality == "parameter"]
    for v in kept:
        needs = _dependencies(elements[v.name], variables)
        if v.causality == "output" and needs is not None:
            raw.outputs.append(Unknown(variable=v, dependencies=needs))
            raw.initialUnknowns.append(Unknown(variable=v, dependencies=needs + parameters))
    return _capabilities(root, raw.coSimulation)


def _initial(variable: ModelVariable, element: Element) -> str | None:
    """FMI 2.0's `initial`: what has a start value may be set before the start, inputs always."""
    if variable.causality == "input":
        return None
    value = next(iter(element.iterfind(variable.type)))
    if value.get("start") is None or variable.variability == "constant":
        return "calculated"
    return "exact" if value.get("fixed", "true") in _TRUE else "approx"


def _dependencies(
    element: Element, variables: Mapping[str, ModelVariable]
) -> list[ModelVariable] | None:
    """The inputs that an output depends on; None where nothing is declared."""
    declared = element.find("DirectDependency")
    if declared is None:
        return None
    names = [name.text or "" for name in declared.iterfind("Name")]
    return [variables[name] for name in names if name in variables]


def _capabilities(root: Element, stepping: CoSimulation | None) -> str:
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
