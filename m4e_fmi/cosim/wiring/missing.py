"""Inputs, outputs, components and parameters that seem to be left without a connection.

An input that is not connected keeps its start value. That is reported, unless it is intended: a
value is given under `start:`, or in the configuration of the component, the input is one of the
system's own `inputs`, or it is an *idle load*: a force, moment or effort on a body, point or joint
of a multibody FMU that is 0, as most of them are in any system. An idle load is reported only where
something else says that it should be connected:

- its connector is connected in part, and the other side has an output of its name;
- a component takes inputs, and its outputs, of which one has the load's dimension, lead nowhere.

A component without any connection is reported as well, and a calculated parameter that is not
carried to a parameter of its name. A connector is the variables whose names are equal up to their
last dot.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Port, Wiring
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.shown import first_of

IDLE = re.compile(r"(body|point|joint)\..+\.(force|moment|effort)(_[xyz]|[123])?(\[.*\])?")
SHOWN = 4
"""Inputs of one component that a warning names; `info` shows all."""

Descriptions = Mapping[str, Description]


def unfed(system: System, wiring: Wiring) -> list[Port]:
    """Inputs without a connection and without a given value."""
    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {
        Port(c.name, f"{c.source.name}.{key}")  # as direction of kind: wind for wind.direction
        for c in system.components
        if isinstance(c.source, Kind)
        for key in c.source.config.model_fields_set
    }
    given |= {Port.named(text) for ts in system.inputs.values() for text in ts}
    return [port for port in wiring.unconnected if port not in given]


def is_idle_load(port: Port, descriptions: Descriptions) -> bool:
    """True if an input without a given value is a load of a multibody FMU, which is 0."""
    variable = descriptions[port.component].variables[port.variable]
    return bool(IDLE.fullmatch(port.variable)) and _number(variable) == 0.0


def loose_ends(system: System, descriptions: Descriptions, wiring: Wiring) -> list[str]:
    """Warnings of inputs and links that seem to be left out, one line each."""
    ports = unfed(system, wiring)
    loads = [port for port in ports if is_idle_load(port, descriptions)]
    idle, others = set(loads), dict[str, list[Port]]()
    for port in ports:
        if port not in idle:
            others.setdefault(port.component, []).append(port)
    outputs = {Port.named(text) for text in system.outputs.values()}
    outer = {Port.named(text) for texts in system.inputs.values() for text in texts} | outputs
    ends = {port for link in wiring.all_links for port in link.ends}
    linked = {port.component for port in ends | outer}
    fed_by_nobody = [
        _fed_by_nobody(descriptions[name], found)
        for name, found in others.items()
        if name in linked
    ]
    halves = dict(_halves(descriptions, wiring, loads))
    half_lines = [
        f"{load} is connected to nothing, though {load.connector} and {source.connector} are "
        f"connected by other variables: '{source} -> {load}' seems to be left out"
        for load, source in halves.items()
    ]
    giving = {link.source.component for link in wiring.all_links}
    giving |= {port.component for port in (*outputs, *halves.values())}
    dead_ends = [
        f"{name} takes inputs, but none of its outputs is connected, and loads of {load.component} "
        "are connected to nothing; if it only watches, name its outputs under outputs:"
        for name in descriptions
        if name in linked and name not in giving
        for load in _loads_of(name, descriptions, loads)
    ]
    return [*_alone(descriptions, linked), *fed_by_nobody, *half_lines, *dead_ends]


def start_text(variable: Variable) -> str:
    """The start value of a variable with its unit."""
    number = _number(variable)
    value = f"{number:g}" if number is not None else variable.start or "none"
    return f"{value} {variable.unit}".rstrip() if variable.unit not in ("", "1") else value


def _number(variable: Variable) -> float | None:
    try:
        return float(variable.start or 0.0)
    except ValueError:  # of a Boolean or String
        return None


def fits(output: Variable, target: Variable) -> bool:
    """True if the input `target` may take the value of `output`, by type and unit."""
    if output.type != target.type:
        return False
    a, b = output.dimension, target.dimension
    return a is None or b is None or a.same_dimension(b)


def _alone(descriptions: Descriptions, linked: set[str]) -> Iterator[str]:
    """Warnings of components without any connection, where there are several components."""
    alone = [
        name
        for name, description in descriptions.items()
        if name not in linked and description.of_causality("input", "output")
    ]
    if len(descriptions) < 2:
        return
    if alone and not linked:
        yield f"{', '.join(alone)}: no component is connected with another"
        return
    for name in alone:
        yield f"{name} is connected with nothing: it does not interact with the others"


def _fed_by_nobody(description: Description, ports: list[Port]) -> str:
    """The warning of the unconnected inputs `ports` of one component."""
    names: dict[str, str] = {}
    for port in ports:
        base, bracket, _ = port.variable.partition("[")
        name = f"{base}[…]" if bracket else base
        names.setdefault(name, start_text(description.variables[port.variable]))
    if len(names) == 1:
        ((name, value),) = names.items()
        return (
            f"{ports[0].component}.{name} is connected to nothing and runs on its start value "
            f"{value}: connect it, or set it under start: if that is meant"
        )
    shown = first_of((f"{name} ({value})" for name, value in names.items()), SHOWN)
    return (
        f"{ports[0].component}: {len(names)} inputs are connected to nothing and run on their "
        f"start values, {shown}: connect them, or set them under start: if that is "
        "meant"
    )


def _halves(
    descriptions: Descriptions, wiring: Wiring, loads: list[Port]
) -> Iterator[tuple[Port, Port]]:
    """Loads of connectors that are connected in part, each with the output of the other side."""
    pairs = {
        (here.connector, there.connector)
        for link in wiring.links
        for here, there in (link.ends, link.ends[::-1])
    }
    for load in loads:
        last = load.variable.rpartition(".")[2]
        wanted = descriptions[load.component].variables[load.variable]
        for there in sorted(there for here, there in pairs if here == load.connector):
            source = Port(there.component, f"{there.variable}.{last}")
            known = descriptions[there.component].variables.get(source.variable)
            if known is not None and known.causality == "output" and fits(known, wanted):
                yield load, source
                break


def _loads_of(name: str, descriptions: Descriptions, loads: list[Port]) -> list[Port]:
    """The first idle load, if any, that an output of a component could drive."""
    outputs = descriptions[name].of_causality("output")
    return [
        load
        for load in loads
        if any(fits(v, descriptions[load.component].variables[load.variable]) for v in outputs)
    ][:1]


def unconnected_parameters(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> list[str]:
    """Warnings of calculated parameters that are not carried to another component, one line each.

    The other component has a parameter of the same name, added mass for example, which would be
    left at its start value. So are matrices that are outputs.
    """
    taken = {link.source for link in wiring.all_links}
    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in wiring.all_links}
    calculated, varying, wanted = (
        [
            (component, *variable.name.partition("["))
            for component, description in descriptions.items()
            for variable in description.of_causality(causality)
            if Port(component, variable.name) not in done
        ]
        for causality, done in (
            ("calculatedParameter", taken), ("output", taken), ("parameter", given)
        )
    )  # fmt: skip
    offered = [(c, name) for c, name, *_ in (*calculated, *(one for one in varying if one[2]))]
    others = dict.fromkeys((c, name) for c, name, *_ in wanted)
    return [
        f"{source}.{name} is calculated, but not transferred: '{source}.{name} -> {target}.{name}'"
        for source, name in dict.fromkeys(offered)
        for target, other in others
        if name == other and source != target
    ]
