"""Elements of an SSP package: connectors with types and units, and the flow between them.

Connectors of systems only pass values on: they are followed back from every input to the
output at the other end, factors and offsets of the connections on the way multiplied and added.
A value that begins at a system's connector is that system's input.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from m4e_fmi.cosim.ssp.package import (
    FMU_TYPES,
    OSP,
    OWN,
    SSC,
    SSD,
    Definition,
    Element,
    Package,
    unit_named,
)

Path = tuple[str, ...]
"""Names of the elements from below the root system down."""
Signal = tuple[Path, str]
"""A connector, by its element's path and its name."""
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration", "Binary")
ROLES = {"input": "in", "parameter": "in", "output": "out", "calculatedParameter": "out"}
UnitOf = Callable[[Signal], Definition | None]
"""The unit that a signal is known to be in."""


@dataclass(frozen=True)
class Connector:
    """A variable at the edge of an element; `type` and `unit` are None where nothing is said."""

    kind: str
    type: str | None
    unit: Definition | None
    element: Element


@dataclass
class Node:
    """An element: a system with `children`, or a component with a `member`."""

    what: Literal["System", "Component"]
    path: Path
    element: Element
    connectors: dict[str, Connector]
    children: dict[str, Node] = field(default_factory=dict)
    member: str = ""

    def components(self) -> Iterator[Node]:
        """All components in it, in the order of the file."""
        for child in self.children.values():
            if child.what == "Component":
                yield child
            yield from child.components()

    def nodes(self) -> Iterator[Node]:
        """Itself and all below it, deepest first."""
        for child in self.children.values():
            yield from child.nodes()
        yield self


def read_tree(package: Package, root: Element, units: Mapping[str, Definition]) -> Node:
    """The root system; what cannot be read is among the package's problems."""
    for element in root.iter():
        if element.tag == f"{SSC}Annotation" and element.get("type") not in (OWN, OSP):
            package.note(f"annotations of type {element.get('type')!r} are left out")
    return _system(package, root.find(f"{SSD}System"), (), units)


def _system(
    package: Package, element: Element, path: Path, units: Mapping[str, Definition]
) -> Node:
    node = Node("System", path, element, _connectors(package, element, units))
    inside = element.find(f"{SSD}Elements")
    for child in inside if inside is not None else ():
        name = child.get("name")
        below = (*path, name)
        if name in node.children:
            package.reject(child, f"two elements are called {name!r}", "rename one of them")
        elif child.tag == f"{SSD}System":
            node.children[name] = _system(package, child, below, units)
        elif child.tag == f"{SSD}Component":
            member = _member(package, child)
            connectors = _connectors(package, child, units)
            node.children[name] = Node("Component", below, child, connectors, member=member)
        else:
            message = f"{name!r} refers to a signal dictionary, which is not read"
            package.reject(child, message, "connect the components with one another")
    return node


def _member(package: Package, element: Element) -> str:
    """The FMU of a component, empty without a usable one."""
    kind = element.get("type", FMU_TYPES[0])
    name = element.get("name")
    if kind not in FMU_TYPES:
        remedy = "put the referenced package into this one, as a system"
        package.reject(element, f"component {name!r} is not an FMU but {kind!r}", remedy)
        return ""
    if element.get("implementation", "any") == "ModelExchange":
        message = f"component {name!r} is to be used for model exchange"
        package.reject(element, message, "only FMUs for co-simulation are coupled")
    return package.member(element, element.get("source")) or ""


def _connectors(
    package: Package, element: Element, units: Mapping[str, Definition]
) -> dict[str, Connector]:
    found: dict[str, Connector] = {}
    for item in element.findall(f"{SSD}Connectors/{SSD}Connector"):
        types = [t for t in TYPES if item.find(f"{SSC}{t}") is not None]
        unit = None
        if types == ["Real"] and (text := item.find(f"{SSC}Real").get("unit")):
            try:
                unit = unit_named(text, units)
            except ValueError as error:
                package.reject(item, f"{error}", "define it among the file's Units")
        name = item.get("name")
        if name in found:
            package.reject(item, f"two connectors are called {name!r}", "rename one")
        found[name] = Connector(item.get("kind"), types[0] if types else None, unit, item)
    return found


@dataclass(frozen=True)
class SignalPath:
    """`end` = `factor` · `start` + `offset`, after unit conversion: a connection, or several.

    `passed` are the connectors between the two, from the end back; `element` has the connection
    that begins at the start.
    """

    start: Signal
    end: Signal
    factor: float
    offset: float
    units_ignored: bool
    element: Element
    passed: tuple[Signal, ...] = ()

    @property
    def is_plain(self) -> bool:
        """True if the value arrives unchanged."""
        return (self.factor, self.offset, self.units_ignored) == (1.0, 0.0, False)


