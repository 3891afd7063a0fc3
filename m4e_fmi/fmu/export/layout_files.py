"""The files that tell the shell of an FMI 3.0 FMU which scalars a value reference stands for.

Both are lines of numbers; scalars are numbered as the value references of FMI 2.0 are, time last.
"""

from __future__ import annotations

from collections.abc import Sequence

from m4e_fmi.fmu.export.description.arrays import Grouped, places
from m4e_fmi.fmu.export.description.description import ModelDescription
from m4e_fmi.fmu.export.description.model_description_3 import dependencies
from m4e_fmi.program import TIME

KIND_NUMBERS = {"constant": 1, "fixed": 2, "tunable": 3, "dependent": 5}
"""As fmi3DependencyKind has them."""


def layout_files(description: ModelDescription, variables: Sequence[Grouped]) -> dict[str, bytes]:
    """Name in `resources` → content.

    `variables.txt` has a line for each value reference: its scalars. `dependencies.txt` has one for
    each dependency: value reference and element of what depends, of what it depends on, and how.
    """
    scalars = [v.name for v in description.variables if v.type == "Real"]
    numbers = {name: k for k, name in enumerate([*scalars, TIME])}
    lines = [
        " ".join(str(numbers[m.name]) for m in v.members)
        for v in variables
        if v.first.type == "Real"
    ]
    return {
        "variables.txt": _text(lines),
        "dependencies.txt": _text(_dependency_lines(variables)),
    }


def _dependency_lines(variables: Sequence[Grouped]) -> list[str]:
    place = places(variables)
    lines = []
    for variable in variables:
        initial = variable.first.causality == "calculatedParameter"
        for member in variable.members:
            here = place[member.name]
            for name, kind in dependencies(member, initial=initial).items():
                known = place[name]
                lines.append(
                    f"{here.reference} {here.element} {known.reference} {known.element} "
                    f"{KIND_NUMBERS[kind]}"
                )
    return lines


def _text(lines: Sequence[str]) -> bytes:
    return "".join(f"{line}\n" for line in lines).encode()
