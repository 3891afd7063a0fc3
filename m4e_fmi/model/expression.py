"""Expressions in input files: numbers, declared names, + − * / **, and a fixed list of functions.

A name may have parts with dots in between, as variables of an FMU do.

Text is parsed by the grammar below and nothing else; no user string is ever evaluated as Python.
An `Expression` is then evaluated over any scalar: float, tape, SymPy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

from m4e_fmi import program as functions
from m4e_fmi.errors import suggestion
from m4e_fmi.program import AnyScalar

FUNCTIONS = {
    "abs": abs,
    "acos": functions.acos,
    "asin": functions.asin,
    "atan": functions.atan,
    "atan2": functions.atan2,
    "cos": functions.cos,
    "exp": functions.exp,
    "log": functions.log,
    "max": functions.maximum,
    "min": functions.minimum,
    "sign": functions.sign,
    "sin": functions.sin,
    "sqrt": functions.sqrt,
    "tan": functions.tan,
    "tanh": functions.tanh,
}
TWO_ARGUMENTS = frozenset({"atan2", "max", "min"})
CONSTANTS = {"pi": math.pi}
LONGEST_TEXT = 2000
DEEPEST_NESTING = 200

_GRAMMAR = r"""
    ?sum: product | sum "+" product -> add | sum "-" product -> sub
    ?product: sign | product "*" sign -> mul | product "/" sign -> div
    ?sign: power | "-" sign -> neg | "+" sign
    ?power: atom | atom "**" sign -> pow
    ?atom: NUMBER -> number | NAME "(" sum ("," sum)* ")" -> call | NAME -> name | "(" sum ")"
    NUMBER: /([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?/
    NAME: /[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*/
    %ignore /[ \t]+/
"""
_SIGNS = {"add": "+", "sub": "-", "mul": "*", "div": "/", "pow": "**"}


class ExpressionError(ValueError):
    """The text is no expression of the grammar; `column` counts from 1 within the text."""

    def __init__(self, message: str, column: int = 0, remedy: str = "") -> None:
        self.column, self.remedy = column, remedy
        super().__init__(message)


class Values(dict[str, AnyScalar]):
    """Scalars by name, and how a constant becomes a scalar of the same kind."""

    def __init__(
        self, values: Mapping[str, AnyScalar], *, number: Callable[[float], AnyScalar] = float
    ) -> None:
        super().__init__(values)
        self.number = number


@dataclass(frozen=True)
class Expression:
    """A parsed expression: `kind` is number, name, neg, add, sub, mul, div, pow or a function."""

    kind: str
    arguments: tuple[Any, ...]

    def names(self) -> frozenset[str]:
        """Names that have to be declared for this expression to mean anything."""
        if self.kind == "number":
            return frozenset()
        if self.kind == "name":
            return frozenset(self.arguments) - set(CONSTANTS)
        return frozenset().union(*(a.names() for a in self.arguments))

    def constants(self) -> Iterator[Expression]:
        """The largest parts that need no name to be declared."""
        if not self.names():
            yield self
            return
        for argument in self.arguments:
            if isinstance(argument, Expression):
                yield from argument.constants()

    def evaluate(self, values: Values) -> AnyScalar:
        """The value over whatever scalars `values` holds; KeyError for a name it lacks."""
        if self.kind == "number":
            return values.number(self.arguments[0])
        if self.kind == "name":
            name = self.arguments[0]
            return values.number(CONSTANTS[name]) if name in CONSTANTS else values[name]
        operands = [a.evaluate(values) for a in self.arguments]
        match self.kind:
            case "neg":
                return -operands[0]
            case "add":
                return operands[0] + operands[1]
            case "sub":
                return operands[0] - operands[1]
            case "mul":
                return operands[0] * operands[1]
            case "div":
                return operands[0] / operands[1]
            case "pow":
                return _power(*operands)
            case function:
                return FUNCTIONS[function](*operands)

    def __str__(self) -> str:
        if self.kind == "number":
            return f"{self.arguments[0]:.12g}"
        if self.kind == "name":
            return self.arguments[0]
        if self.kind == "neg":
            return f"(-{self.arguments[0]})"
        if self.kind in _SIGNS:
            return f"({self.arguments[0]} {_SIGNS[self.kind]} {self.arguments[1]})"
        return f"{self.kind}({', '.join(map(str, self.arguments))})"

    def __repr__(self) -> str:
        return f"Expression({self})"


NOTHING = Expression("number", (0.0,))


def negative(e: Expression) -> Expression:
    """−e."""
    return (
        Expression("number", (-e.arguments[0],)) if e.kind == "number" else Expression("neg", (e,))
    )


def _power(base: AnyScalar, exponent: AnyScalar) -> AnyScalar:
    """base ** exponent; of floats, the real power or ValueError, never a complex number."""
    if isinstance(base, int | float) and isinstance(exponent, int | float):
        return math.pow(base, exponent)
    return base**exponent


@lru_cache(maxsize=4096)
def parse(text: str) -> Expression:
    """Parse `text`; ExpressionError says what is wrong and in which column."""
    from lark.exceptions import UnexpectedCharacters, UnexpectedInput

    if len(text) > LONGEST_TEXT:
        raise ExpressionError(f"longer than {LONGEST_TEXT} characters")
    try:
        tree = _parser().parse(text)
    except UnexpectedCharacters as error:
        character = text[error.pos_in_stream or 0]
        hint = "; write ** for a power" if character == "^" else ""
        raise ExpressionError(f"{character!r} has no meaning here{hint}", error.column) from None
    except UnexpectedInput as error:
        if getattr(getattr(error, "token", None), "type", "") == "$END":
            raise ExpressionError("something is missing at the end", len(text)) from None
        raise ExpressionError("this is not an expression", error.column) from None
    return _expression(tree)


@cache
def _parser() -> Any:
    from lark import Lark

    return Lark(_GRAMMAR, start="sum", parser="lalr")


def _expression(tree: Any, depth: int = 1) -> Expression:
    kind, children = tree.data, tree.children
    if depth > DEEPEST_NESTING:
        raise ExpressionError(f"nested more than {DEEPEST_NESTING} deep")
    if kind == "number":
        value = float(children[0])
        if not math.isfinite(value):
            raise ExpressionError(f"{children[0]!s} is too large", children[0].column)
        return Expression("number", (value,))
    if kind == "name":
        return Expression("name", (str(children[0]),))
    if kind != "call":
        return Expression(str(kind), tuple(_expression(c, depth + 1) for c in children))
    token, *arguments = children
    name = str(token)
    if name not in FUNCTIONS:
        remedy = suggestion(name.rpartition(".")[2], FUNCTIONS, "functions")
        raise ExpressionError(f"{name} is not a function here", token.column, remedy)
    expected = 2 if name in TWO_ARGUMENTS else 1
    if len(arguments) != expected:
        raise ExpressionError(f"{name} takes {expected}, got {len(arguments)}", token.column)
    return Expression(name, tuple(_expression(a, depth + 1) for a in arguments))
