"""Units that the system gives to variables whose FMU gives none."""

from __future__ import annotations

from dataclasses import replace

from m4e_fmi.cosim.system.component import Component
from m4e_fmi.fmu.importer.reading import Description


def with_units(component: Component, description: Description) -> Description:
    """The description of the component's FMU, with the units that the system adds."""
    variables = dict(description.variables)
    for name, unit in component.units.items():
        if name in variables and variables[name].dimension is None:
            variables[name] = replace(variables[name], unit=unit.text, dimension=unit)
    return replace(description, variables=variables)
