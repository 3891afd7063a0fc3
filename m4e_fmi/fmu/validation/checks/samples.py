"""Samples of an FMU's variables: derivatives from them, signs of a coarse solver, their pace.

Derivatives from values have an error estimate from the values themselves (Richardson). Solvers
inside FMUs that advance in fixed steps of their own are coarse, but not wrong: between two samples
the mean rate of such a solution lies between the rates at both ends, whatever the method: at the
first end for explicit Euler, at the last for implicit Euler. Inputs are to be small enough, and
steps short enough, for samples to show how an FMU moves.

Source: L. F. Richardson, "The deferred approach to the limit", Phil. Trans. R. Soc. A 226 (1927).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from m4e_fmi.fmu.validation.probe import Context, RefusedError

SAMPLES = 9
"""Equidistant samples that `at_centre` needs."""
CENTRE = SAMPLES // 2
SAFETY = 10.0
"""Between an error estimate and what is called a contradiction."""
_EPS = np.finfo(float).eps
EXCEPTIONS = 0.25
"""Part of the intervals, at most, in which a coarse solution may leave its rates: events."""
STEPS = 8
PARTS = 4
"""Samples of each step."""
SLOWER = 8.0
"""Ratio of the paces that are tried, one after the other."""
TRIES = 10
CURVED = 0.1
"""Second difference of the samples, as a part of their range, above which they do not show the
motion: an oscillation then has fewer than fourteen samples."""


class Slope(NamedTuple):
    """A derivative and a bound on its error, for each column."""

    value: np.ndarray
    error: np.ndarray


def at_centre(samples: np.ndarray, spacing: float) -> Slope:
    """Time derivative at the middle of `samples` (SAMPLES, n), in the variables' units.

    Rows are `spacing` [s] apart.
    """
    differences = [
        (samples[CENTRE + k] - samples[CENTRE - k]) / (2 * k * spacing) for k in (1, 2, 4)
    ]
    return _extrapolated(*differences, rounding=_rounding(samples, spacing))


def _extrapolated(
    fine: np.ndarray, middle: np.ndarray, coarse: np.ndarray, rounding: np.ndarray
) -> Slope:
    """From central differences with steps 1, 2 and 4: the error terms are h², h⁴, …"""
    once, before = (4 * fine - middle) / 3, (4 * middle - coarse) / 3
    return Slope((16 * once - before) / 15, np.abs(once - before) + rounding)


def central(above: np.ndarray, below: np.ndarray, steps: np.ndarray) -> Slope:
    """∂/∂v from values at v ± each of three steps, in ratio 1 : 2 : 4, one row for each.

    `above` and `below` (3, n), in the units of the values; `steps` (3,), in v's unit.

    The error also covers the differences between the three, and rounding in the largest of all
    values: small values may be differences of large ones.
    """
    differences = (above - below) / (2 * steps[:, None])
    rounding = np.max(_rounding(np.vstack([above, below]), float(steps[0])))
    found = _extrapolated(*differences, rounding=np.full(len(differences[0]), rounding))
    return Slope(found.value, found.error + np.ptp(differences, axis=0))


def _rounding(values: np.ndarray, spacing: float) -> np.ndarray:
    return SAFETY * _EPS * np.max(np.abs(values), axis=0) / spacing


def stands(samples: np.ndarray) -> np.ndarray:
    """Columns, as booleans (n,), that hold in some intervals and move in others.

    `samples` (n_times, n) are in the variables' units.
    """
    same = np.diff(samples, axis=0) == 0.0
    return same.any(axis=0) & ~same.all(axis=0)


def follows(samples: np.ndarray, rates: np.ndarray, spacing: float) -> np.ndarray:
    """Columns that change between two rows as the rates at both rows allow: booleans (n,).

    `samples` and `rates` (n_times, n), in the variables' units, and these per second. Rows are
    `spacing` [s] apart. Between the rows a smooth rate exceeds both ends by an eighth of its second
    difference at most; twice that is allowed. A column that holds in some intervals may be late by
    one interval.
    """
    means = np.diff(samples, axis=0) / spacing
    ends = np.array([rates[:-1], rates[1:]])
    bends = np.max(np.abs(np.diff(rates, 2, axis=0)), axis=0)
    slack = bends / 4 + SAFETY * np.finfo(float).eps * (
        np.max(np.abs(rates), axis=0) + np.max(np.abs(samples), axis=0) / spacing
    )
    inside = (means >= ends.min(axis=0) - slack) & (means <= ends.max(axis=0) + slack)
    regular = np.mean(~inside, axis=0) <= EXCEPTIONS
    # as a sum over all intervals: the mean of both ends, half their difference, one interval more
    total = np.abs(np.sum(means - ends.mean(axis=0), axis=0))
    allowed = np.sum(np.ptp(ends, axis=0) / 2 + slack, axis=0) + np.max(np.abs(rates), axis=0)
    return regular | (stands(samples) & (total <= allowed))


def paced(context: Context) -> Context:
    """The context at the pace at which samples of each step show the motion.

    At 1 if they do, or as much slower as it takes: inputs of the size 1 spin a small and light link
    thousands of times within a step. At 1, too, where the FMU allows no shorter steps, advances in
    longer steps of its own, or no pace shows a smooth motion.
    """
    for k in range(TRIES if context.subject.variable_steps else 0):
        slower = replace(context, pace=SLOWER**-k)
        try:
            samples = _samples(slower)
            if _most(stands(samples), samples):
                return replace(context, holds=True)
            if _smooth(samples):
                return slower
        except RefusedError:
            break
        if context.late:
            break
    return context


def _samples(context: Context) -> np.ndarray:
    """All Reals along a run with constant inputs, PARTS times a step."""
    sizes = np.full(PARTS * STEPS, context.step_size / PARTS)
    inputs = context.random_inputs()[0]
    return context.course(context.subject.readable, sizes, inputs=inputs)


def _smooth(samples: np.ndarray) -> bool:
    """True if samples of most variables that change lie on a smooth curve."""
    spread = np.ptp(samples, axis=0)
    curved = np.max(np.abs(np.diff(samples, 2, axis=0)), axis=0) > CURVED * spread
    return not _most(curved, samples)


def _most(chosen: np.ndarray, samples: np.ndarray) -> bool:
    """True if more than half of the variables that change are among the `chosen`."""
    moves = np.ptp(samples, axis=0) > 0
    return 2 * int((chosen & moves).sum()) > int(moves.sum())
