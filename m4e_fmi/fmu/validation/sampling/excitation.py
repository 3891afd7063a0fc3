"""Inputs small enough, and steps short enough, for samples to show how an FMU moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from m4e_fmi.fmu.validation.context import Context
from m4e_fmi.fmu.validation.probe import RefusedError
from m4e_fmi.fmu.validation.sampling.coarse import stands

STEPS = 8
PARTS = 4
"""Samples of each step."""
SLOWER = 8.0
"""Ratio of the paces that are tried, one after the other."""
TRIES = 10
CURVED = 0.1
"""Second difference of the samples, as a part of their range, above which they do not show the
motion: an oscillation then has fewer than fourteen samples."""


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
    inputs = context.random_inputs()[0]
    with context.probe() as probe:
        probe.begin(initial_inputs=inputs)
        seen = [probe.read(context.subject.readable)]
        for _ in range(PARTS * STEPS):
            probe.advance(context.step_size / PARTS)
            seen.append(probe.read(context.subject.readable))
        return np.array(seen)


def _smooth(samples: np.ndarray) -> bool:
    """True if samples of most variables that change lie on a smooth curve."""
    spread = np.ptp(samples, axis=0)
    curved = np.max(np.abs(np.diff(samples, 2, axis=0)), axis=0) > CURVED * spread
    return not _most(curved, samples)


def _most(chosen: np.ndarray, samples: np.ndarray) -> bool:
    """True if more than half of the variables that change are among the `chosen`."""
    moves = np.ptp(samples, axis=0) > 0
    return 2 * int((chosen & moves).sum()) > int(moves.sum())
