"""modelDescription.xml of a native FMU of FMI 3.0, for both kinds, and how its sources are built.

Source: FMI Specification 3.0.2, section 2.4. Element order and attributes follow its schema.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement

import m4e_fmi
from m4e_fmi.fmu.export.description.arrays import Grouped, Place, places
from m4e_fmi.fmu.export.description.description import FmuVariable, ModelDescription
from m4e_fmi.fmu.export.description.xml_parts import (
    add_experiment,
    add_quantity,
    add_types,
    add_units,
    legal,
    xml_bytes,
)
from m4e_fmi.fmu.importer.elements import ELEMENTS
from m4e_fmi.program.dependence import KINDS

BUILD = "sources/buildDescription.xml"
EVERYWHERE = {
    "needsExecutionTool": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true",
    "providesAdjointDerivatives": "true",
    "providesPerElementDependencies": "true",
}
STEPPING = {
    "canHandleVariableCommunicationStepSize": "true",
    "maxOutputDerivativeOrder": "1",
    "providesIntermediateUpdate": "true",
    "mightReturnEarlyFromDoStep": "false",
    "canReturnEarlyAfterIntermediateUpdate": "true",
    "hasEventMode": "false",
}


def model_description_3_xml(
    description: ModelDescription,
    variables: Sequence[Grouped],
    *,
    model_identifier: str,
) -> bytes:
    """The XML text (UTF-8) of `description`, whose scalars are grouped into `variables`.

    Its instantiation token is empty: see `with_guid`. ValueError names a unit that is not
    understood.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=description.name,
        instantiationToken="",
        description=legal(description.description),
        generationTool=f"m4e_fmi {m4e_fmi.__version__}",
        variableNamingConvention="structured",
    )
    both = {"modelIdentifier": model_identifier, **EVERYWHERE}
    SubElement(root, "ModelExchange", both)
    SubElement(root, "CoSimulation", {**both, **STEPPING})
    scalars = [member for variable in variables for member in variable.members]
    add_units(root, scalars)
    add_types(root, scalars, "Float64Type")
    add_experiment(root, description)
    place = places(variables)
    parent = SubElement(root, "ModelVariables")
    for variable in variables:
        _add_variable(parent, variable, place)
    _add_structure(root, description, variables)
    return xml_bytes(root)


def build_description_xml(model_identifier: str, sources: Sequence[str]) -> bytes:
    """The XML text (UTF-8) of `BUILD`: how a compiler makes the library of `sources`.

    Source: FMI Specification 3.0.2, section 2.4.10.
    """
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=model_identifier)
    files = SubElement(configuration, "SourceFileSet", language="C11")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return xml_bytes(root)


def _add_variable(parent: Element, variable: Grouped, place: Mapping[str, Place]) -> None:
    first = variable.first
    element = SubElement(
        parent,
        "Float64" if first.type == "Real" else first.type,
        name=variable.name,
        valueReference=str(place[first.name].reference),
        description=legal(variable.description),
        causality=first.causality,
        variability=first.variability,
    )
    if first.initial:
        element.set("initial", first.initial)
    if first.type == "Real":
        _add_numbers(element, variable, place)
    if variable.shape:
        notes = SubElement(element, "Annotations")
        note = SubElement(notes, "Annotation", type=ELEMENTS)
        note.text = "\n".join(f"{member.name}\t{member.unit}" for member in variable.members)
    for size in variable.shape:
        SubElement(element, "Dimension", start=str(size))


def _add_numbers(element: Element, variable: Grouped, place: Mapping[str, Place]) -> None:
    first = variable.first
    if first.variability == "continuous" and first.causality != "independent":
        element.set("intermediateUpdate", "true")
    if variable.unit is not None:
        add_quantity(element, first)
    if first.start is not None:
        element.set("start", " ".join(str(v.start) for v in variable.members))
    if first.derivative_of:
        element.set("derivative", str(place[first.derivative_of].reference))


def _add_structure(
    root: Element, description: ModelDescription, variables: Sequence[Grouped]
) -> None:
    structure = SubElement(root, "ModelStructure")
    place = places(variables)

    def unknowns(title: str, listed: Iterable[Grouped], *, initial: bool = False) -> None:
        for variable in listed:
            kinds = _union(variable, place, initial=initial)
            SubElement(
                structure,
                title,
                valueReference=str(place[variable.first.name].reference),
                dependencies=" ".join(map(str, kinds)),
                dependenciesKind=" ".join(kinds.values()),
            )

    unknowns("Output", [v for v in variables if v.first.causality == "output"])
    rates = state_rates(description, variables)
    unknowns("ContinuousStateDerivative", rates)
    asked = ("output", "calculatedParameter")
    unknowns(
        "InitialUnknown",
        [
            v
            for v in variables
            if v.first.initial != "exact" and (v.first.causality in asked or v in rates)
        ],
        initial=True,
    )


def state_rates(description: ModelDescription, variables: Sequence[Grouped]) -> list[Grouped]:
    """The rates of the states, in the order of the states among `variables`."""
    place = places(variables)
    by_name = {v.name: v for v in description.variables}
    rate_of = {by_name[name].derivative_of: name for name in description.derivatives}
    return [
        variables[place[rate_of[v.first.name]].reference]
        for v in variables
        if v.first.name in rate_of
    ]


def _union(variable: Grouped, place: Mapping[str, Place], *, initial: bool) -> dict[int, str]:
    """Value references of what any element depends on, and how at most, in their order."""
    found: dict[int, str] = {}
    for member in variable.members:
        for name, kind in dependencies(member, initial=initial).items():
            reference = place[name].reference
            found[reference] = max(kind, found.get(reference, KINDS[0]), key=KINDS.index)
    return dict(sorted(found.items()))


def dependencies(variable: FmuVariable, *, initial: bool) -> dict[str, str]:
    """Dependencies of a scalar → their kind; at the start, or later."""
    if initial:
        names, kinds = variable.initial_dependencies, variable.initial_kinds
    else:
        names, kinds = variable.dependencies, variable.kinds
    return dict(zip(names or (), kinds or (), strict=True))
