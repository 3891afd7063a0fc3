"""Which outputs of a program an FMU shows."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from fnmatch import fnmatchcase

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.program import Program, Variable

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
