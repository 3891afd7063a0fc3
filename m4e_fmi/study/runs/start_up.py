"""The part of a run that its statistics leave out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from m4e_fmi.cosim.preparation.doubtful_values import RAMP
from m4e_fmi.errors import InputError
from m4e_fmi.study.given.study import Study

SETTLING = 2.0
"""Settling time over the ramp, if none is stated: a ramp is two peak periods."""
DEFAULT = (
    f"the ramp of the sea and a settling time of {SETTLING:g} ramps; 0 s where no sea has a ramp"
)


def ramp_of(starts: Iterable[tuple[str, float]]) -> float:
    """The longest ramp [s] of a sea among start values by name; 0 if there is none."""
    return max((value for name, value in starts if name.rpartition(".")[2] == RAMP), default=0.0)


def start_up(stated: float | None, start_time: float, starts: Mapping[str, float]) -> float:
    """The time [s] from which on rows count: as `stated` after the start, or `DEFAULT`."""
    if stated is not None:
        return start_time + stated
    return start_time + (1.0 + SETTLING) * ramp_of(starts.items())


def within_ramp(stated: float, ramp: float) -> str:
    """The warning of a start-up that is `stated` [s] and shorter than a `ramp` [s]."""
    return (
        f"start_up of {stated:g} s ends within the ramp of the sea, of up to {ramp:g} s: "
        "statistics count waves that still grow; state more, or leave it out"
    )


def left_out(first: np.ndarray, how: str) -> str:
    """The part of runs that statistics leave out, in words: rows count from `first` (…,) [s] on.

    `how` says where that is from.
    """
    low, high = float(np.nanmin(first)), float(np.nanmax(first))
    if low == high == 0.0 and how == DEFAULT:
        return "nothing: no start_up is stated, and no sea has a ramp"
    span = f"{low:g} s" if low == high else f"{low:.4g} to {high:.4g} s"
    return f"all before t = {span} ({how})"


def check_start_up(study: Study, first: float, stop_time: float) -> None:
    """InputError if no row of a run counts, from the time `first` [s] on up to the `stop_time`."""
    if not first < stop_time:
        message = f"no row counts: the start-up of {first:g} s ends at the stop time or later"
        remedy = f"state a start_up below {stop_time:g} s, or a later stop_time"
        raise InputError([study.document.problem(("start_up",), message, remedy)])
