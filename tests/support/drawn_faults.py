"""Faults drawn at random from all statements of the product: one operator, number or call each."""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FOLDERS = ("m4e_fmi", "adapters", "fmus")
LEFT_OUT = ("templates", "platforms.py")
"""Texts of other projects' starts, and what only a release runs."""
OPPOSITES: dict[type[ast.AST], type[Any]] = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
}  # fmt: skip

Part = ast.expr | ast.stmt


@dataclass(frozen=True)
class DrawnFault:
    """`planted` in place of `original` in a file, whose text begins at the offset `start`."""

    path: Path
    line: int
    start: int
    original: str
    planted: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.original!r} -> {self.planted!r}"

    def plant(self, root: Path) -> str:
        """Write the fault; returns the text without it."""
        text = (root / self.path).read_text("utf-8")
        end = self.start + len(self.original)
        assert text[self.start : end] == self.original
        (root / self.path).write_text(text[: self.start] + self.planted + text[end:], "utf-8")
        return text


def draw(root: Path, count: int, seed: int) -> list[DrawnFault]:
    """`count` faults, each of another statement; all statements are equally likely."""
    chance = random.Random(seed)
    statements = [
        (file, statement)
        for folder in FOLDERS
        for file in sorted((root / folder).rglob("*.py"))
        if not any(part in file.parts for part in LEFT_OUT)
        for statement in inner_statements(ast.parse(file.read_text("utf-8")))
        if next(changes(statement), None)
    ]
    return [
        fault_of(root, file, *chance.choice(list(changes(statement))))
        for file, statement in chance.sample(statements, count)
    ]


def inner_statements(tree: ast.Module) -> list[ast.stmt]:
    """The statements of functions, each once; a function within another is not one itself."""
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    nodes = (node for function in functions for part in function.body for node in ast.walk(part))
    found = {id(node): node for node in nodes if isinstance(node, ast.stmt)}
    for function in functions:
        found.pop(id(function), None)
    return list(found.values())


def changes(statement: ast.stmt) -> Iterator[tuple[Part, Part]]:
    """Parts of a statement itself, not of statements within, and what stands in their place."""
    if isinstance(statement, ast.Expr):
        if isinstance(statement.value, ast.Call):
            yield statement, ast.Pass()
        return
    below = [n for n in ast.iter_child_nodes(statement) if isinstance(n, ast.expr)]
    if isinstance(statement, ast.AnnAssign):
        below = [statement.value] if statement.value else []
    if isinstance(statement, ast.If | ast.While):
        yield statement.test, ast.UnaryOp(ast.Not(), statement.test)
    for part in (node for expression in below for node in ast.walk(expression)):
        if isinstance(part, ast.expr) and (changed := changed_part(part)):
            yield part, changed


def changed_part(part: ast.expr) -> ast.expr | None:
    """The expression with its operator turned, or its number or truth value changed."""
    match part:
        case ast.Compare(ops=[operator]) if type(operator) in OPPOSITES:
            return ast.Compare(part.left, [OPPOSITES[type(operator)]()], part.comparators)
        case ast.BinOp() if type(part.op) in OPPOSITES:
            return ast.BinOp(part.left, OPPOSITES[type(part.op)](), part.right)
        case ast.BoolOp():
            return ast.BoolOp(OPPOSITES[type(part.op)](), part.values)
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            return operand
        case ast.Constant(value=bool(value)):
            return ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            return ast.Constant(value + 1 if isinstance(value, int) else 2 * value or 1.0)
        case _:
            return None


def fault_of(root: Path, file: Path, part: Part, changed: Part) -> DrawnFault:
    text = file.read_text("utf-8")
    original = ast.get_source_segment(text, part) or ""
    lines = text.splitlines(keepends=True)
    first = lines[part.lineno - 1].encode()[: part.col_offset].decode()
    start = sum(map(len, lines[: part.lineno - 1])) + len(first)
    planted = ast.unparse(ast.fix_missing_locations(changed))
    planted = planted if isinstance(changed, ast.Pass) else f"({planted})"
    return DrawnFault(file.relative_to(root), part.lineno, start, original, planted)
