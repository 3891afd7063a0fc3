"""Motions that leave the declared limits of outputs, as those of small motions in water."""

from __future__ import annotations

from collections.abc import Iterator

from m4e_fmi.analysis.points import Floats, OperatingPoint
from m4e_fmi.analysis.response.linear_equations import LinearEquations
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.waves import Complex, InWaves
from m4e_fmi.simulate.limits import limited, limits_of

SIGNIFICANT = 2.0
"""Amplitude of a sea's response that counts, over its standard deviation."""


class Limits:
    """The outputs of a program that have limits, about a point."""

    def __init__(self, waves: InWaves, point: OperatingPoint) -> None:
        self.outputs = limited(waves.program)
        if self.outputs:
            names = [v.name for v in self.outputs]
            local = LocalEquations(waves.program, point, inputs=waves.inputs, outputs=names)
            self._linear = LinearEquations.of(local)  # pyrefly: ignore[possibly-uninitialized-attribute]

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
                yield f"{v.name}: {what} {size:.3g} {v.unit} leaves {limits_of(v)}"
