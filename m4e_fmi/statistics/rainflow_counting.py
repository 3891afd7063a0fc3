"""Rainflow cycles and equivalent loads: ASTM E1049-85, section 5.4.4, by the package rainflow.

Ranges that stay open at the end of a record count as half cycles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError
from m4e_fmi.shown import short
from m4e_fmi.statistics.record import LARGEST, Floats, UndefinedError, is_constant, weights

LEAST_ROWS = 3


@short
@dataclass(frozen=True)
class Rainflow:
    """Counted cycles: `ranges` and `means` (k,), in the unit of the record, `counts` (k,) [1].

    A count is 1 for a full cycle and 0.5 for a half one. A range is twice an amplitude.
    """

    ranges: Floats
    means: Floats
    counts: Floats

    def table(self) -> dict[float, float]:
        """Number of cycles by range, ascending; equal ranges together."""
        found: dict[float, float] = {}
        for size, count in sorted(zip(self.ranges.tolist(), self.counts.tolist(), strict=True)):
            found[size] = found.get(size, 0.0) + count
        return found

    def equivalent(self, exponent: float, cycles: float) -> float:
        """The range, in the unit of the record, of which `cycles` do the same damage.

        (Σ counts · ranges^exponent / cycles)^(1/exponent), for an S-N curve of that exponent.
        """
        largest = float(self.ranges.max(initial=0.0))
        if largest == 0.0:
            return 0.0
        damage = float(self.counts @ (self.ranges / largest) ** exponent)
        return largest * (damage / cycles) ** (1.0 / exponent)


def rainflow_cycles(values: ArrayLike) -> Rainflow:
    """Rainflow cycles of `values` (n,), in their unit; none of constant ones.

    InputError for fewer than 3 rows, several runs, or values that are not finite, or beyond 1e60.
    """
    x = np.asarray(values, dtype=float)
    if x.ndim != 1 or len(x) < LEAST_ROWS or not (np.abs(x) < LARGEST).all():
        message = (
            f"expected a row of at least {LEAST_ROWS} values below {LARGEST:g}, got shape {x.shape}"
        )
        raise InputError.single(message, "count each run by itself, without rows that are nan")
    return cycles_of(x)


def cycles_of(run: Floats) -> Rainflow:
    """Rainflow cycles of `run` (n,), finite, in its unit."""
    from rainflow import extract_cycles

    if is_constant(run):
        none = np.zeros(0)
        return Rainflow(none, none, none)
    found = np.array([cycle[:3] for cycle in extract_cycles(run.tolist())]).reshape(-1, 3)
    return Rainflow(found[:, 0], found[:, 1], found[:, 2])


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
    cycles = reference_frequency * float(time[-1] - time[0])
    return cycles_of(run).equivalent(exponent, cycles)
