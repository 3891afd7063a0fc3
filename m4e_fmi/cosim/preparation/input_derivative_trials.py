"""Time derivatives of inputs that FMUs refuse, though they say that they interpolate inputs.

No FMU declares up to which order it takes them (`maxOutputDerivativeOrder` is about outputs), and
after an error no instance can go on. So before a run whose algorithm lets inputs follow their
sources, each FMU not built here gets derivatives in an instance that is thrown away, and makes a
step: with first and second ones, then with first ones alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.connections.links import Wiring
from m4e_fmi.cosim.exchange.instance import WARNING
from m4e_fmi.cosim.exchange.interruption import setting_up
from m4e_fmi.cosim.preparation.trial_instances import Instances, driven_inputs, stepped
from m4e_fmi.cosim.system.system import System
from m4e_fmi.coupling_algorithms import LinkDelay, algorithm_descriptor
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import MOST_DERIVATIVES, Description
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.signals import not_lost

_NOTES = (
    "refuses time derivatives of inputs, though it declares canInterpolateInputs: inputs are held",
    "refuses second time derivatives of inputs: these follow straight lines",
)


def without_refused(
    system: System,
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    hosts: Mapping[str, Host],
) -> tuple[dict[str, Description], list[str]]:
    """The descriptions with the orders that FMUs take, and a note for each that refuses one."""
    result, told = dict(descriptions), dict[tuple[str, int], list[str]]()
    descriptor = algorithm_descriptor(system.simulation.algorithm)
    if descriptor.link_delay not in (LinkDelay.CORRECTED, LinkDelay.SOLVED):
        return result, []
    driven, known = driven_inputs(wiring), dict[object, int]()
    for component in system.components:
        description, inputs = descriptions[component.name], driven.get(component.name, ())
        alone = description.once_per_process and component.name not in hosts
        if description.is_own or alone or not (inputs and description.input_order):
            continue
        reals = [name for name in inputs if description.variables[name].type == REAL]
        key = description.path, tuple(sorted(map(str, component.start.items()))), inputs
        if key not in known:
            new = Instances(component, description, system.simulation, hosts.get(component.name))
            known[key] = _order(new, reals)
        if known[key] < description.input_order:
            result[component.name] = replace(description, input_order=known[key])
            told.setdefault((description.path.name, known[key]), []).append(component.name)
    return result, [
        f"{', '.join(names)}: {fmu} {_NOTES[order]}" for (fmu, order), names in told.items()
    ]


def _order(new: Instances, names: Sequence[str]) -> int:
    """The highest order of which an FMU takes derivatives; that declared, if it makes no step."""
    for most in range(MOST_DERIVATIVES, -1, -1):
        try:
            with setting_up(), new.instance() as instance, not_lost():
                for order, name in ((k + 1, name) for k in range(most) for name in names):
                    status = instance.own_derivative_setter(name, order, np.zeros(1))()
                    if status > WARNING:
                        instance.fail(status, "fmi2SetRealInputDerivatives")
                stepped(instance, new.step)
        except RunError:
            continue
        return most
    return MOST_DERIVATIVES
