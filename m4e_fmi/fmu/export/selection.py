"""Which outputs of a program an FMU shows, and by which names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.program import TIME, Program, Tape, Variable

GROUPS = ("parameters", "calculated", "inputs", "states", "outputs")
_NAME = r"(?:[A-Za-z_][A-Za-z0-9_]*|'(?:[^'\\]|\\.)+')"
_PART = rf"{_NAME}(?:\[\d+(?:,\d+)*\])?"
STRUCTURED_NAME = re.compile(rf"{_PART}(?:\.{_PART})*")
"""FMI 2.0.4, section 2.2.9, without derivatives."""


def matching(variables: Iterable[Variable], patterns: Iterable[str], noun: str) -> set[str]:
    """Names of the `variables` that match one of the shell `patterns`; InputError if one matches
    nothing. `noun` is what one of the variables is called."""
    names = [v.name for v in variables]
    found: set[str] = set()
    problems = []
    for pattern in patterns:
        matches = {name for name in names if fnmatchcase(name, pattern)}
        found |= matches
        if not matches:
            remedy = suggestion(pattern, names, f"{noun}s")
            problems.append(Problem(f"no {noun} matches {pattern!r}", remedy))
    InputError.raise_for(problems)
    return found


def with_outputs(program: Program, patterns: Iterable[str]) -> Program:
    """`program` with those outputs only that match one of the shell `patterns`; others are not
    computed. States stay, but are `local` unless they match. InputError if one matches nothing."""
    chosen = matching([*program.states, *program.outputs], patterns, "output")
    kept = [k for k, v in enumerate(program.outputs) if v.name in chosen]
    gone = {v.name for v in program.outputs} - chosen

    def linked(v: Variable) -> Variable:
        return replace(v, derivative_of=None) if v.derivative_of in gone else v

    return replace(
        program,
        inputs=tuple(linked(v) for v in program.inputs),
        states=tuple(
            replace(linked(v), local=v.local or v.name not in chosen) for v in program.states
        ),
        outputs=tuple(linked(program.outputs[k]) for k in kept),
        results=tuple(program.results[k] for k in kept),
    )


def renamed(program: Program, names: Mapping[str, str]) -> Program:
    """`program` with other names for variables, old → new; ``der(old)`` becomes ``der(new)``.

    ``body.hull.*`` → ``ship.*`` renames all that begin with ``body.hull.``. The tape has the same
    nodes, of other symbols; the result does not know how its rates were solved for. InputError if
    there is no old name, or if a new one is taken or no structured name of FMI.
    """
    if not names:
        return program
    names = _checked(program, names)
    table = {**names, **{f"der({old})": f"der({new})" for old, new in names.items()}}

    def named(v: Variable) -> Variable:
        name, of = table.get(v.name, v.name), v.derivative_of
        return replace(v, name=name, derivative_of=table.get(of, of) if of else None)

    tape = Tape()
    for operation in program.tape.operations:
        if operation[0] == "symbol":
            operation = ("symbol", table.get(operation[1], operation[1]))
        tape.node(operation)
    groups = {group: tuple(map(named, getattr(program, group))) for group in GROUPS}
    return replace(program, tape=tape, solutions=(), **groups)  # pyrefly: ignore[bad-argument-type]


def _checked(program: Program, names: Mapping[str, str]) -> dict[str, str]:
    """`names` with a line for each variable; InputError with all that is wrong with them."""
    known: list[str] = [v.name for group in GROUPS for v in getattr(program, group)]
    table: dict[str, str] = {}
    problems = []
    for old, new in names.items():
        if old.endswith(".*") and new.endswith(".*"):
            stem = old[:-1]
            found = {name: new[:-1] + name[len(stem) :] for name in known if name.startswith(stem)}
        else:
            found = {old: new} if old in known else {}
        two = sorted(name for name in found.keys() & table.keys() if found[name] != table[name])
        problems += [
            Problem(f"{name!r} would get two names: {table[name]!r}, {found[name]!r}")
            for name in two
        ]
        table |= found
        if not found:
            remedy = suggestion(old, known, "variables")
            problems.append(Problem(f"{program.name} has no variable {old!r} to rename", remedy))
        if TIME in found.values():
            remedy = "it is the independent variable of every FMU"
            problems.append(Problem(f"{TIME!r} is a reserved name", remedy))
        if not all(STRUCTURED_NAME.fullmatch(name) for name in found.values()):
            remedy = "write letters, digits and _, parts separated by dots, as in arm.tip[2].x"
            problems.append(Problem(f"{new!r} cannot name a variable of an FMU", remedy))
    after = [table.get(name, name) for name in known]
    twice = sorted({name for name in after if after.count(name) > 1})
    problems += [Problem(f"two variables would be called {name!r}") for name in twice]
    InputError.raise_for(problems)
    return table
