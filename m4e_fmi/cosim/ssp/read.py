"""Reading an SSP package: a System whose FMUs stay in the archive until they are needed.

Systems inside systems are flattened: the component `mass` of the system `left` is `left_mass`. What
is not understood is an error, or one of the system's `notes`.
"""

from __future__ import annotations

import json
import math
import pathlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from m4e_fmi.cosim.ssp.elements import Node, Path, Signal, SignalPath, follow, read_edges, read_tree
from m4e_fmi.cosim.ssp.package import (
    OSP_SPACE,
    OWN,
    SSC,
    SSD,
    SSD_FILE,
    Definition,
    Element,
    Package,
    read_units,
    unpack_member,
)
from m4e_fmi.cosim.ssp.parameters import Value, bound_parameters, targets
from m4e_fmi.cosim.system.component import Component, FmuFile
from m4e_fmi.cosim.system.connection_text import ConnectionText
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.system.system import Action, System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import SAME_UNIT, Wiring
from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.files.locks import TemporaryFolder
from m4e_fmi.fmu.importer.reading import Description, read_description
from m4e_fmi.units import Unit

COMPONENT_KEYS = ("step_size", "dependencies")
"""Keys of components in our own annotation."""
STOP_TIME, STEPS = 1.0, 500
"""Where a package names none: the stop time [s], and the number of steps."""


def read_ssp(path: str | pathlib.Path) -> System:
    """The system in an SSP 1.0 package; InputError with all problems found in it.

    A package says nothing about steps. Ours do, in an annotation; of any other the step is 1/500 of
    the time, which a note tells.
    """
    package = Package(path)
    root = package.xml(SSD_FILE, SSD)
    units = read_units(root)
    tree = read_tree(package, root, units)
    of_signals: dict[Signal, Definition] = {
        (node.path, name): connector.unit
        for node in tree.nodes()
        for name, connector in node.connectors.items()
        if connector.unit is not None
    }
    parts = list(tree.components())
    names = _flat_names(package, parts)
    descriptions = _read_fmus(package, parts)
    added = {n.path: _compared(package, n, descriptions.get(n.path), of_signals) for n in parts}
    flows = follow(package, read_edges(package, tree), of_signals.get)
    start = _start(package, tree, flows, descriptions, units)
    inputs, outputs = _outside(package, tree, flows, names)
    simulation = _simulation(package, root)
    links = [f for f in flows if f.start[0] in names and f.end[0] in names]
    connections = tuple(dict.fromkeys(_text(flow, names) for flow in links))
    InputError.raise_for(dict.fromkeys(package.problems))
    title = root.get("name")
    name = re.sub(r'[/\\:*?"<>|\x00-\x1f]', "_", title).strip(". ") or "system"
    if name != title:
        package.note(f"system {title!r} is called {name!r} here")
    system = System(
        name=name,
        components=tuple(
            Component(
                names[node.path],
                FmuFile(package.path, node.member),
                start.get(node.path, {}),
                added[node.path],
                **{k: v for k, v in _annotation(node.element).items() if k in COMPONENT_KEYS},
            )
            for node in parts
        ),
        connections=connections,
        simulation=simulation,
        description=root.get("description") or tree.element.get("description") or "",
        inputs=inputs,
        outputs=outputs,
        scenario=_scenario(package, _annotation(root)),
        notes=tuple(package.notes),
        folder=package.path.parent,
    )
    found = zip(system.components, (descriptions[node.path] for node in parts), strict=True)
    described = {component.name: component.described(d) for component, d in found}
    return _as_written(package, system, _annotation(root), described)


def _as_written(
    package: Package,
    system: System,
    told: Mapping[str, Any],
    descriptions: Mapping[str, Description],
) -> System:
    """The system with the texts of connections that its annotation tells of.

    They are taken if they mean the same as the package's connections, which have no delays.
    """
    connections = told.get("connections")
    if not connections:
        return system
    try:
        whole = replace(system, connections=tuple(map(str, connections)))
        if _alike(connect(whole, descriptions), connect(system, descriptions)):
            return whole
    except (InputError, TypeError):
        pass  # what stands alone is checked when the system is prepared
    package.note(
        "its connections are not those with which it was written: each variable is connected "
        "alone, without delays"
    )
    return replace(system, notes=tuple(package.notes))


