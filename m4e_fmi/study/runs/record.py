"""`Record`: what is kept of one run; its statistics."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.statistics import STATISTICS
from m4e_fmi.study.given.study import Wanted


@dataclass(frozen=True)
class Record:
    """Numbers of one run, and how it went: all that is kept of it.

    `values` are the wanted statistics by name, in their units; `time` (n,) [s] and `series` (n,) by
    variable those that are wanted whole. `coupling_error` [1] is the largest over the range, nan if
    it is not known, at `coupling_at`. `failure` is empty of a run that reached its end, `undefined`
    has the reasons of statistics that are nan.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    time: np.ndarray = field(default_factory=lambda: np.empty(0), repr=False)
    series: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False)
    coupling_error: float = float("nan")
    coupling_at: str = ""
    wall_time: float = 0.0
    failure: str = ""
    warnings: tuple[str, ...] = ()
    undefined: Mapping[str, str] = field(default_factory=dict)

    def head(self) -> str:
        """All but the arrays, as JSON; numbers keep all their digits."""
        told = {k: v for k, v in vars(self).items() if k not in ("time", "series")}
        return json.dumps({**told, "series": list(self.series)})

    def block(self) -> bytes:
        """The arrays: times, then each series."""
        if not self.series:
            return b""
        return np.stack([self.time, *self.series.values()]).astype("<f8").tobytes()

    @classmethod
    def of(cls, head: str, block: bytes) -> Record:
        """The record of a head and a block; RunError if they are damaged."""
        try:
            told = json.loads(head)
            names = told.pop("series")
            arrays = np.frombuffer(block, "<f8").reshape(len(names) + 1, -1)
            told["warnings"] = tuple(told["warnings"])
            if not names:
                return cls(**told)
            series = dict(zip(names, arrays[1:], strict=True))
            return cls(**told, time=arrays[0], series=series)
        except (ValueError, TypeError, KeyError) as error:
            raise RunError(f"a kept run is damaged: {error}", "run with --fresh") from error


def computed(
    wanted: Sequence[Wanted],
    time: np.ndarray,
    values: Mapping[str, np.ndarray],
    start_up: float,
) -> tuple[dict[str, np.ndarray], dict[str, tuple[str, ...]]]:
    """Statistics (m,) of m runs by name, in their units, and why they are nan.

    `time` (n,) [s], `values` (m, n) by variable, in their units; those before `start_up` [s] do not
    count.
    """
    after = time >= start_up
    counted = slice(None) if np.all(after) else after  # no copies of all
    found: dict[str, np.ndarray] = {}
    reasons: dict[str, tuple[str, ...]] = {}
    for one in wanted:
        statistic = STATISTICS[one.statistic]
        explained = statistic.explained(
            time[counted], values[one.variable][:, counted], **dict(one.parameters)
        )
        found[one.name] = explained.values
        reasons[one.name] = explained.reasons
    return found, reasons
