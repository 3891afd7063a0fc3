"""Jumps that FMUs announce: times at which an output changes without time passing.

FMI 3.0 has events, with their time where it is known. FMI 2.0 has no word for them; there a Real
variable called `next_event_time` [s], output or local, is the time of the FMU's next jump. A time
that has passed means that none is known. From half a nanosecond before its time on the FMU is to
show the values after the jump, because it may have added up its time from steps.

Steps end a nanosecond before the jump, where outputs are still as they were, and go over it in
another of one nanosecond. So no step has a jump within it, and none begins with the values before
it; what was before is then forgotten.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import partial

import numpy as np

from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.exchange.operations import Get
from m4e_fmi.cosim.exchange.step_loop import Schedule
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.units import parse_unit

NEXT_EVENT_TIME = "next_event_time"
NEVER = 2**62
"""A time [ns] that no run reaches."""


def announces(description: Description) -> bool:
    """True if an FMU announces the time of its next jump."""
    variable = description.variables.get(NEXT_EVENT_TIME)
    if variable is None or variable.causality not in ("output", "local"):
        return False
    unit = variable.dimension
    return variable.type == "Real" and (unit is None or unit.same_dimension(parse_unit("s")))


def in_nanoseconds(time: float) -> int:
    """The first whole nanosecond at or after a time [s] of an event, which may be rounded."""
    exact = time * NS_PER_SECOND
    return math.ceil(exact - min(4 * sys.float_info.epsilon * abs(exact), 0.5))


class TimeEvents:
    """The jumps ahead of the instances of a network, and of its scenario."""

    def __init__(self, network: Network) -> None:
        self._readers: list[Callable[[], float]] = []
        self._scenario = network.scenario
        for name, instance in network.instances.items():
            place = network.known(Port(name, NEXT_EVENT_TIME))
            if announces(instance.description):
                self._readers.append(_reader(instance, network.values, place))
            elif instance.description.has_events:
                self._readers.append(partial(_next_event, instance))

    def __bool__(self) -> bool:
        """True if any FMU announces jumps or may have events, or a scenario has actions."""
        return bool(self._readers) or bool(self._scenario)

    def next(self, now: int) -> int:
        """The time [ns] of the next jump after `now`, NEVER if none is known."""
        times = [read() for read in self._readers]
        ahead = [in_nanoseconds(time) for time in times if math.isfinite(time)]
        ahead.append(self._scenario.next(now))
        return min((time for time in ahead if time > now), default=NEVER)


def _next_event(instance: Instance) -> float:
    return instance.events.next_event


def _reader(instance: Instance, values: np.ndarray, place: int | None) -> Callable[[], float]:
    """Reads the announced time [s] of an FMU; RunError if that fails, or is no number.

    It is at a `place` of `values`; where there is none, the FMU tells it.
    """
    value = np.zeros(1) if place is None else values[place : place + 1]
    reading = Schedule([Get(instance, (NEXT_EVENT_TIME,), value)] if place is None else [])
    unit = instance.description.variables[NEXT_EVENT_TIME].dimension
    factor = 1.0 if unit is None else unit.factor

    def read() -> float:
        reading.run(instance.time)
        if not math.isfinite(value[0]):
            instance.not_finite((NEXT_EVENT_TIME,), value)
        return factor * float(value[0])

    return read