def _alike(one: Wiring, other: Wiring) -> bool:
    """True if two wirings carry the same values, but for delays."""
    mine, others = ({k.ends: k for k in wiring.all_links} for wiring in (one, other))
    return mine.keys() == others.keys() and all(
        math.isclose(link.factor, others[ends].factor, rel_tol=SAME_UNIT)
        and math.isclose(link.offset, others[ends].offset, rel_tol=SAME_UNIT, abs_tol=SAME_UNIT)
        for ends, link in mine.items()
    )


def _flat_names(package: Package, parts: Iterable[Node]) -> dict[Path, str]:
    """A name for every component: its path joined by underscores, with letters and digits only."""
    names: dict[Path, str] = {}
    for node in parts:
        plain = re.sub(r"\W", "_", "_".join(node.path))
        plain = f"_{plain}" if plain[:1].isdigit() else plain
        name, count = plain, 1
        while name in names.values():
            count += 1
            name = f"{plain}_{count}"
        names[node.path] = name
        if name != ".".join(node.path):
            package.note(f"component {'.'.join(node.path)!r} is called {name!r} here")
    return names


def _read_fmus(package: Package, parts: Iterable[Node]) -> dict[Path, Description]:
    """Descriptions of the FMUs; those that cannot be read are among the problems."""
    known: dict[str, Description | None] = {"": None}
    found = {}
    with TemporaryFolder() as folder:
        for node in parts:
            if node.member not in known:
                try:
                    copy = unpack_member(package.path, node.member, folder)
                    known[node.member] = read_description(copy)
                except InputError as error:
                    file = f"{package.path}/{node.member}"
                    package.problems += [replace(p, file=file) for p in error.problems]
                    known[node.member] = None
            description = known[node.member]
            if description is not None:
                found[node.path] = description
    return found


def _compared(
    package: Package,
    node: Node,
    description: Description | None,
    of_signals: dict[Signal, Definition],
) -> dict[str, Unit]:
    """Units that the package adds to the variables of a component's FMU.

    Adds the units of the FMU's own to `of_signals`; problems where both say otherwise.
    """
    added: dict[str, Unit] = {}
    for name, connector in node.connectors.items() if description else ():
        assert description is not None
        variable = description.variables.get(name)
        if variable is None:
            remedy = suggestion(name, description.variables, "variables")
            message = f"the FMU of {node.path[-1]!r} has no variable {name!r}"
            package.reject(connector.element, message, remedy)
            continue
        told = f"connector {name!r} of {node.path[-1]!r}"
        if connector.kind != variable.causality:
            message = f"{told} is {connector.kind}, in its FMU {variable.causality}"
            package.reject(connector.element, message, "correct the kind")
        if connector.type not in (None, variable.type):
            message = f"{told} is {connector.type}, in its FMU {variable.type}"
            package.reject(connector.element, message, "correct the type")
        given, dimension = connector.unit, variable.dimension
        if dimension is not None:
            of_signals.setdefault((node.path, name), Definition(dimension, variable.offset))
        if given is None:
            continue
        if dimension is None:
            added[name] = given.unit
        elif (
            not given.unit.same_dimension(dimension)
            or abs(given.unit.factor / dimension.factor - 1) > 1e-9
            or given.offset != variable.offset
        ):
            message = f"{told} is in {given.unit.text}, in its FMU {variable.unit}"
            package.reject(connector.element, message, "correct the unit")
    return added


