"""Warnings of allowed values that seem wrong: ramps, start values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Wiring
from m4e_fmi.cosim.wiring.structure import Structure, Transfer
from m4e_fmi.fmu.importer.reading import Description

RAMP = "ramp_time"
"""Last word of parameters that are the time in which loads grow from nothing [s]."""


def ramps(system: System, descriptions: Mapping[str, Description]) -> dict[str, float]:
    """The ramps [s] by COMPONENT.VARIABLE, at the start values of the system."""
    return {
        f"{component.name}.{name}": float(
            value_of(variable, component.start.get(name, float(variable.start)))
        )
        for component in system.components
        for name, variable in descriptions[component.name].variables.items()
        if name.rpartition(".")[2] == RAMP and variable.start is not None
    }


def within_ramps(system: System, descriptions: Mapping[str, Description]) -> Iterator[str]:
    """One line for each ramp that is not over when the run ends."""
    span = system.simulation.stop_time - system.simulation.start_time
    for name, ramp in ramps(system, descriptions).items():
        if span <= ramp:
            yield (
                f"the run of {span:g} s ends within the ramp, {name} = {ramp:g} s: no row is of "
                "the full loads; take a later stop_time, or a shorter ramp"
            )


def start_values_without_effect(
    system: System, wiring: Wiring, structure: Structure
) -> Iterator[str]:
    """One line for each start value that a connection replaces at initialisation.

    Start values of delayed connections and of algebraic loops have an effect: they carry the run,
    or the solution, until the source is known.
    """
    replaced = {
        (step.component, name)
        for step in structure.initial
        if isinstance(step, Transfer) and step.action == "set"
        for name in step.variables
    }
    for link in (*wiring.links, *wiring.initial_links):
        target = link.target
        start = {c.name: c.start for c in system.components}[target.component]
        at = target.component, target.variable
        if target.variable in start and at in replaced and not link.delayed:
            yield (
                f"the start value of {target} has no effect: it is connected to {link.source}; "
                "leave out one of the two"
            )
