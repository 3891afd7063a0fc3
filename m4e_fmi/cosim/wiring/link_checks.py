"""Problems of links as a whole, of the system's own inputs and outputs, and of neutral masses.

The FMU of a body with ``mass: neutral`` has a parameter ``body.<name>.neutral_mass`` without a
value. A hydrodynamics component calculates one of that name for each of its bodies, which a
connection of the two bodies (``buoy.float <-> hydro.float``) carries over.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator, Mapping

from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import (
    SAME_UNIT,
    Link,
    Port,
    Variables,
    is_carried,
    is_varying,
)
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable

WANTED = re.compile(r"body\.(\w+)\.neutral_mass")
OFFERED = ".neutral_mass"


def link_problems(system: System, variables: Variables, links: Iterable[Link]) -> Iterable[Problem]:
    """Links whose ends do not fit by when they have their values."""
    for link in links:
        give, take = link.variables(variables)
        at = ("connections", link.connection)
        if is_carried(give, take):
            continue
        if is_varying(give):
            message = (
                f"{link.target} is a {take.variability} parameter, which cannot follow the output "
                f"{link.source} during a run"
            )
            remedy = (
                "connect to an input or a tunable parameter (of a model: tunable: true), or give "
                "a number under start:"
            )
            yield system.problem(at, message, remedy)
        elif link.delayed:
            message = (
                f"{link.target} is a parameter, to which values are carried once, at the start"
            )
            yield system.problem(at, message, "leave out ', delayed'")


def input_derivative_problems(
    system: System, descriptions: Mapping[str, Description], links: Iterable[Link]
) -> Iterable[Problem]:
    """Inputs that an FMU moves along a rate, another input, which is converted differently."""
    by_target = {link.target: link for link in links}
    for component, description in descriptions.items():
        for moved, rate in description.input_derivatives.items():
            place = by_target.get(Port(component, moved))
            speed = by_target.get(Port(component, rate))
            if place is None or speed is None:
                continue
            if abs(speed.factor / place.factor - 1) > SAME_UNIT or speed.offset != 0.0:
                message = f"{rate} is declared as the rate of {moved}, but connected differently"
                remedy = f"give both the factor {place.factor:g}, and {rate} no offset"
                yield system.problem(("connections", speed.connection), message, remedy)


def outer_port_problems(
    system: System, descriptions: Mapping[str, Description], driven: set[Port]
) -> Iterable[Problem]:
    """Problems of the system's own inputs and outputs; `driven` are the targets of links."""
    named = [(("inputs", name), text) for name, texts in system.inputs.items() for text in texts]
    named += [(("outputs", name), text) for name, text in system.outputs.items()]
    for at, text in named:
        port = Port.named(text)
        kind = at[0].removesuffix("s")
        known = descriptions.get(port.component)
        variable = known.variables.get(port.variable) if known else None
        if variable is None:
            there = known.of_causality(kind) if known else ()
            remedy = suggestion(port.variable, [v.name for v in there], f"{kind}s")
            if known is None:
                remedy = suggestion(port.component, descriptions, "components")
            yield system.problem(at, f"{at[1]!r} stands for {text!r}, which is no variable", remedy)
        elif variable.causality != kind:
            message = f"{at[1]!r} stands for {text} ({variable.causality}), which is no {kind}"
            yield system.problem(at, message, f"name an {kind}")
        elif port in driven:
            message = f"{at[1]!r} stands for {text}, which is connected"
            yield system.problem(at, message, "name an unconnected input")


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
            body = f"{component.name}.{found[1]}"
            offered = f": '{body} <-> {offers[0]}'" if offers else ""
            remedy = f"connect it with a body of a component of kind hydrodynamics{offered}"
            remedy += f"; or give the mass: start: {{{variable.name}: 120 t}}"
            yield system.problem(("components", component.name), message, remedy)


def _has_value(component: Component, variable: Variable) -> bool:
    """True if the start value is not 0; also if it is unreadable, which is another problem."""
    given = component.start.get(variable.name, float(variable.start or 0.0))
    try:
        return value_of(variable, given) != 0.0
    except ValueError:
        return True
