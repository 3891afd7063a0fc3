"""The variables that a user's class declares, checked, with the lines where it does."""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.export.selection import STRUCTURED_NAME
from m4e_fmi.units import parse_unit
from m4e_fmus.python_file.user_class import GROUPS, METHODS, Declared, UserClass

Variables = Mapping[str, Mapping[str, Declared]]
"""Group → name → what is declared."""
ARRAY = re.compile(r"(.+)\[(\d+)\]")
MUTABLE = ("list", "dict", "set", "deque", "ndarray", "bytearray")
MOST = 10_000  # elements of an array
ARGUMENTS = {"start": "v", "rates": "t, v", "calculate": "t, v", "step": "t, h, v"}
"""Arguments of the methods after `self`."""
FORMS = {
    "parameters": "(start, unit) or (start, unit, text)",
    "states": "(start, unit) or (start, unit, text)",
    "inputs": "unit or (unit, text)",
    "outputs": "unit or (unit, text)",
}


class Lines:
    """Where the `source` names things."""

    def __init__(self, source: str) -> None:
        self.tree = ast.parse(source)

    def of(self, name: str, after: int = 0) -> int:
        """The first line from line `after` on with the dict key `name`; else `after`."""
        keys = (
            key.lineno
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Dict)
            for key in node.keys
            if isinstance(key, ast.Constant) and key.value == name and key.lineno >= after
        )
        return min(keys, default=after)

    def of_class(self, name: str) -> int:
        """The line of the class `name`, 0 if it is not in the source."""
        classes = (
            node.lineno
            for node in ast.walk(self.tree)
            if isinstance(node, ast.ClassDef) and node.name == name
        )
        return min(classes, default=0)

    def of_changes(self, method: str) -> tuple[int, str]:
        """The first line of a method that sets an attribute of its object, and its name.

        0 and no name if there is none.
        """
        found = [
            (node.lineno, node.attr)
            for function in ast.walk(self.tree)
            if isinstance(function, ast.FunctionDef) and function.name == method
            for node in ast.walk(function)
            if isinstance(node, ast.Attribute)
            and isinstance(node.ctx, ast.Store)
            and isinstance(node.value, ast.Name)
            and node.value.id in [argument.arg for argument in function.args.args[:1]]
        ]
        return min(found, default=(0, ""))


def declared(user: UserClass, path: Path, lines: Lines) -> Variables:
    """The variables of the class by group and name, arrays by the name without brackets.

    InputError with all problems, each with its line in `path`.
    """
    problems: list[Problem] = []
    found: dict[str, dict[str, Declared]] = {}
    for group in GROUPS:
        table = getattr(user.kind, group, {})
        if not isinstance(table, Mapping):
            text = f"{group} of the class {user.kind.__name__} is no dict by name"
            line = lines.of_class(user.kind.__name__)
            problems.append(Problem(text, f"write {{name: {FORMS[group]}}}", str(path), line))
            table = {}
        found[group] = {}
        for name, given in table.items():
            variable, wrong = _variable(str(name), given, group)
            problems += [Problem(*w, str(path), lines.of(str(name))) for w in wrong]
            found[group][variable.name] = variable
    line = lines.of_class(user.kind.__name__)
    problems += [Problem(*w, str(path), line) for w in _contradictions(user, found)]
    problems += [
        Problem(*w, str(path), user.line(method))
        for method in METHODS
        for w in _calls(user, method)
    ]
    InputError.raise_for(problems)
    return found


def _calls(user: UserClass, method: str) -> Iterator[tuple[str, str]]:
    """Messages and remedies if the `method` is there and cannot be called as it will be."""
    function = getattr(user.object, method, None)
    if not inspect.isroutine(function):
        return
    arguments, form = ARGUMENTS[method], f"write {method}(self, {ARGUMENTS[method]})"
    given = arguments.split(", ")
    try:
        names = list(inspect.signature(function).bind(*given).arguments)
    except TypeError:
        yield f"{method} does not take {arguments} after self", form
        return
    except ValueError:  # of a function in C
        return
    if names != given and sorted(names) == sorted(given):
        yield f"{method} takes {', '.join(names)} in this order", form


def _variable(name: str, given: object, group: str) -> tuple[Declared, list[tuple[str, str]]]:
    """The declared variable, and messages and remedies of what is wrong with it."""
    wrong: list[tuple[str, str]] = []
    array = ARRAY.fullmatch(name)
    base, count = (array[1], int(array[2])) if array else (name, None)
    if not STRUCTURED_NAME.fullmatch(base) or (count is not None and not 0 < count <= MOST):
        wrong.append((f"{name!r} is not a name", "write it like power, rod.vz or tension[3]"))
    said = (given,) if isinstance(given, str) else given
    if group in ("inputs", "outputs") and isinstance(said, tuple):
        said = (0.0, *said)
    start, unit, text = 0.0, "1", ""
    match said:
        case (int() | float() as start, str(unit)):
            pass
        case (int() | float() as start, str(unit), str(text)):
            pass
        case _:
            wrong.append((f"{name!r} of {group} is {given!r}", f"write {FORMS[group]}"))
    if not math.isfinite(start):
        wrong.append((f"{name!r} starts with {start}", "give a finite number"))
    try:
        parse_unit(unit)
    except ValueError as error:
        wrong.append((f"{name!r}: {error}", "write it like N.s/m, rad/s or 1"))
    return Declared(base, unit, text, float(start), count), wrong


def _contradictions(
    user: UserClass, found: Mapping[str, Mapping[str, Declared]]
) -> Iterator[tuple[str, str]]:
    """Messages and remedies of what does not fit together in a class."""
    seen: dict[str, str] = {}
    for group, variables in found.items():
        for name in variables:
            if name in seen:
                yield f"{name!r} is in {seen[name]} and in {group}", "give each its own name"
            seen[name] = group
    if found["states"] and not user.has("rates"):
        yield "there are states and no method rates(self, t, v)", "add it: it returns their rates"
    if user.has("rates") and not found["states"]:
        yield "there is a method rates and no states", "declare states = {name: (start, unit)}"
    if user.has("rates") and user.has("step"):
        remedy = "keep rates for states that follow from them, or step for what is your own"
        yield "there are both of rates and step", remedy
    if found["outputs"] and not (user.has("calculate") or user.has("step")):
        yield "there are outputs and no method that returns them", "add calculate(self, t, v)"
    if not found["outputs"]:
        yield "the class declares no outputs", "write outputs = {name: unit}"
    if user.has("save") != user.has("restore"):
        yield "save and restore belong together", "write both of them, or none"
    for name, value in vars(user.kind).items():
        kind = type(value).__name__
        if name not in GROUPS and kind in MUTABLE and name[0] != "_":
            text = f"{user.kind.__name__}.{name} is a {kind} of the class, which is not saved"
            yield text, f"set self.{name} in start(self, v)"
        near = suggestion(name, [*GROUPS, *METHODS])
        if near.startswith("did you mean") and name not in (*GROUPS, *METHODS) and name[0] != "_":
            yield f"{user.kind.__name__}.{name} means nothing here", near
