"""Rainflow cycles and equivalent loads: ASTM E1049-85, section 5.4.4, by the package rainflow.

Ranges that stay open at the end of a record count as half cycles.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.statistics.record import Floats, UndefinedError, is_constant, weights

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