def read_edges(package: Package, system: Node) -> list[SignalPath]:
    """All connections of a system and those below it."""
    edges = []
    for node in system.nodes():
        for element in node.element.findall(f"{SSD}Connections/{SSD}Connection"):
            edge = _edge(package, node, element)
            if edge is not None:
                edges.append(edge)
    return edges


def _edge(package: Package, system: Node, element: Element) -> SignalPath | None:
    ends = [_end(package, system, element, side) for side in ("start", "end")]
    if None in ends:
        return None
    (start, gives), (end, takes) = (e for e in ends if e is not None)
    if gives == "in" or takes == "out":
        if gives == "out" or takes == "in":
            message = f"{_dotted(start)} and {_dotted(end)} are connected, but both "
            message += "take" if gives == "in" else "give"
            package.reject(element, message + " a value", "connect an output with an input")
            return None
        start, end = end, start
    factor, offset = 1.0, 0.0
    for child in element:
        if child.tag == f"{SSC}LinearTransformation":
            factor = float(child.get("factor", 1.0))
            offset = float(child.get("offset", 0.0))
        elif str(child.tag).endswith("MappingTransformation"):
            message = f"{child.tag.removeprefix(SSC)} on the connection to {_dotted(end)}"
            package.reject(element, message, "only linear transformations of Reals are read")
    ignored = element.get("suppressUnitConversion", "false") in ("true", "1")
    return SignalPath(start, end, factor, offset, ignored, element)


def _end(package: Package, system: Node, element: Element, side: str) -> tuple[Signal, str] | None:
    """The signal at one end of a connection, and whether it takes a value there or gives one."""
    owner, name = element.get(f"{side}Element") or None, element.get(f"{side}Connector")
    node = system if owner is None else system.children.get(owner)
    if node is None or name not in node.connectors:
        what = f"element {owner!r}" if node is None else f"connector {name!r}"
        where = "" if node is None or owner is None else f" of {owner!r}"
        package.reject(element, f"a connection leads to an unknown {what}{where}")
        return None
    role = ROLES.get(node.connectors[name].kind, "both")
    if owner is None and role != "both":
        role = "out" if role == "in" else "in"  # what comes into a system is given inside it
    return (node.path, name), role


def follow(package: Package, edges: list[SignalPath], units: UnitOf) -> list[SignalPath]:
    """The flow into every signal that passes nothing on; problems where one has two sources."""
    into: dict[Signal, SignalPath] = {}
    for edge in edges:
        other = into.setdefault(edge.end, edge)
        if other is not edge:
            message = f"{_dotted(edge.end)} has two sources: {_dotted(other.start)} and "
            package.reject(edge.element, message + _dotted(edge.start), "drop one connection")
    passing = {edge.start for edge in edges}
    flows = []
    for sink in into:
        if sink not in passing:
            flow = _flow(package, into, sink, units)
            if flow is not None:
                flows.append(flow)
    return flows


def _flow(
    package: Package, into: dict[Signal, SignalPath], sink: Signal, units: UnitOf
) -> SignalPath | None:
    edges: list[SignalPath] = []
    at = sink
    while at in into:
        if into[at] in edges:
            package.reject(into[at].element, f"connections lead from {_dotted(at)} back to itself")
            return None
        edges.append(into[at])
        at = into[at].start
    ignored = {edge.units_ignored for edge in edges}
    if len(ignored) > 1:
        message = f"units are converted on a part of the way to {_dotted(sink)} only"
        package.reject(edges[-1].element, message, "set suppressUnitConversion on all or none")
        return None
    factor, offset = 1.0, 0.0
    for edge in edges:
        if edge.offset:
            converted = not (True in ignored or edge.end == sink)  # it is in the sink's unit there
            scale = _scale(units(edge.end) or units(at), units(sink)) if converted else 1.0
            if scale is None or (units(edge.end) is None and scale != 1.0):
                message = f"an offset on the way to {_dotted(sink)}, where the unit is not known"
                remedy = "give the connector at the end of this connection its unit"
                package.reject(edge.element, message, remedy)
                return None
            offset += factor * scale * edge.offset
        factor *= edge.factor
    passed = tuple(edge.end for edge in edges[1:])
    return SignalPath(at, sink, factor, offset, ignored.pop(), edges[-1].element, passed)


def _scale(give: Definition | None, take: Definition | None) -> float | None:
    """Factor between two units, None if it is unknown or no factor."""
    if give is None and take is None:
        return 1.0
    if give is None or take is None or give.offset != take.offset:
        return None
    if not give.unit.same_dimension(take.unit):
        return None
    return give.unit.factor / take.unit.factor


def _dotted(signal: Signal) -> str:
    return ".".join((*signal[0], signal[1]))
