"""The coupling errors that a run states, its notes of what was seen, and a warning."""

from __future__ import annotations

from collections.abc import Sequence

from m4e_fmi.cosim.connections.links import Bond
from m4e_fmi.cosim.error_estimate.estimator import ErrorEstimator
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport, certificate
from m4e_fmi.cosim.exchange.discrete import Switches
from m4e_fmi.cosim.exchange.events import ended, ended_at_once, event_notes
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND

MOST_NAMED = 3
"""Outputs of a component that are named in one note."""
SHORT = 1.0
"""Wall time [s] of a run up to which nobody asks what takes it."""


def certified(
    estimator: ErrorEstimator | None,
    network: Network,
    connections: Sequence[str],
    *,
    unwatched: str,
    switched: bool,
) -> CouplingErrorReport | str:
    """The coupling errors up to the present point, or why they are not known.

    Without an `estimator` that is `unwatched`. The run has `switched` if values that are not Real
    have changed within steps.
    """
    if not network.links and not network.discrete:
        return CouplingErrorReport(())
    if not network.links:
        return "no Real is exchanged"
    if estimator is None:
        return unwatched
    estimator.finish()
    if estimator.failure:
        return estimator.failure
    return certificate(
        network,
        connections,
        errors=estimator.errors(),
        halved=estimator.errors(halved=True),
        ranges=estimator.ranges(),
        leaps=estimator.leaps() if switched or network.sampled else None,
        coverage=estimator.coverage(),
        longer=estimator.longer,
    )


def network_notes(network: Network, switches: Switches) -> list[str]:
    """Notes of events, `switches`, lost outputs, inputs solved badly, held actions; a line each."""
    seen = [*event_notes(network.instances.values()), *switches.notes]
    seen += [
        f"{name}: setting inputs, even to the values that they have, changes {_some(outputs)} by "
        "more than its noise: the values straight after its steps count"
        for name, outputs in network.lost.items()
    ]
    if rough := network.roughness:
        seen.append(
            f"inputs are solved only to {rough:.1e} of their size: the FMUs' outputs for "
            "nearly the same inputs jump by that much"
        )
    if held := network.scenario.held:
        seen.append(
            f"values that actions give ({', '.join(held)}) change at communication points and are "
            "held within steps, so that errors fall with the step size only: take small steps"
        )
    return seen


def _some(names: Sequence[str]) -> str:
    more = len(names) - MOST_NAMED
    return ", ".join(names[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


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


def unbalanced(network: Network, bonds: Sequence[Bond]) -> list[str]:
    """A note of the bonds whose energies are not summed, as a scenario changes their signals."""
    kept = network.scenario.untouched(bonds)
    names = [bond.name for bond in bonds if bond not in kept]
    told = f"the scenario changes signals of {' and '.join(names)}: no energy balance there"
    return [told] if names else []


def early_end(network: Network, stop_time: float, *, steps: int) -> list[str]:
    """A warning of FMUs that have asked for the end before the stop time [s]."""
    instances = network.instances.values()
    if not steps:
        return ended_at_once(instances)
    asked = ended(instances)
    if asked and round((stop_time - network.time) * NS_PER_SECOND) > 0:
        return [f"the run ended before its stop time of {stop_time:.9g} s: {asked}"]
    return []
