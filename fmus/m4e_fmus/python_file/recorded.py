"""The user's class as a Program: its methods recorded on scalars, and compared with themselves.

The file meets functions that record in place of `math`, `min` and `max`. An equality, a branch or a
conversion to a number cannot be recorded; nor can an object that changes while it computes.
"""

from __future__ import annotations

import ast
import builtins
import math
import random
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from functools import reduce
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from m4e_fmi.program import Program, Recorder, Scalar, Variable, functions
from m4e_fmi.program.functions import AnyScalar
from m4e_fmi.program.tape import evaluated
from m4e_fmus.python_file.declarations import Lines, Variables
from m4e_fmus.python_file.user_class import UserClass, UserCodeError, Value, Values, loaded

RECORDED = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "tanh", "exp", "log", "sqrt")
SPREADS = (0.0, 1.0, 0.1, 1e-2, 1.0, 1e-3, 1.0, 0.1)
"""Of the values around the start values at which program and code are compared, relative."""
CLOSE = 1e-9


class CannotBeRecordedError(Exception):
    """Code that has no form as straight-line arithmetic; the text says where and why."""


def recorded(path: Path, shown: str, *, name: str, variables: Variables, lines: Lines) -> Program:
    """The program of the class in the file; CannotBeRecordedError if it has none."""
    for node in ast.walk(lines.tree):  # objects that record are not of the type float
        if isinstance(node, ast.Match):
            raise CannotBeRecordedError(f"line {node.lineno} matches patterns")
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "type"):
            raise CannotBeRecordedError(f"line {node.lineno} asks for a type")
    seen = Values(
        {k: v for g in ("parameters", "inputs", "states") for k, v in variables[g].items()}
    )
    try:
        user = UserClass(loaded(path, shown, f"recorded_{path.stem}", _prepare), path, shown)
        program = _program(user, seen, name=name, variables=variables, lines=lines)
        user = UserClass(loaded(path, shown, f"compared_{path.stem}"), path, shown)
    except UserCodeError as error:
        raise CannotBeRecordedError(str(error)) from None
    _compare(program, user, seen, variables)
    return program


def _program(
    user: UserClass, seen: Values, *, name: str, variables: Variables, lines: Lines
) -> Program:
    if user.has("step") or user.has("start"):
        raise CannotBeRecordedError("it has a method step or start")
    recorder = Recorder(name, user.kind.__doc__ or f"{user.kind.__name__} of {user.shown}")
    values = {
        element: declare(
            Variable(element, v.unit, v.text, start=v.start, tunable=group == "parameters")
        )
        for group, declare in (
            ("parameters", recorder.parameter),
            ("inputs", recorder.input),
            ("states", recorder.state),
        )
        for v in variables[group].values()
        for element in v.elements
    }
    before = dict(vars(user.object))
    with _nothing_is_equal():
        found = _results(user, variables, recorder.time, seen.filled(values))
    if vars(user.object) != before:
        raise CannotBeRecordedError("its object changes while it computes")
    for v in variables["states"].values():
        for element in v.elements:
            recorder.rate(element, _scalar(found.pop(element), element))
    method = user.line("calculate")
    for v in variables["outputs"].values():
        place = f"{user.shown}:{lines.of(v.name, after=method)}"
        for element in v.elements:
            value = _scalar(found[element], element)
            recorder.output(Variable(element, v.unit, v.made_at(place)), value)
    return recorder.program()


def _results(user: UserClass, variables: Variables, *arguments: Value) -> dict[str, Value]:
    """Rates of all states and all outputs, by element."""
    states, outputs = variables["states"], variables["outputs"]
    rates = user.results("rates", states, *arguments) if states else {}
    return rates | user.results("calculate", outputs, *arguments)


def _scalar(value: Value, name: str) -> Scalar | float:
    if isinstance(value, Scalar):
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise CannotBeRecordedError(f"{name} is {value!r}")
    return number


def _compare(program: Program, user: UserClass, seen: Values, variables: Variables) -> None:
    """CannotBeRecordedError unless the program gives what the code does, at sampled places.

    Where the code fails there is nothing to compare; it must not fail everywhere.
    """
    nodes = [*program.rates, *program.results]
    generator, compared = random.Random(1), 0
    starts = {
        element: v.start
        for group in ("parameters", "inputs", "states")
        for v in variables[group].values()
        for element in v.elements
    }
    for spread in SPREADS:
        values = {
            element: start + spread * generator.gauss(0.0, 1.0) * (abs(start) or 1.0)
            for element, start in starts.items()
        }
        time = 100.0 * generator.random() if spread else 0.0
        own = _numbers(user, variables, time, seen.filled(values))
        given = evaluated(program.tape, nodes, {**values, "time": time}) if own else {}
        compared += bool(own)
        for node, value in zip(nodes, own, strict=False):
            if not abs(value - given[node]) <= CLOSE * (1.0 + abs(value)):  # also if it is nan
                raise CannotBeRecordedError("its results are not those of what it records")
    if not compared:
        raise CannotBeRecordedError("it fails at all values that were tried")


def _numbers(user: UserClass, variables: Variables, time: float, values: Value) -> Sequence[float]:
    """Rates and outputs of the code itself; none where it has none."""
    try:
        numbers = [float(value) for value in _results(user, variables, time, values).values()]
    except (UserCodeError, TypeError, ValueError):
        return []
    return numbers if all(map(math.isfinite, numbers)) else []


def _prepare(module: ModuleType) -> None:
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


@contextmanager
def _nothing_is_equal() -> Generator[None]:
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
