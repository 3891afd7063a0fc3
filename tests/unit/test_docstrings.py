"""Docstrings of everything public, with shape and unit of each array.

The rule for arrays: a docstring gives the shape in round brackets, as in (n,) or (n_times, 6), or
says "scalar" or "shape of"; and the unit in square brackets, as in [m] or [1], or as in "(n,), m"
or "(n,) in m", or says "in … units" or "SI", or the kind of numbers ("indices", "booleans").
Both stand

- of what is returned, in the first paragraph or after the word "Returns";
- of each parameter that is an array, in the paragraph that names it, after its name.

Several arrays may share a shape or a unit: "`position` and `force` (n, 3), in [m] and [N]".

A method without a docstring has that of the method it overrides, as `inspect.getdoc` does it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
ROOTS = "m4e_fmi", "adapters", "fmus"
ARRAYS = frozenset({"NDArray", "ndarray", "ArrayLike"})
LEAST_SHARE, MOST_ANY = 0.95, 150

_ENTRY = r"(?:…|\.\.\.|\w+(?: ?[-+*·/] ?\w+)*)"
SHAPE = re.compile(rf"\({_ENTRY},(?: {_ENTRY}(?:, {_ENTRY})*)?\)|\bscalar|\bshape of\b")
_SYMBOL = r"(?:[mkMGµn]?(?:rad|deg|Hz|Pa|[msgNJWKAV])|%|1)[²³⁴⁵⁶]?"
UNIT = re.compile(
    rf"(?<!\w)\[[^\]]+\]|(?:[,;]|\bin|[,;] in) {_SYMBOL}(?:[/·]{_SYMBOL})*(?![\w'’])"
    r"|\bin (?:[\w'’.-]+ )*units?\b|\bSI\b|\b(?:indices|booleans|codes|bytes)\b"
)


class Definition(NamedTuple):
    """A public function, method or class."""

    place: str
    node: ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
    doc: str
    array_names: frozenset[str]


@cache
def trees() -> dict[str, tuple[str, ast.Module]]:
    """Text and syntax tree of each file, by its path."""
    found: dict[str, tuple[str, ast.Module]] = {}
    for root in ROOTS:
        for file in sorted((ROOT / root).rglob("*.py")):
            name = file.relative_to(ROOT).as_posix()
            text = file.read_text(encoding="utf-8")
            found[name] = text, ast.parse(text)
    return found


@cache
def aliases() -> dict[str, frozenset[str]]:
    """Names of types that contain an array, by the module (dotted) that defines them."""
    found: dict[str, frozenset[str]] = {}
    for path, (_, tree) in trees().items():
        names = [
            node.targets[0].id
            for node in tree.body
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
            if isinstance(node.value, (ast.Subscript, ast.Attribute, ast.BinOp, ast.Name))
            if mentions(node.value, ARRAYS)
        ]
        if names:
            found[module_name(path)] = frozenset(names)
    return found


def mentions(annotation: ast.expr | None, names: frozenset[str]) -> bool:
    """True if one of these names is used in the annotation."""
    nodes = ast.walk(annotation) if annotation else ()
    return any(
        (isinstance(node, ast.Name) and node.id in names)
        or (isinstance(node, ast.Attribute) and node.attr in names)
        for node in nodes
    )


def module_name(path: str) -> str:
    """Dotted name of the module in a file."""
    return re.sub(r"^(adapters|fmus)/|(/__init__)?\.py$", "", path).replace("/", ".")


def array_names(path: str, tree: ast.Module) -> frozenset[str]:
    """Names that stand for types with an array in a file: numpy's, own and imported aliases."""
    found = set(ARRAYS)
    found |= aliases().get(module_name(path), frozenset())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module in aliases():
            theirs = aliases()[node.module]
            found |= {alias.asname or alias.name for alias in node.names if alias.name in theirs}
    return frozenset(found)


def public() -> Iterator[Definition]:
    """All public functions, classes and their public methods; setters and overloads apart."""

    def visit(
        path: str, owner: ast.Module | ast.ClassDef, names: frozenset[str]
    ) -> Iterator[Definition]:
        for node in owner.body:
            if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                continue
            variants = re.compile(r"\.(setter|deleter)$|overload$")
            variant = any(variants.search(ast.unparse(d)) for d in node.decorator_list)
            if node.name.startswith("_") or variant:
                continue
            place = f"{path}:{node.lineno} {node.name}"
            doc = ast.get_docstring(node) or ""
            if not doc and isinstance(owner, ast.ClassDef):
                doc = inherited(path, owner, node.name)
            yield Definition(place, node, doc, names)
            if isinstance(node, ast.ClassDef):
                yield from visit(path, node, names)

    for path, (_, tree) in trees().items():
        yield from visit(path, tree, array_names(path, tree))


