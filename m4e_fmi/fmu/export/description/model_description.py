"""modelDescription.xml of an FMI 2.0 FMU, in Python (co-simulation) or native (both kinds).

Source: FMI Specification 2.0.4, section 2.2. Element order and attributes follow its schema.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

import m4e_fmi
from m4e_fmi.fmu.export.description.description import FmuVariable, ModelDescription
from m4e_fmi.fmu.export.description.xml_parts import (
    add_experiment,
    add_quantity,
    add_types,
    add_units,
    legal,
    xml_bytes,
)
from m4e_fmi.program.dependence import KINDS

LONG = 200
"""Dependencies beyond which a list of all that is known is left out, and of kinds that are alike:
FMI reads them the same, and lists of n outputs of n others grow as n²."""
XML = "modelDescription.xml"


def model_description_xml(
    description: ModelDescription,
    *,
    model_identifier: str,
    guid: str,
    native: bool = False,
    sources: Sequence[str] = (),
) -> bytes:
    """The XML text (UTF-8) of `description`; ValueError names a unit that is not understood.

    A `native` FMU is one of model exchange, too, and declares what its library can do more.
    `sources` are the C files in the FMU that an importer compiles.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=description.name,
        guid=guid,
        description=legal(description.description),
        generationTool=f"m4e_fmi {m4e_fmi.__version__}",
        variableNamingConvention="structured",
    )
    if native:
        root.set("numberOfEventIndicators", "0")
    _add_kinds(root, model_identifier, native=native, sources=sources)
    add_units(root, description.variables)
    add_types(root, description.variables, "SimpleType")
    add_experiment(root, description)
    _add_variables(root, description.variables)
    _add_structure(root, description, native=native)
    return xml_bytes(root)


def with_guid(xml: bytes, guid: str) -> bytes:
    """The XML of a description that was written with an empty GUID (FMI 3.0: token)."""
    return re.sub(rb'(guid|instantiationToken)=""', rf'\1="{guid}"'.encode(), xml, count=1)


def _add_kinds(root: Element, identifier: str, *, native: bool, sources: Sequence[str]) -> None:
    both = {
        "modelIdentifier": identifier,
        "needsExecutionTool": "false" if native else "true",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    more = {}
    if native:
        both["providesDirectionalDerivative"] = "true"
        more = {"canInterpolateInputs": "true", "maxOutputDerivativeOrder": "1"}
        SubElement(root, "ModelExchange", both, completedIntegratorStepNotNeeded="true")
    stepping = {"canHandleVariableCommunicationStepSize": "true", **more}
    SubElement(root, "CoSimulation", {**both, **stepping})
    for kind in root if sources else ():
        files = SubElement(kind, "SourceFiles")
        for name in sources:
            SubElement(files, "File", name=name)


def _add_variables(root: Element, variables: tuple[FmuVariable, ...]) -> None:
    position = {variable.name: k + 1 for k, variable in enumerate(variables)}
    if len(position) != len(variables):
        names = [variable.name for variable in variables]
        raise ValueError(
            f"variables named twice: {sorted({n for n in names if names.count(n) > 1})}"
        )
    references: dict[str, int] = {}
    parent = SubElement(root, "ModelVariables")
    for variable in variables:
        reference = references.get(variable.type, 0)
        references[variable.type] = reference + 1
        attributes = {
            "name": variable.name,
            "valueReference": str(reference),
            "description": legal(variable.description),
            "causality": variable.causality,
            "variability": variable.variability,
        }
        if variable.initial:
            attributes["initial"] = variable.initial
        element = SubElement(parent, "ScalarVariable", attributes)
        kind = SubElement(element, variable.type)
        if variable.type == "Real":
            add_quantity(kind, variable)
        if variable.start is not None:
            kind.set("start", str(variable.start))
        if variable.derivative_of:
            kind.set("derivative", str(position[variable.derivative_of]))


def _add_structure(root: Element, description: ModelDescription, *, native: bool) -> None:
    variables = description.variables
    position = {variable.name: k + 1 for k, variable in enumerate(variables)}
    by_name = {variable.name: variable for variable in variables}
    # at a communication point of co-simulation only the inputs are known
    states = {by_name[name].derivative_of for name in description.derivatives if native}
    known = {
        v.name: position[v.name] for v in variables if v.causality == "input" or v.name in states
    }
    numbers = [str(k) for k in range(len(variables) + 1)]
    at_start = {position[v.name] for v in variables if v.initial == "exact"}
    whole = ({*known.values()}, {*known.values(), *at_start})  # later, and at the start

    def unknowns(title: str, listed: Iterable[FmuVariable], *, initial: bool = False) -> None:
        parent, places = Element(title), position if initial else known
        for v in listed:
            names, kinds = v.dependencies, v.kinds
            if initial:
                names, kinds = v.initial_dependencies, v.initial_kinds
            element = SubElement(parent, "Unknown", index=str(position[v.name]))
            if names is None:
                continue
            pairs = zip(names, kinds or [""] * len(names), strict=True)
            chosen = sorted([(places[n], kind) for n, kind in pairs if n in places])
            long = len(chosen) > LONG
            plain = long and all(kind == KINDS[-1] for _, kind in chosen)
            if plain and whole[initial] <= {place for place, _ in chosen}:
                continue
            element.set("dependencies", " ".join([numbers[place] for place, _ in chosen]))
            if kinds is not None and not plain:
                element.set("dependenciesKind", " ".join([kind for _, kind in chosen]))
        if len(parent):
            structure.append(parent)

    structure = SubElement(root, "ModelStructure")
    rates = [by_name[name] for name in description.derivatives if native]
    shown = [v for v in variables if v.causality in ("output", "calculatedParameter")]
    unknowns("Outputs", (v for v in shown if v.causality == "output"))
    unknowns("Derivatives", rates)
    local = [v for v in rates if v.causality == "local"]
    first = sorted((*shown, *local), key=lambda v: position[v.name])
    unknowns("InitialUnknowns", (v for v in first if v.initial != "exact"), initial=True)
