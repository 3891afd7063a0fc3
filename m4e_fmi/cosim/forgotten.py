"""Connections that a system lacks, by all appearances."""

from __future__ import annotations

from collections.abc import Mapping

from m4e_fmi.cosim.connect import Port, Wiring
from m4e_fmi.cosim.system import System
from m4e_fmi.fmu.reading import Description


def forgotten(system: System, descriptions: Mapping[str, Description], wiring: Wiring) -> list[str]:
    """What one component calculates, another has as a parameter of that name, and nothing carries.

    One line each: added mass, say, that would be left at its start value.
    """
    taken = {link.source for link in wiring.initial_links}
    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in wiring.initial_links}
    offered, wanted = (
        dict.fromkeys(
            (component, variable.name.partition("[")[0])
            for component, description in descriptions.items()
            for variable in description.of_causality(causality)
            if Port(component, variable.name) not in done
        )
        for causality, done in (("calculatedParameter", taken), ("parameter", given))
    )
    return [
        f"{source}.{name} is calculated, but not carried over: '{source}.{name} -> {target}.{name}'"
        for source, name in offered
        for target, other in wanted
        if name == other and source != target
    ]