def inherited(path: str, owner: ast.ClassDef, method: str) -> str:
    """Docstring of the method of a base class that a method of this class overrides, or ""."""
    for base in owner.bases:
        name = base.value if isinstance(base, ast.Subscript) else base
        found = class_of(path, name.id) if isinstance(name, ast.Name) else None
        if found is not None:
            home, node = found
            own = (n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == method)
            doc = next((d for n in own if (d := ast.get_docstring(n))), "")
            if doc := doc or inherited(home, node, method):
                return doc
    return ""


@cache
def class_of(path: str, name: str) -> tuple[str, ast.ClassDef] | None:
    """A class that a file knows by this name, and the file that defines it; None if not ours."""
    files = {module_name(path): path for path in trees()}
    for node in ast.walk(trees()[path][1]):
        if isinstance(node, ast.ClassDef) and node.name == name:
            return path, node
        if isinstance(node, ast.ImportFrom) and node.module:
            folder = module_name(path).split(".")[: -node.level] if node.level else []
            source = files.get(".".join([*folder, node.module]))
            if source and (known := [a.name for a in node.names if name == (a.asname or a.name)]):
                return class_of(source, known[0])
    return None


def missing(definition: Definition) -> list[str]:
    """Parameters, and "returns", of which a docstring does not give shape and unit."""
    node, doc, names = definition.node, definition.doc, definition.array_names
    if isinstance(node, ast.ClassDef):
        return []
    every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    every += [a for a in (node.args.vararg, node.args.kwarg) if a]
    parameters = [a.arg for a in every if mentions(a.annotation, names)]
    paragraphs = re.split(r"\n\s*\n", doc)
    absent = [
        name
        for name in parameters
        if not any(is_described(rest) for p in paragraphs for rest in after(name, p))
    ]
    returns = doc.partition("Returns")[2]
    told = is_described(paragraphs[0]) or is_described(returns)
    return absent + (["returns"] if mentions(node.returns, names) and not told else [])


def after(name: str, paragraph: str) -> list[str]:
    """The rest of a paragraph after each place where a name stands."""
    return [paragraph[m.end() :] for m in re.finditer(rf"(?<!\w){name}(?!\w)", paragraph)]


def is_described(text: str) -> bool:
    """True if a text gives a shape and a unit."""
    return bool(SHAPE.search(text) and UNIT.search(SHAPE.sub(" ", text)))


def test_no_docstring_begins_with_what_or_whether() -> None:
    wrong = [
        f"{path}:{node.lineno}"
        for path, (_, tree) in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and re.match(r"\s*(What|Whether)\b", str(node.value.value))
    ]
    assert wrong == []


def test_what_is_public_has_docstrings() -> None:
    every = list(public())
    silent = [one.place for one in every if not one.doc]
    assert len(silent) <= (1 - LEAST_SHARE) * len(every), silent


def test_arrays_have_shape_and_unit() -> None:
    wrong = [f"{one.place}: {', '.join(names)}" for one in public() if (names := missing(one))]
    assert wrong == []


def test_any_is_rare() -> None:
    lines = [
        f"{path}:{k}"
        for path, (text, _) in trees().items()
        for k, line in enumerate(text.splitlines(), 1)
        if re.search(r"\bAny\b", line)
    ]
    assert len(lines) <= MOST_ANY, lines


@pytest.mark.parametrize(
    ("signature", "doc", "expected"),
    [
        ("a: np.ndarray", "Mean of `a` (n,) [m].", []),
        ("a: np.ndarray", "Mean of `a` (n_times, 2*m), in the variables' units.", []),
        ("a: np.ndarray", "Mean of `a`.", ["a"]),
        ("a: np.ndarray", "Mean of `a` (n,).", ["a"]),
        ("a: np.ndarray", "Mean of `a` (n, m).", ["a"]),
        ("a: np.ndarray", "Mean of `a` (the first, say) [m].", ["a"]),
        ("a: np.ndarray, b: NDArray[int]", "Products of `a` and `b` (n,) [m].", []),
        ("a: np.ndarray, b: NDArray[int]", "Products of `a` (n,) [m].\n\nTwice `b`.", ["b"]),
        ("a: Floats | None", "Sum.\n\na : (n,), kg/s.", []),
        (") -> (np.ndarray", "Forces (n,) [N].", []),
        (") -> (np.ndarray", "Forces (n,).\n\nRows as in a file [N].", ["returns"]),
        (") -> (np.ndarray", "Forces.\n\nReturns\n-------\n(n,) [N]", []),
        ("a: float", "Half of `a`.", []),
    ],
)
def test_the_rule_for_arrays(signature: str, doc: str, expected: list[str]) -> None:
    arrow = ")" if "->" in signature else ") -> None"
    text = f"def f({signature}{arrow}: ...".replace("(np.ndarray):", "np.ndarray:")
    node = ast.parse(text).body[0]
    assert isinstance(node, ast.FunctionDef)
    one = Definition("f", node, doc, ARRAYS | {"Floats"})
    assert missing(one) == expected
