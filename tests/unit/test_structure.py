"""The order of packages and rooms, without circles, and the size of folders."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = {
    "m4e_fmi": ROOT / "m4e_fmi",
    "m4e_adapters": ROOT / "adapters" / "m4e_adapters",
    "m4e_fmus": ROOT / "fmus" / "m4e_fmus",
}
MOST_MODULES = 15
LAYERS = {
    "m4e_fmi": (
        "signals units errors files shown coupling_algorithms program model multibody results "
        "runtime simulate fmu analysis code_hash doctor report cosim cli"
    ),
    "m4e_fmi.fmu": "importer export validation",
    "m4e_fmi.cosim": (
        "system connections input_checks ssp system_file load exchange preparation results "
        "stepping algorithms time_loop error_estimate monitoring master save"
    ),
}
"""What a package consists of: each part imports those before it only."""


@cache
def modules() -> dict[str, Path]:
    """All modules by their dotted name."""
    found: dict[str, Path] = {}
    for package, folder in PACKAGES.items():
        for file in folder.rglob("*.py"):
            parts = (package, *file.relative_to(folder).with_suffix("").parts)
            found[".".join(parts).removesuffix(".__init__")] = file
    return found


def imported(module: str) -> Iterator[str]:
    """The modules of ours that one imports, lazily too, but not under TYPE_CHECKING."""

    def visit(node: ast.AST) -> Iterator[str]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
                continue
            if isinstance(child, ast.Import):
                yield from (alias.name for alias in child.names)
            elif isinstance(child, ast.ImportFrom) and child.module and not child.level:
                for alias in child.names:
                    name = f"{child.module}.{alias.name}"
                    yield name if name in modules() else child.module
            yield from visit(child)

    yield from visit(ast.parse(modules()[module].read_text(encoding="utf-8")))


@cache
def graph() -> nx.DiGraph:
    """An edge from each module to each that it imports."""
    found = nx.DiGraph()
    found.add_nodes_from(modules())
    edges = ((one, other) for one in modules() for other in imported(one))
    found.add_edges_from((a, b) for a, b in edges if b in modules() and a != b)
    return found


def test_no_modules_import_each_other_in_a_circle() -> None:
    circles = [sorted(c) for c in nx.strongly_connected_components(graph()) if len(c) > 1]
    assert circles == []


@pytest.mark.parametrize("package", LAYERS)
def test_parts_import_only_those_before_them(package: str) -> None:
    order = {name: k for k, name in enumerate(LAYERS[package].split())}

    def part(module: str) -> str:
        rest = module.removeprefix(f"{package}.")
        return "" if rest == module else rest.partition(".")[0]

    edges = [(part(a), part(b), a, b) for a, b in graph().edges if part(a) and part(b)]
    assert {name for a, b, *_ in edges for name in (a, b)} <= order.keys()
    assert [f"{a} imports {b}" for one, other, a, b in edges if order[one] < order[other]] == []


def test_folders_are_small_and_say_what_lives_there() -> None:
    files = [file for file in modules().values() if file.name != "__init__.py"]
    counts = Counter(file.parent.relative_to(ROOT).as_posix() for file in files)
    assert {name: n for name, n in counts.items() if n > MOST_MODULES} == {}
    rooms = {file.parent / "__init__.py" for file in files}
    silent = [
        r for r in rooms if not r.is_file() or not ast.get_docstring(ast.parse(r.read_text()))
    ]
    assert silent == []


def test_all_files_that_the_architecture_page_names_exist() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    named = re.findall(r"`((?:m4e_fmi|adapters|fmus|tests)/[^`]*)`", text)
    named += [f"m4e_fmi/{name}" for name in re.findall(r"(?<![/\w])(?:\w+/)+\w+\.py", text)]
    named = [
        n.replace("m4e_fmi/m4e_fmi/", "m4e_fmi/").replace("m4e_fmi/tests/", "tests/") for n in named
    ]
    assert len(named) > 20
    assert [name for name in named if not (ROOT / name).exists()] == []
    rooms = LAYERS["m4e_fmi.cosim"].split()
    assert [room for room in rooms if room != "save" and f"`{room}" not in text] == []
