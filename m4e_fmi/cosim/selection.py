"""Which variables a run records."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.reading import Description, Variable


def chosen(
    descriptions: Mapping[str, Description], patterns: Sequence[str]
) -> dict[str, list[Variable]]:
    """The Real variables to be recorded, by component: all scalar outputs, or what is chosen.

    A pattern is ``component.variable``, where ``*`` stands for anything. With one it chooses among
    the outputs, elements of arrays included; without, it may name any Real variable. InputError
    for patterns that choose nothing.
    """
    if not patterns:
        return {
            name: [v for v in _outputs(description) if not v.name.endswith("]")]
            for name, description in descriptions.items()
        }
    found: dict[str, dict[str, Variable]] = {name: {} for name in descriptions}
    problems = []
    for pattern in patterns:
        matches = _matches(descriptions, pattern)
        for component, variable in matches:
            found[component][variable.name] = variable
        if not matches:
            known = [f"{c}.{v.name}" for c, d in descriptions.items() for v in _outputs(d)]
            problems.append(
                Problem(f"no output is called {pattern!r}", suggestion(pattern, known, "outputs"))
            )
    if problems:
        raise InputError(problems)
    return {name: list(members.values()) for name, members in found.items()}


def _outputs(description: Description) -> list[Variable]:
    return [v for v in description.of_causality("output") if v.type == "Real"]


def _matches(descriptions: Mapping[str, Description], pattern: str) -> list[tuple[str, Variable]]:
    exact, _, name = pattern.partition(".")
    if exact in descriptions and name in descriptions[exact].variables:
        variable = descriptions[exact].variables[name]
        return [(exact, variable)] if variable.type == "Real" else []
    # brackets are part of names
    expression = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return [
        (component, v)
        for component, description in descriptions.items()
        for v in _outputs(description)
        if expression.fullmatch(f"{component}.{v.name}")
    ]
