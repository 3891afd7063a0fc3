"""Motions that leave the declared limits of outputs, as those of small motions in water."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from m4e_fmi.analysis.points import Floats, OperatingPoint
from m4e_fmi.analysis.response.linear_equations import LinearEquations
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.waves import Complex, InWaves

SIGNIFICANT = 2.0
"""Amplitude of a sea's response that counts, over its standard deviation."""


class Limits:
    """The outputs of a program that have limits, about a point."""

    def __init__(self, waves: InWaves, point: OperatingPoint) -> None:
        limited = [
            v
            for v in waves.program.outputs
            if v.derivative_of is None and np.isfinite([v.minimum, v.maximum]).any()
        ]
        self.outputs = tuple(limited)
        if limited:
            names = [v.name for v in limited]
            local = LocalEquations(waves.program, point, inputs=waves.inputs, outputs=names)
            self._linear = LinearEquations.of(local)

    def harmonics(self, states: Complex, forces: Complex) -> Complex:
        """Of the outputs (k, outputs), for `states` (k, n) and `forces` (k, m); all in SI."""
        return states @ self._linear.C.T + forces @ self._linear.D.T

    def passed(self, amplitudes: Floats, what: str) -> Iterator[str]:
        """A line for each output that leaves its limits by `amplitudes` (outputs,), in SI.

        `what` says which amplitude that is.
        """
        rest = self._linear.outputs
        for v, mean, size in zip(self.outputs, rest, amplitudes, strict=True):
            if mean + size > v.maximum or mean - size < v.minimum:
                yield (
                    f"{v.name}: {what} {size:.3g} {v.unit} leaves its limits, {v.minimum:.3g} to "
                    f"{v.maximum:.3g} {v.unit}: {v.description}"
                )
