"""Writing a prepared system as an SSP package.

Every connected variable becomes a connector, every link a connection; start values go into a
parameter set for each component, where most tools look for them. What SSP has no place for is in
annotations: connections as they were written (``a.m <-> b.end``), how to step, the components' own
steps included, and the scenario; the system's step alone also in the words of the Open Simulation
Platform.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lxml import etree

from m4e_fmi.cosim.ssp.package import (
    FMU_TYPES,
    OSP,
    OSP_SPACE,
    OWN,
    PARAMETER_FILE,
    SSC,
    SSD,
    SSD_FILE,
    SSV,
    VERSION,
    Definition,
    Element,
    write_units,
)
from m4e_fmi.cosim.system.connection_text import parse_connection
from m4e_fmi.cosim.system.start_values import start_values
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.files.writing import written
from m4e_fmi.fmu.importer.opening import opened
from m4e_fmi.fmu.importer.reading import Variable

EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time stamp in the archive: the same system gives the same bytes."""
_JSON = "{urn:m4e_fmi}json"


def write_ssp(prepared: Prepared, path: str | Path) -> Path:
    """Write the system with all its FMUs to `path`; RunError if that cannot be written."""
    path = Path(path)
    told: dict[str, Any] = {}
    scenario = {
        name: action.model_dump(mode="json", by_alias=True, exclude_none=True, exclude_unset=True)
        for name, action in prepared.system.scenario.items()
    }
    if scenario:
        told["scenario"] = scenario
    parameters, descriptions = _parameter_sets(prepared), prepared.descriptions
    shared: dict[Path, str] = {}  # of components with one FMU
    resources = {
        name: shared.setdefault(description.path.resolve(), f"resources/{name}.fmu")
        for name, description in descriptions.items()
    }
    with written(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        _add(archive, SSD_FILE, _xml(_description(prepared, resources, set(parameters), told)))
        for name, element in parameters.items():
            _add(archive, PARAMETER_FILE.format(name), _xml(element))
        for file, description in {resources[n]: d for n, d in descriptions.items()}.items():
            with opened(description.path, description.content) as fmu:
                _add(archive, file, fmu.read(), zipfile.ZIP_STORED)
    return path


def _add(
    archive: zipfile.ZipFile, name: str, content: bytes, packing: int = zipfile.ZIP_DEFLATED
) -> None:
    archive.writestr(zipfile.ZipInfo(name, EPOCH), content, packing)


def _xml(root: Element) -> bytes:
    return etree.tostring(root, encoding="UTF-8", xml_declaration=True, pretty_print=True)


def _variable(prepared: Prepared, port: Port) -> Variable:
    return prepared.descriptions[port.component].variables[port.variable]


def _description(
    prepared: Prepared,
    resources: dict[str, str],
    with_parameters: set[str],
    told: dict[str, Any],
) -> Element:
    system = prepared.system
    # libcosim and Ecos know the namespaces by these prefixes, declared here
    spaces = {"ssd": SSD[1:-1], "ssc": SSC[1:-1], "ssv": SSV[1:-1], "osp": OSP_SPACE[1:-1]}
    root = etree.Element(
        f"{SSD}SystemStructureDescription", nsmap=spaces, version=VERSION, name=system.name
    )
    if system.description:
        root.set("description", system.description)
    root.set("generationTool", OWN)
    element = etree.SubElement(root, f"{SSD}System", name=system.name)
    ports = _connected(prepared)
    items = dict.fromkeys(tuple(_variable(prepared, port).items.items()) for port in ports)
    enumerations = {found: f"enumeration {k}" for k, found in enumerate(filter(None, items), 1)}
    stand_for = {name: texts[0] for name, texts in system.inputs.items()} | dict(system.outputs)
    own = ((name, _variable(prepared, Port.named(text))) for name, text in stand_for.items())
    _connectors(element, own, enumerations)
    elements = etree.SubElement(element, f"{SSD}Elements")
    components = {component.name: component for component in system.components}
    for name, file in resources.items():
        component = etree.SubElement(
            elements,
            f"{SSD}Component",
            name=name,
            source=file,
            type=FMU_TYPES[0],
            implementation="CoSimulation",
        )
        found = ((p.variable, _variable(prepared, p)) for p in ports if p.component == name)
        _connectors(component, found, enumerations)
        if name in with_parameters:
            bindings = etree.SubElement(component, f"{SSD}ParameterBindings")
            source = PARAMETER_FILE.format(name)
            etree.SubElement(bindings, f"{SSD}ParameterBinding", source=source)
        needs = {output: list(n) for output, n in components[name].dependencies.items()}
        keys = {"step_size": components[name].step_size, "dependencies": needs}
        if keys := {key: value for key, value in keys.items() if value}:
            _annotate(component, keys)  # for which SSP has no place
    connections = _connections(prepared, element)
    if connections:
        told = {"connections": connections, **told}
    if enumerations:
        parent = etree.SubElement(root, f"{SSD}Enumerations")
        for numbers, name in enumerations.items():
            kind = etree.SubElement(parent, f"{SSC}Enumeration", name=name)
            for item, number in numbers:
                etree.SubElement(kind, f"{SSC}Item", name=item, value=str(number))
    write_units(root, _units(prepared, ports))
    _experiment(prepared, root, told)
    return root


def _connected(prepared: Prepared) -> list[Port]:
    """All variables that connections lead to or from, and those the package gives units to."""
    ports = {port for link in prepared.wiring.all_links for port in link.ends}
    system = prepared.system
    for text in (*system.outputs.values(), *(t for texts in system.inputs.values() for t in texts)):
        ports.add(Port.named(text))
    ports |= {Port(c.name, variable) for c in system.components for variable in c.units}
    return sorted(ports)


Enumerations = dict[tuple[tuple[str, int], ...], str]
"""Items and their numbers → the name that the package gives to the enumeration."""


def _connectors(
    parent: Element, variables: Iterable[tuple[str, Variable]], enumerations: Enumerations
) -> None:
    connectors = None
    for name, variable in variables:
        if connectors is None:
            connectors = etree.SubElement(parent, f"{SSD}Connectors")
        element = etree.SubElement(
            connectors, f"{SSD}Connector", name=name, kind=variable.causality
        )
        kind = etree.SubElement(element, f"{SSC}{variable.type}")
        if variable.type == "Real" and variable.dimension is not None:
            kind.set("unit", variable.unit)
        elif variable.type == "Enumeration":
            kind.set("name", enumerations[tuple(variable.items.items())])


def _connections(prepared: Prepared, parent: Element) -> list[str]:
    """Write all links; texts of connections that mean the same."""
    system, links = prepared.system, prepared.wiring.all_links
    outer = [(None, name, *text.split(".", 1)) for name, t in system.inputs.items() for text in t]
    outer += [(*text.split(".", 1), None, name) for name, text in system.outputs.items()]
    if not links and not outer:
        return []
    connections = etree.SubElement(parent, f"{SSD}Connections")
    for ends in outer:
        _connection(connections, *ends)
    texts: list[str] = []
    for index, text in enumerate(system.connections):
        members = [link for link in links if link.connection == index]
        written = parse_connection(text)
        for link in members:
            ends = (text for port in link.ends for text in (port.component, port.variable))
            element = _connection(connections, *ends)
            if written.units_ignored:
                element.set("suppressUnitConversion", "true")
            if (written.factor, written.offset) != (1.0, 0.0):
                given = {"factor": repr(written.factor), "offset": repr(written.offset)}
                etree.SubElement(element, f"{SSC}LinearTransformation", given)
        texts.append(text)
    return texts


def _connection(parent: Element, *ends: str | None) -> Element:
    element = etree.SubElement(parent, f"{SSD}Connection")
    keys = "startElement", "startConnector", "endElement", "endConnector"
    for key, value in zip(keys, ends, strict=True):
        if value is not None:
            element.set(key, value)
    return element


def _annotate(parent: Element, content: dict[str, Any]) -> None:
    annotations = etree.SubElement(parent, f"{SSD}Annotations")
    annotation = etree.SubElement(annotations, f"{SSC}Annotation", type=OWN)
    element = etree.SubElement(annotation, _JSON, nsmap={None: "urn:m4e_fmi"})
    element.text = json.dumps(content)


def _units(prepared: Prepared, ports: Iterable[Port]) -> dict[str, Definition]:
    found = {}
    for port in ports:
        variable = _variable(prepared, port)
        if variable.type == "Real" and variable.dimension is not None:
            found[variable.unit] = Definition(variable.dimension, variable.offset)
    return found


def _experiment(prepared: Prepared, root: Element, told: dict[str, Any]) -> None:
    """The default experiment, and in our annotation how to step and what else is `told`."""
    simulation = prepared.system.simulation
    times = {"startTime": repr(simulation.start_time), "stopTime": repr(simulation.stop_time)}
    experiment = etree.SubElement(root, f"{SSD}DefaultExperiment", times)
    annotations = etree.SubElement(experiment, f"{SSD}Annotations")
    annotation = etree.SubElement(annotations, f"{SSC}Annotation", type=OSP)
    algorithm = etree.SubElement(annotation, f"{OSP_SPACE}Algorithm")
    size = repr(simulation.step_size)
    etree.SubElement(algorithm, f"{OSP_SPACE}FixedStepAlgorithm", baseStepSize=size)
    given = {
        key: value
        for key, value in asdict(simulation).items()
        if value is not None and key not in ("start_time", "stop_time")
    }
    _annotate(root, {"simulation": given, **told})


def _parameter_sets(prepared: Prepared) -> dict[str, Element]:
    """The start values of each component that has any, in its FMU's own units."""
    found = {}
    for component in prepared.system.components:
        description = prepared.descriptions[component.name]
        values = start_values(component, description)
        if not values:
            continue
        spaces = {"ssv": SSV[1:-1], "ssc": SSC[1:-1]}
        names = {"version": VERSION, "name": "parameters"}
        root = etree.Element(f"{SSV}ParameterSet", names, nsmap=spaces)
        parameters = etree.SubElement(root, f"{SSV}Parameters")
        for name, value in values.items():
            element = etree.SubElement(parameters, f"{SSV}Parameter", name=name)
            variable = description.variables[name]
            _value(etree.SubElement(element, f"{SSV}{variable.type}"), variable, value)
        found[component.name] = root
    return found


def _value(element: Element, variable: Variable, value: float | int | bool | str) -> None:
    if variable.type == "Real":
        element.set("value", repr(float(value)))
    elif variable.type == "Boolean":
        element.set("value", "true" if value else "false")
    elif variable.type == "Enumeration":
        names = {number: name for name, number in variable.items.items()}
        element.set("value", names.get(int(value), str(value)))
    else:
        element.set("value", str(value))
