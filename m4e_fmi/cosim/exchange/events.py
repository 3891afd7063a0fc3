"""Events that FMUs tell the master of (FMI 3.0's event mode), and what a run makes of them.

Where all components can go back, and the algorithm can take back its step, all stop at an event:
a step across it is made again, up to there. Otherwise the FMU with the event goes on by itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from operator import attrgetter

from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.fmu.importer.calls.access import RawComponent


def telling(instances: Iterable[Instance]) -> tuple[Instance, ...]:
    """Those that can tell of events and of the end: FMI 3.0 has words for it."""
    return tuple(instance for instance in instances if instance.description.version == "3.0")


def has_events(instances: Iterable[Instance]) -> bool:
    """True if any of them may have events that others should know of."""
    return any(instance.description.has_events for instance in instances)


def event_count(instances: Iterable[Instance]) -> int:
    """How many events they have had, in steps that were taken back, too."""
    return sum(instance.events.handled for instance in instances)


_ENDED = attrgetter("ended")


def is_over(events: Iterable[RawComponent]) -> bool:
    """True if the instance of one of these asked for the end of the simulation."""
    return min(map(_ENDED, events)) < math.inf


def ended(instances: Iterable[Instance]) -> str:
    """Which of them asked for the end of the simulation, and when; empty if none did."""
    return "; ".join(
        f"{instance.name} requested the end of the simulation at t = {instance.events.ended:.9g} s"
        for instance in instances
        if instance.has_ended
    )


def ended_at_once(instances: Iterable[Instance]) -> list[str]:
    """The warning that a run ended before its first step, where one of them asked for that."""
    names = [instance.name for instance in instances if instance.has_ended]
    return [
        f"the run ended before its first step, and its results have the start only: {name} asked "
        "for the end of the simulation in its first step; if that is not meant, look at what its "
        "step answers (in PythonFMU, do_step must return True)"
        for name in names
    ]


def event_notes(instances: Iterable[Instance]) -> Iterable[str]:
    """Warnings about events within steps, one line each."""
    for instance in instances:
        count = instance.events.interruptions
        if count:
            yield (
                f"{instance.name} had {count} event{'s' * (count > 1)} within steps, at which the "
                "other components did not stop"
            )
