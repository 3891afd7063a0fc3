"""Peaks, heights and periods of the cycles of one run, from one up-crossing of a level to the next.

The level is the mean over time unless another is given. The highest recorded value of a cycle is
its crest, the lowest its trough: in steps of 1/20 of a period they are up to 1.2 % of the amplitude
lower than those of the motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.shown import short
from m4e_fmi.statistics.record import (
    Floats,
    UndefinedError,
    check_varies,
    is_constant,
    of_one_run,
    weights,
)


@short
@dataclass(frozen=True)
class Peaks:
    """Complete cycles of a record about `level`; all values are in the unit of the record.

    `crossings` (k + 1,) [s] are the times of up-crossings; `time` (k,) [s] those of the crests,
    `crests` and `troughs` (k,) the highest and lowest values of each cycle.
    """

    level: float
    crossings: Floats
    time: Floats
    crests: Floats
    troughs: Floats

    @property
    def heights(self) -> Floats:
        """Crest minus trough of each cycle, (k,) in the unit of the record."""
        return self.crests - self.troughs

    @property
    def amplitudes(self) -> Floats:
        """Crests above the level, (k,) in the unit of the record."""
        return self.crests - self.level


def peaks(time: ArrayLike, values: ArrayLike, *, level: float | None = None) -> Peaks:
    """Cycles of `values` (n,), in their unit, at `time` (n,) [s], about `level` or the mean.

    InputError as `checked_runs`, for several runs, and where the record has no cycles to count.
    """
    return of_one_run(time, values, lambda t, x: peaks_of(t, x, level))


def peaks_of(time: Floats, run: Floats, level: float | None = None) -> Peaks:
    """As `peaks`, of `run` (n,), in its unit, at `time` (n,) [s]; UndefinedError if constant."""
    middle = float(weights(time) @ run) if level is None else level
    check_varies(run)
    above = run >= middle
    up = np.flatnonzero(~above[:-1] & above[1:])
    if not len(up):
        none = np.zeros(0)
        return Peaks(middle, none, none, none, none)
    part = (middle - run[up]) / (run[up + 1] - run[up])
    crossings = time[up] + part * (time[up + 1] - time[up])
    whole = slice(up[0] + 1, up[-1] + 1)
    starts = up[:-1] - up[0]
    if not len(starts):
        none = np.zeros(0)
        return Peaks(middle, crossings, none, none, none)
    within = run[whole]
    crests = np.maximum.reduceat(within, starts)
    troughs = np.minimum.reduceat(within, starts)
    cycle = np.repeat(np.arange(len(starts)), np.diff(up))
    at = np.flatnonzero(within == crests[cycle])
    first = at[np.unique(cycle[at], return_index=True)[1]]
    return Peaks(middle, crossings, time[whole][first], crests, troughs)


def number_of_cycles(time: Floats, run: Floats) -> float:
    """Complete cycles of `run` (n,), in its unit, at `time` (n,) [s]; 0 of a constant record."""
    weights(time)
    return 0.0 if is_constant(run) else float(len(peaks_of(time, run).crests))


def zero_crossing_period(time: Floats, run: Floats) -> float:
    """Mean time [s] between up-crossings of the mean.

    `run` (n,), in its unit, at `time` (n,) [s].
    """
    crossings = peaks_of(time, run).crossings
    if len(crossings) < 2:
        raise UndefinedError(f"the record crosses its mean upwards {len(crossings)} times, not 2")
    return float((crossings[-1] - crossings[0]) / (len(crossings) - 1))


def significant_height(time: Floats, run: Floats) -> float:
    """Mean of the highest third of heights of `run` (n,), in its unit, at `time` (n,) [s]."""
    return _highest_third(peaks_of(time, run).heights)


def significant_amplitude(time: Floats, run: Floats) -> float:
    """Mean of the highest third of amplitudes of `run` (n,), in its unit, at `time` (n,) [s]."""
    return _highest_third(peaks_of(time, run).amplitudes)


def _highest_third(sizes: Floats) -> float:
    if len(sizes) < 3:
        raise UndefinedError(f"the record has {len(sizes)} complete cycles, 3 are needed")
    return float(np.sort(sizes)[-(len(sizes) // 3) :].mean())


LEAST_ROWS = 3


def cycles_of(run: Floats) -> Floats:
    """Ranges, twice the amplitudes, and counts of rainflow cycles: (k, 2), in the unit and in 1.

    A count is 1 for a full cycle and 0.5 for a half one. `run` (n,), in its unit, is finite.
    """
    from rainflow import extract_cycles

    if is_constant(run):
        return np.zeros((0, 2))
    cycles = [(size, count) for size, _, count, *_ in extract_cycles(run.tolist())]
    return np.array(cycles).reshape(-1, 2)


def damage_equivalent_load(
    time: Floats, run: Floats, *, exponent: float, reference_frequency: float
) -> float:
    """Constant range, in the unit of `run` (n,), that does the damage of its rainflow cycles.

    It acts `reference_frequency` [Hz] times the duration of `time` (n,) [s] (IEC 61400-13);
    `exponent` [1] is that of the S-N curve, and means have no influence. 0 of a constant `run`
    (n,), in its unit.
    """
    weights(time)
    if len(run) < LEAST_ROWS:
        raise UndefinedError(f"the record has {len(run)} rows, {LEAST_ROWS} are needed")
    ranges, counts = cycles_of(run).T
    largest = float(ranges.max(initial=0.0))
    if largest == 0.0:
        return 0.0
    cycles = reference_frequency * float(time[-1] - time[0])
    damage = float(counts @ (ranges / largest) ** exponent)
    return largest * (damage / cycles) ** (1.0 / exponent)
