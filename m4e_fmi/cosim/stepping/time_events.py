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

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.system.simulation import NEVER, NS_PER_SECOND
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.units import parse_unit

NEXT_EVENT_TIME = "next_event_time"


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
        self._network = network
        instances = network.instances.values()
        self._announcing = [i for i in instances if announces(i.description)]
        self._others = [
            i for i in instances if i.description.has_events and i not in self._announcing
        ]

    def __bool__(self) -> bool:
        """True if any FMU announces jumps or may have events, or a scenario has actions."""
        return bool(self._announcing or self._others or self._network.scenario)

    def next(self, now: int) -> int:
        """The time [ns] of the next jump after `now`, NEVER if none is known.

        RunError if the time that an FMU announces cannot be read, or is not finite.
        """
        times = [instance.events.next_event for instance in self._others]
        for instance in self._announcing:
            value = self._network.read(f"{instance.name}.{NEXT_EVENT_TIME}")
            if not math.isfinite(value):
                instance.not_finite((NEXT_EVENT_TIME,), np.array([value]))
            unit = instance.description.variables[NEXT_EVENT_TIME].dimension
            times.append(value * (unit.factor if unit else 1.0))
        ahead = [in_nanoseconds(time) for time in times if math.isfinite(time)]
        ahead.append(self._network.scenario.next(now))
        return min((time for time in ahead if time > now), default=NEVER)