def _start(
    package: Package,
    tree: Node,
    flows: Iterable[SignalPath],
    descriptions: dict[Path, Description],
    units: dict[str, Definition],
) -> dict[Path, dict[str, Value]]:
    """Start values of all components; bindings further out come later and win."""
    leads_to: dict[Signal, list[Signal]] = {}
    for flow in flows:
        if flow.is_plain:
            for at in (flow.start, *flow.passed):
                leads_to.setdefault(at, []).append(flow.end)
    start: dict[Path, dict[str, Value]] = {}
    for node in tree.nodes():
        for parameter in bound_parameters(package, node, units):
            found = targets(node, parameter.name, leads_to)
            found = [(p, n) for p, n in found or () if p in descriptions]
            known = [(p, n) for p, n in found if n in descriptions[p].variables]
            for path, name in known:
                try:
                    value = parameter.for_variable(descriptions[path].variables[name])
                except ValueError as error:
                    package.reject(parameter.element, *error.args)
                else:
                    start.setdefault(path, {})[name] = value
            if not known:
                where = ".".join(node.path) or "the system"
                message = f"parameter {parameter.name!r} of {where} reaches no variable"
                package.note(f"{message}: it is left out")
    return start


def _outside(
    package: Package, tree: Node, flows: Iterable[SignalPath], names: dict[Path, str]
) -> tuple[dict[str, tuple[str, ...]], dict[str, str]]:
    """The root system's own inputs and outputs, and what they stand for."""
    inputs: dict[str, list[str]] = {}
    outputs: dict[str, str] = {}
    for flow in flows:
        (origin, name), (sink, variable) = flow.start, flow.end
        if (origin == ()) == (sink == ()):
            continue
        if not flow.is_plain:
            message = f"the system's own {name if origin == () else variable!r} is transformed"
            package.reject(flow.element, message, "connect it as it is")
        elif origin == () and sink in names:
            inputs.setdefault(name, []).append(f"{names[sink]}.{variable}")
        elif sink == () and origin in names:
            outputs[variable] = f"{names[origin]}.{name}"
    for name, connector in tree.connectors.items():
        if name not in inputs and name not in outputs:
            package.note(f"the system's own {connector.kind} {name!r} is connected to nothing")
    return {name: tuple(ports) for name, ports in inputs.items()}, outputs


def _text(flow: SignalPath, names: dict[Path, str]) -> str:
    (origin, output), (sink, taken) = flow.start, flow.end
    return str(
        ConnectionText(
            f"{names[origin]}.{output}",
            f"{names[sink]}.{taken}",
            factor=flow.factor,
            offset=flow.offset,
            units_ignored=flow.units_ignored,
        )
    )


def _annotation(element: Element) -> dict[str, Any]:
    """Content of our own annotation of an element, empty without one."""
    for annotation in element.findall(f"{SSD}Annotations/{SSC}Annotation"):
        if annotation.get("type") == OWN and len(annotation):
            try:
                found = json.loads(annotation[0].text or "")
            except ValueError:
                return {}
            return found if isinstance(found, dict) else {}
    return {}


def _scenario(package: Package, told: Mapping[str, Any]) -> dict[str, Action]:
    """The scenario in our own annotation, as SSP has no word for one; a note if it is not one."""
    written = told.get("scenario", {})
    try:
        return {str(name): Action.model_validate(keys) for name, keys in dict(written).items()}
    except (ValidationError, TypeError, ValueError):
        package.note("its scenario is not one that is understood here: it is left out")
        return {}


def _simulation(package: Package, root: Element) -> Simulation:
    """Times of the default experiment, all else from our own annotation."""
    experiment = root.find(f"{SSD}DefaultExperiment")
    given = dict(experiment.attrib) if experiment is not None else {}
    start = float(given.get("startTime", 0.0))
    settings: dict[str, Any] = {
        "start_time": start,
        "stop_time": float(given.get("stopTime", start + STOP_TIME)),
        **_annotation(root).get("simulation", {}),
    }
    if "stopTime" not in given:
        package.note(f"names no stop time: {settings['stop_time']:g} s is taken (--stop-time)")
    step = root.find(f".//{OSP_SPACE}FixedStepAlgorithm")
    if "step_size" not in settings and step is not None:
        settings["step_size"] = step.get("baseStepSize")
    if "step_size" not in settings:
        settings["step_size"] = (settings["stop_time"] - start) / STEPS
        package.note(f"names no step: {settings['step_size']:g} s is taken (--step-size)")
    try:
        return Simulation(**settings)
    except InputError as error:
        package.reject(root, f"its experiment: {error.problems[0].message}")
        return Simulation(STOP_TIME, STOP_TIME / STEPS)
