"""Bodies with ``mass: neutral``, which need the mass of the water that they displace.

The FMU of such a body has a parameter ``body.<name>.neutral_mass`` without a value. A hydrodynamics
component calculates one of that name for each of its bodies, which a connection of the two bodies
(``buoy.float <-> hydro.float``) carries over.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator, Mapping, Sequence

from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem
from m4e_fmi.fmu.importer.reading import Description, Variable

WANTED = re.compile(r"body\.(\w+)\.neutral_mass")
OFFERED = ".neutral_mass"
MOST = 3
"""Hydrodynamics bodies that are suggested."""


def unset_masses(
    system: System, descriptions: Mapping[str, Description], driven: Container[str]
) -> Iterator[Problem]:
    """Problems with the neutral masses that neither a start value nor a connection sets.

    `driven` are the variables, as ``component.variable``, that connections lead to.
    """
    offers = [
        f"{component}.{variable.name.removesuffix(OFFERED)}"
        for component, description in descriptions.items()
        for variable in description.of_causality("calculatedParameter")
        if variable.name.endswith(OFFERED)
    ]
    for component in system.components:
        for variable in descriptions[component.name].of_causality("parameter"):
            found = WANTED.fullmatch(variable.name)
            name = f"{component.name}.{variable.name}"
            if not found or name in driven or _has_value(component, variable):
                continue
            message = f"{name} has no value: 'mass: neutral' needs a hydrodynamics body"
            remedy = _connections(f"{component.name}.{found[1]}", name, offers)
            remedy += f"; or give the mass: start: {{{variable.name}: 120 t}}"
            yield system.problem(("components", component.name), message, remedy)


def _has_value(component: Component, variable: Variable) -> bool:
    """True if the start value is not 0; also if it is unreadable, which is another problem."""
    given = component.start.get(variable.name, float(variable.start or 0.0))
    try:
        return value_of(variable, given) != 0.0
    except ValueError:
        return True


def _connections(body: str, mass: str, offers: Sequence[str]) -> str:
    """The connections that give `mass`, of `body`, a value."""
    if not offers:
        return "add a component of kind hydrodynamics, and connect its body"
    bodies = " or ".join(f"'{body} <-> {offer}'" for offer in offers[:MOST])
    return f"connect it by {bodies}, or only the mass by '{offers[0]}{OFFERED} -> {mass}'"
