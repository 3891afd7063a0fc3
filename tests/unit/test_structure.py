"""The order of packages and rooms, without circles, and the size of folders."""

from __future__ import annotations

import ast
import re
from collections import Counter
from functools import cache
from pathlib import Path

import networkx as nx
import pytest
from support import import_graph

ROOT = Path(__file__).parents[2]
PACKAGES = {
    "m4e_fmi": ROOT / "m4e_fmi",
    "m4e_adapters": ROOT / "adapters" / "m4e_adapters",
    "m4e_fmus": ROOT / "fmus" / "m4e_fmus",
}
MOST_MODULES = 15
LAYERS = {
    "m4e_fmi": (
        "signals threads lazy units errors shown files coupling_algorithms program space joints "
        "model multibody results statistics runtime simulate fmu analysis code_hash doctor report "
        "cosim study notebook cli __main__"
    ),
    "m4e_fmi.fmu": "importer export kind validation",
    "m4e_fmi.cosim": (
        "system wiring scenario ssp system_file network "
        "preparation composition results stepping algorithms error time_loop monitoring "
        "run save"
    ),
}
"""Parts of each package: a part imports those before it only."""


@cache
def modules() -> dict[str, Path]:
    return import_graph.modules(PACKAGES)


@cache
def graph() -> nx.DiGraph:
    return import_graph.graph(modules())


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


def test_no_module_imports_private_names_of_another() -> None:
    private = re.compile(r"^ *from m4e_[\w.]+ import (?:\([^)]*|.*)\b_[a-z]\w*", re.MULTILINE)
    found = {name: private.findall(file.read_text("utf-8")) for name, file in modules().items()}
    assert {name: lines for name, lines in found.items() if lines} == {}


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
    named = [re.sub("^m4e_fmi/(m4e_fmi|tests|adapters)/", r"\1/", name) for name in named]
    assert len(named) > 20
    assert [name for name in named if not (ROOT / name).exists()] == []
    rooms = LAYERS["m4e_fmi.cosim"].split()
    assert [room for room in rooms if room != "save" and f"`{room}" not in text] == []
