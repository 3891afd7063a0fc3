"""Elements of an SSP package: systems and components."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from m4e_fmi.cosim.ssp.package import (
    FMU_TYPES,
    GRAPHICS,
    OSP,
    OWN,
    SSC,
    SSD,
    Element,
    Package,
)
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
        if element.tag in {f"{SSD}{name}" for name in GRAPHICS}:
            package.note("geometry and graphics are left out")
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
        found[name] = Connector(name, item.get("kind"), types[0] if types else None, unit, item)
    return found
