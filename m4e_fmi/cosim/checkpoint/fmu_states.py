"""The states of FMUs in a checkpoint, and the FMUs that have none to give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from m4e_fmi.cosim.checkpoint.state import Saved, State
from m4e_fmi.cosim.exchange.layout import OWN_PLACES, NetworkSnapshot
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.fmu.importer.calls import SerializedState
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.signals import not_lost

MOST_PLACES = 64
"""Places of states that a run has, at most."""
States = dict[int, dict[str, SerializedState]]
"""By place and component."""


def without_states(descriptions: Mapping[str, Description]) -> str:
    """Why a run of these components cannot be saved for another process; empty if it can."""
    fixed = [n for n, d in descriptions.items() if not (d.saves_state and d.serializes_state)]
    if not fixed:
        return ""
    return f"{' and '.join(fixed)} cannot save states for another process (canSerializeFMUstate)"


@not_lost()
def serialized(network: Network, state: State) -> States:
    """The states that FMUs have of the points of a state; RunError if one refuses."""
    return {
        point.place: {
            name: instance.rollback.serialized(instance.slot(point.place))
            for name, instance in network.instances.items()
        }
        for point in state.points
    }


@not_lost()
def deserialize(network: Network, saved: Saved) -> None:
    """Give the FMUs of another process their states; RunError if one refuses.

    ValueError for states that cannot be of a run of this network.
    """
    for point in _different(saved.state.points):
        if not OWN_PLACES <= point.place < MOST_PLACES:
            raise ValueError(f"a state at place {point.place}")
        network.discrete.check(point.discrete)
        for name, instance in network.instances.items():
            state = saved.fmu_states[point.place][name]
            instance.rollback.deserialize(instance.slot(point.place), state)
        network.adopt(point)


def _different(points: Sequence[NetworkSnapshot]) -> list[NetworkSnapshot]:
    """Each point once, by ascending places."""
    found = {point.place: point for point in points}
    return [found[place] for place in sorted(found)]
