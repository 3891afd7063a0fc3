"""Nothing that a file says is ever run: no call in the sources could do it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = [
    path
    for folder in ("m4e_fmi", "adapters", "fmus")
    for path in sorted((ROOT / folder).rglob("*.py"))
]
RUN_TEXT = {
    "eval", "exec", "compile", "sympify", "parse_expr", "parse_latex", "lambdify", "S",
    "literal_eval", "unsafe_load", "full_load",
}  # fmt: skip
OWN_TEXT = {
    # our own generated text: names in it are indices, never user strings
    ("m4e_fmi/program/python_form.py", "compile"),
    ("m4e_fmi/program/python_form.py", "exec"),
    # our own methods, and patterns
    ("m4e_fmi/runtime/engine.py", "engine.compile"),
}


def calls() -> Iterator[tuple[str, str, ast.Call]]:
    """File, what is called, and the call, of everything with a name to look at."""
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                if name.rpartition(".")[2] in RUN_TEXT and name != "re.compile":
                    yield path.relative_to(ROOT).as_posix(), name, node


def test_text_is_never_run() -> None:
    """SymPy's sympify is called on expressions only: `strict` refuses text."""
    found = set()
    for file, name, call in calls():
        strict = any(
            keyword.arg == "strict" and ast.unparse(keyword.value) == "True"
            for keyword in call.keywords
        )
        if not (name.endswith("sympify") and strict):
            found.add((file, name))
    assert found == OWN_TEXT


def test_yaml_makes_plain_data_only() -> None:
    """The round-trip loader keeps a tag as a word; the other loaders of ruamel may make objects."""
    types = [
        ast.unparse(keyword.value)
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "YAML"
        for keyword in node.keywords
        if keyword.arg == "typ"
    ]
    assert types
    assert set(types) <= {"'rt'", "'safe'"}
