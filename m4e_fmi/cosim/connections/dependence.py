"""Inputs that an output depends on within an instant, and the source of that knowledge.

`Description.dependencies` of a prepared system holds them, from the first of these sources that
exists:

===========  ===================================================================================
`STATED`     the system file declares it, under `dependencies` of the component
`DECLARED`   the FMU declares it
`PROBED`     the FMU declares nothing; inputs were moved, and the output read
             (`dependence_probing`). It may be incomplete: `late_dependence` goes on watching
`STEPPED`    likewise, but a change of the input shows after the next step: one step late
`ASSUMED`    nothing is known: the output is taken to depend on all inputs
===========  ===================================================================================
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description

DECLARED = "declared by its FMU"
STATED = "declared in the system file"
PROBED = "probed"
STEPPED = "probed; one step late"
ASSUMED = "assumed"


def how_known(description: Description, output: str) -> str:
    """The source of an output's dependencies: one of the constants of this module."""
    if output in description.resolved:
        return description.resolved[output]
    return ASSUMED if output in description.undeclared else DECLARED


def assumed(description: Description) -> frozenset[str]:
    """Outputs with unknown dependencies."""
    return frozenset(
        variable.name
        for variable in description.of_causality("output")
        if how_known(description, variable.name) == ASSUMED
    )


def resolve(
    description: Description, found: Mapping[str, Iterable[str]], how: Mapping[str, str]
) -> Description:
    """The description with the dependencies `found` of some outputs, and `how` they are known."""
    needs = {name: frozenset(inputs) for name, inputs in found.items()}
    return replace(
        description,
        dependencies={**description.dependencies, **needs},
        resolved={**description.resolved, **how},
    )


def with_stated(system: System, descriptions: Mapping[str, Description]) -> dict[str, Description]:
    """The descriptions with the dependencies that the system file declares."""
    found = dict(descriptions)
    for component in system.components:
        needs = component.dependencies
        if needs:
            how = dict.fromkeys(needs, STATED)
            found[component.name] = resolve(found[component.name], needs, how)
    return found


def dependency_problems(
    system: System, descriptions: Mapping[str, Description]
) -> Iterable[Problem]:
    """Names under `dependencies` that are not outputs, or not inputs, of the component."""
    for component in system.components:
        description = descriptions[component.name]
        outputs, inputs = (
            [v.name for v in description.of_causality(kind)] for kind in ("output", "input")
        )
        for output, needs in component.dependencies.items():
            at = ("components", component.name, "dependencies", output)
            if output not in outputs:
                remedy = suggestion(output, outputs, "outputs")
                yield system.problem(at, f"{component.name!r} has no output {output!r}", remedy)
            for name in needs:
                if name not in inputs:
                    remedy = suggestion(name, inputs, "inputs")
                    message = f"{component.name!r} has no input {name!r}, on which {output} depends"
                    yield system.problem(at, message, remedy)
