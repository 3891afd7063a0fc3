"""Notes, warnings and errors of a run, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from m4e_fmi.cosim.connections.links import Bond
from m4e_fmi.cosim.exchange.instance import DiscardedError, EventWithinError
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.stepping.step_control import SMALLEST
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.time_loop.time_loop import MOST_DISCARDED, Switches, TimeLoop
from m4e_fmi.errors import RunError

MOST_NAMED = 3
"""Outputs of a component that are named in one note."""
SHORT = 1.0
"""Wall time [s] of a run up to which nobody asks what takes it."""


def network_notes(network: Network, switches: Switches, bonds: Sequence[Bond]) -> Iterator[str]:
    """Notes of events, `switches`, lost outputs, inputs solved badly, held actions; a line each.

    The energies of `bonds` are not summed where a scenario changes their signals.
    """
    for instance in network.instances.values():
        if count := instance.events.interruptions:
            yield (
                f"{instance.name} had {count} event{'s' * (count > 1)} within steps, at which the "
                "other components did not stop"
            )
    yield from switches.notes
    for name, outputs in network.lost.items():
        more = len(outputs) - MOST_NAMED
        named = ", ".join(outputs[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
        yield (
            f"{name}: setting inputs, even to the values that they have, changes {named} by "
            "more than its noise: the values straight after its steps count"
        )
    if rough := network.roughness:
        yield (
            f"inputs are solved only to {rough:.1e} of their size: the FMUs' outputs for "
            "nearly the same inputs jump by that much"
        )
    if held := network.scenario.held:
        yield (
            f"values that actions give ({', '.join(held)}) change at communication points and are "
            "held within steps, so that errors fall with the step size only: take small steps"
        )
    summed = network.scenario.untouched(bonds)
    if names := [bond.name for bond in bonds if bond not in summed]:
        yield f"the scenario changes signals of {' and '.join(names)}: no energy balance there"
    if network.ended:
        yield network.ended


def slow_code(network: Network, wall_time: float) -> list[str]:
    """A note of a component of Python code that takes most of a run of `wall_time` [s]."""
    taken = ((i.name, float(i.spent[0])) for i in network.instances.values() if i.spent is not None)
    return [
        f"steps of {name} took {spent / wall_time:.0%} of the run's {wall_time:.3g} s: its Python "
        "code is not recorded; `rates` and `calculate` of plain `math`, without NumPy, are, and "
        "run many times faster"
        for name, spent in taken
        if wall_time > SHORT and spent > wall_time / 2
    ]


def early_end(network: Network, stop_time: float, *, steps: int) -> list[str]:
    """A warning of FMUs that have asked for the end before the stop time [s]."""
    if not steps:
        names = [name for name, instance in network.instances.items() if instance.has_ended]
        return [
            f"the run ended before its first step, and its results have the start only: {name} "
            "asked for the end of the simulation in its first step; if that is not meant, look at "
            "what its step answers (in PythonFMU, do_step must return True)"
            for name in names
        ]
    if network.ended and round((stop_time - network.time) * NS_PER_SECOND) > 0:
        return [f"the run ended before its stop time of {stop_time:.9g} s: {network.ended}"]
    return []


def discarded_at_every_length(error: RunError, time_loop: TimeLoop, step_size: float) -> RunError:
    """`error`, or the error of an FMU that discards steps of all lengths up to `step_size` [s]."""
    if not isinstance(error, DiscardedError) or isinstance(error, EventWithinError):
        return error
    sizes, position = f"{step_size:g} s down to {error.size:.3g} s", time_loop.position
    if error.size <= 2 * SMALLEST * step_size:
        tried = f"every step from there, of {sizes}"
    elif position.discarded >= MOST_DISCARDED:
        since = position.full / NS_PER_SECOND
        tried = f"{position.discarded} steps since t = {since:.9g} s, of {sizes}"
    else:
        return error
    first = "fix the problem stated by the FMU first"
    return RunError(
        f"{error.message}; {error.component} has discarded {tried}",
        f"{first}; "
        * error.remedy.startswith(first)
        + f"no step_size helps: check what {error.component} cannot compute there, and at "
        "its inputs in the results",
    )
