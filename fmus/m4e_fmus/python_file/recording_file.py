"""The user's file with functions that record: `math`, `min` and `max` of what it imports and calls.

An equality, a branch or a conversion to a number cannot be recorded; nor can an object that changes
while it computes.
"""

from __future__ import annotations

import ast
import builtins
import math
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import reduce
from types import ModuleType
from typing import NoReturn

from m4e_fmi.program import Scalar, functions
from m4e_fmi.program.functions import AnyScalar

RECORDED = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "tanh", "exp", "log", "sqrt")


class CannotBeRecordedError(Exception):
    """Code that has no form as straight-line arithmetic; the text says where and why."""


def prepare(module: ModuleType) -> None:
    """Let the code of `module`, which is to be run, meet the functions that record."""
    substitute = ModuleType("math")
    vars(substitute).update(vars(math))
    vars(substitute).update({name: getattr(functions, name) for name in RECORDED})
    vars(substitute)["fabs"] = abs

    usual = builtins.__import__

    def importing(name: str, *where: AnyScalar) -> ModuleType:
        return substitute if name == "math" else usual(name, *where)

    vars(module)["__builtins__"] = {
        **vars(builtins),
        "__import__": importing,
        "min": _extreme(functions.minimum),
        "max": _extreme(functions.maximum),
    }


def _extreme(of_two: Callable[[AnyScalar, AnyScalar], AnyScalar]) -> Callable[..., AnyScalar]:
    def of_all(*values: AnyScalar) -> AnyScalar:
        (several,) = values if len(values) == 1 else (values,)
        return reduce(of_two, several)

    return of_all


def check(source: str) -> None:
    """CannotBeRecordedError for what a recording would take for something else, with its line.

    Objects that record are not of the type float.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Match):
            raise CannotBeRecordedError(f"line {node.lineno} matches patterns")
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "type"):
            raise CannotBeRecordedError(f"line {node.lineno} asks for a type")


@contextmanager
def nothing_is_equal() -> Generator[None]:
    """Meanwhile a scalar that records can be compared with nothing, nor looked up in a dict."""

    def refused(*_: object) -> NoReturn:
        raise TypeError("a recorded scalar cannot be compared, as in `if x == 0` or `table[x]`")

    usual = {name: getattr(Scalar, name) for name in ("__eq__", "__ne__", "__hash__")}
    for name in usual:
        setattr(Scalar, name, refused)
    try:
        yield
    finally:
        for name, function in usual.items():
            setattr(Scalar, name, function)
