"""Modules and their imports, read from the sources: those inside functions too."""

from __future__ import annotations

import ast
from collections.abc import Container, Iterator, Mapping
from pathlib import Path

import networkx as nx


def modules(packages: Mapping[str, Path]) -> dict[str, Path]:
    """All modules by their dotted name; `packages` gives folders by the names of packages."""
    found: dict[str, Path] = {}
    for package, folder in packages.items():
        for file in folder.rglob("*.py"):
            parts = (*package.split("."), *file.relative_to(folder).with_suffix("").parts)
            found[".".join(filter(None, parts)).removesuffix(".__init__")] = file
    return found


def graph(modules: Mapping[str, Path]) -> nx.DiGraph:
    """An edge from each module to each of `modules` that it imports."""
    found = nx.DiGraph()
    found.add_nodes_from(modules)
    edges = ((one, other) for one, file in modules.items() for other in _imported(file, modules))
    found.add_edges_from((a, b) for a, b in edges if b in modules and a != b)
    return found


def _imported(file: Path, known: Container[str]) -> Iterator[str]:
    """Modules that a file imports, but not under TYPE_CHECKING."""

    def visit(node: ast.AST) -> Iterator[str]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
                continue
            if isinstance(child, ast.Import):
                yield from (alias.name for alias in child.names)
            elif isinstance(child, ast.ImportFrom) and child.module and not child.level:
                for alias in child.names:
                    name = f"{child.module}.{alias.name}"
                    yield name if name in known else child.module
            yield from visit(child)

    yield from visit(ast.parse(file.read_text(encoding="utf-8")))
