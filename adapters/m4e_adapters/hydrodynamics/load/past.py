"""The past velocity as states, and the forces that it makes: see `memory.history`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from m4e_adapters.hydrodynamics.memory.convolution import ConvolutionGroup
from m4e_fmi.program import Recorder, Scalar


def record_past(
    recorder: Recorder,
    past: Sequence[tuple[str, Scalar]],
    velocity: Scalar | float,
    *,
    duration: float,
) -> None:
    """Rates of the states `past`, by name, that are the velocity over the last `duration` [s]."""
    end: Scalar | float = 0.0
    for _, value in past:
        end = end + value
    sums: list[Scalar | float] = [velocity - end, -velocity - end]  # of even, of odd polynomials
    for n, (name, value) in enumerate(past):
        recorder.rate(name, (2 * n + 1) / duration * sums[n % 2])
        sums[1 - n % 2] = sums[1 - n % 2] + 2.0 * value


def add_convolution(
    force: list[Scalar | float],
    past: Sequence[Scalar],
    velocity: Scalar | float,
    *,
    group: ConvolutionGroup,
    column: int,
) -> None:
    """Add to the forces on all motions what the past of the group's motion `column` makes."""
    own = group.motions[column]
    force[own] = force[own] - float(group.damping[column]) * velocity
    for row, target in enumerate(group.motions):
        weights = group.weights[:, row, column]
        if not np.any(weights):
            continue
        total: Scalar | float = 0.0
        for weight, value in zip(weights.tolist(), past, strict=True):
            total = total + weight * value
        force[target] = force[target] - total
