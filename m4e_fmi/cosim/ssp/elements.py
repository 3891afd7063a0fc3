"""Elements of an SSP package: systems and components."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from m4e_fmi.cosim.ssp.names import FMU_TYPES, GRAPHICS, OSP, OWN, SSC, SSD
from m4e_fmi.cosim.ssp.package import Element, Package
from m4e_fmi.cosim.ssp.units import Definition, unit_named

Path = tuple[str, ...]
"""Names of the elements from below the root system down."""
Signal = tuple[Path, str]
"""A connector, by its element's path and its name."""
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration", "Binary")
ROLES = {"input": "in", "parameter": "in", "output": "out", "calculatedParameter": "out"}


@dataclass(frozen=True)
class Connector:
    """A variable at the edge of an element; `type` and `unit` are None where nothing is said."""

    name: str
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

    def signal(self, name: str) -> Signal:
        """The signal of a connector."""
        return (self.path, name)

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


@dataclass
class _Reader:
    package: Package
    units: dict[str, Definition]


def read_tree(
    package: Package, root: Element, units: dict[str, Definition]
) -> tuple[Node, dict[Signal, Definition]]:
    """The root system and the units of its signals, as far as the file names them.

    What cannot be read is among the package's problems.
    """
    for element in root.iter():
        if element.tag in {f"{SSD}{name}" for name in GRAPHICS}:
            package.note("geometry and graphics are left out")
        if element.tag == f"{SSC}Annotation" and element.get("type") not in (OWN, OSP):
            package.note(f"annotations of type {element.get('type')!r} are left out")
    reader = _Reader(package, units)
    system = _system(reader, root.find(f"{SSD}System"), ())
    of_signals = {
        (node.path, name): connector.unit
        for node in system.nodes()
        for name, connector in node.connectors.items()
        if connector.unit is not None
    }
    return system, of_signals


def _system(reader: _Reader, element: Element, path: Path) -> Node:
    node = Node("System", path, element, _connectors(reader, element))
    inside = element.find(f"{SSD}Elements")
    for child in inside if inside is not None else ():
        name = child.get("name")
        below = (*path, name)
        if name in node.children:
            reader.package.reject(child, f"two elements are called {name!r}", "rename one of them")
        elif child.tag == f"{SSD}System":
            node.children[name] = _system(reader, child, below)
        elif child.tag == f"{SSD}Component":
            member = _member(reader.package, child)
            connectors = _connectors(reader, child)
            node.children[name] = Node("Component", below, child, connectors, member=member)
        else:
            message = f"{name!r} refers to a signal dictionary, which is not read"
            reader.package.reject(child, message, "connect the components with one another")
    return node


def _member(package: Package, element: Element) -> str:
    """The FMU of a component, empty if there is none that can be used."""
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


def _connectors(reader: _Reader, element: Element) -> dict[str, Connector]:
    found = {}
    for item in element.findall(f"{SSD}Connectors/{SSD}Connector"):
        types = [t for t in TYPES if item.find(f"{SSC}{t}") is not None]
        unit = None
        if types == ["Real"]:
            unit = _unit(reader, item, item.find(f"{SSC}Real").get("unit"))
        name = item.get("name")
        if name in found:
            reader.package.reject(item, f"two connectors are called {name!r}", "rename one")
        type_ = types[0] if types else None
        found[name] = Connector(name, item.get("kind"), type_, unit, item)
    return found


def _unit(reader: _Reader, element: Element, name: str | None) -> Definition | None:
    if not name:
        return None
    try:
        return unit_named(name, reader.units)
    except ValueError as error:
        reader.package.reject(element, f"{error}", "define it among the file's Units")
        return None
