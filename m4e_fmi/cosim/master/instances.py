"""The instances of a system at its start time, connected in a network."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import ExitStack

import numpy as np

from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.exchange.fmu_log import Journal
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.interruption import quiet
from m4e_fmi.cosim.exchange.loading.binary import PYTHON, Binary
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.system.start_values import start_values


def initialised(
    prepared: Prepared,
    loaded: Mapping[str, Binary],
    stack: ExitStack,
    journal: Journal | None,
    *,
    recorded: Mapping[str, Collection[str]] | None,
    watched: bool,
    suffix: str = "",
) -> Network:
    """New instances of all components, connected, at the start time; `stack` closes them.

    `recorded` and `watched` are those of the network; `suffix` ends the names that FMUs receive.
    The messages of FMUs go to the `journal`, if there is one.
    """
    simulation = prepared.system.simulation
    instances: dict[str, Instance] = {}
    for component in prepared.system.components:
        name, description = component.name, prepared.descriptions[component.name]
        listener = journal.listener(name) if journal else None
        instance = Instance(name, description, loaded[name], listener, suffix=suffix)
        if journal and (worker := loaded[name].worker):
            worker.notice = journal.notice
        if isinstance(component.source, Kind) and component.source.name == "python":
            is_code = (loaded[name].files.folder / PYTHON).is_file()  # not recorded as a program
            instance.spent = np.zeros(1) if is_code else None
        stack.enter_context(instance).setup(
            start=simulation.start_time,
            stop=simulation.last_time,
            tolerance=simulation.tolerance,
        )
        instance.set_values(start_values(component, description))
        instances[name] = instance
    network = Network(prepared, instances, recorded=recorded, watched=watched)
    with quiet():
        network.initialise()
    return network
