"""The part of a run that its statistics leave out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from m4e_fmi.cosim import System
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import Description
from m4e_fmi.study.given.study import Study

SETTLING = 2.0
"""Settling time over the ramp, if none is stated: a ramp is two peak periods."""
DEFAULT = (
    f"the ramp of the sea and a settling time of {SETTLING:g} ramps; 0 s where no sea has a ramp"
)

RAMP = "ramp_time"
"""Last word of parameters that are the time in which loads grow from nothing [s]."""


def ramps_of(system: System, descriptions: Mapping[str, Description]) -> dict[str, float]:
    """The ramps [s] by COMPONENT.VARIABLE, at the start values of the system."""
    return {
        f"{component.name}.{name}": float(
            value_of(variable, component.start.get(name, float(variable.start)))
        )
        for component in system.components
        for name, variable in descriptions[component.name].variables.items()
        if name.rpartition(".")[2] == RAMP and variable.start is not None
    }


def first_time(
    study: Study, ramps: Mapping[str, float], start_time: float, stop_time: float
) -> float:
    """The time [s] from which on rows of a run count, with the `ramps` [s] of its seas by name.

    It is as stated, or `DEFAULT`. InputError if no row counts.
    """
    stated = study.start_up
    if stated is None:
        stated = (1.0 + SETTLING) * max(ramps.values(), default=0.0)
    first = start_time + stated
    if not first < stop_time:
        message = f"no row counts: the start-up of {first:g} s ends at the stop time or later"
        remedy = f"state a start_up below {stop_time:g} s, or a later stop_time"
        raise InputError([study.document.problem(("start_up",), message, remedy)])
    return first


def ramp_warnings(study: Study, ramps: Iterable[Mapping[str, float]]) -> dict[str, int]:
    """The warning of a stated start-up that is shorter than a ramp [s], with the number of runs."""
    stated = study.start_up
    longest = (max(one.values(), default=0.0) for one in ramps)
    early = [one for one in longest if stated is not None and stated < one]
    if not early:
        return {}
    line = (
        f"start_up of {stated:g} s ends within the ramp of the sea, of up to {max(early):g} s: "
        "statistics count waves that still grow; state more, or leave it out"
    )
    return {line: len(early)}


def left_out(first: np.ndarray, how: str) -> str:
    """The part of runs that statistics leave out, in words: rows count from `first` (…,) [s] on.

    `how` says where that is from.
    """
    low, high = float(np.nanmin(first)), float(np.nanmax(first))
    if low == high == 0.0 and how == DEFAULT:
        return "nothing: no start_up is stated, and no sea has a ramp"
    span = f"{low:g} s" if low == high else f"{low:.4g} to {high:.4g} s"
    return f"all before t = {span} ({how})"
