"""The heading of hulls in space: axes turned about Z, and vectors and matrices in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.geometry.motions import X_Y_PAIRS
from m4e_fmi.program import Recorder, Scalar, Variable, cos, sin

Number = Scalar | float
PER_BODY = 6


@dataclass(frozen=True)
class Heading:
    """`angle` [deg] of the hulls' x axis from +X towards +Y in the reference pose.

    With a `filter_time` [s] it follows the yaw of the only body: ḣ = sin(ψ − h)/T.
    """

    angle: float = 0.0
    filter_time: float | None = None


@dataclass(frozen=True)
class Axes:
    """Axes that are turned about Z by an `angle` [rad], its `cosine` and `sine`."""

    angle: Number
    cosine: Number
    sine: Number

    @classmethod
    def at(cls, angle: Number) -> Axes:
        """Axes turned by `angle` [rad]."""
        return cls(angle, cos(angle), sin(angle))

    def to_world(self, vector: Sequence[Number]) -> list[Number]:
        """World components of a `vector` (6·N,) of motions or forces in these axes."""
        return self._turned(vector, self.sine)

    def from_world(self, vector: Sequence[Number]) -> list[Number]:
        """Components in these axes of a `vector` (6·N,) in world axes."""
        return self._turned(vector, -self.sine)

    def _turned(self, vector: Sequence[Number], sine: Number) -> list[Number]:
        found = list(vector)
        for body in range(0, len(found), PER_BODY):
            for pair in X_Y_PAIRS:
                x, y = vector[body + pair], vector[body + pair + 1]
                found[body + pair] = self.cosine * x - sine * y
                found[body + pair + 1] = sine * x + self.cosine * y
        return found

    def matrix_to_world(self, matrix: np.ndarray) -> list[list[Number]]:
        """World components of a `matrix` (n, n), in any unit, that is in these axes."""
        columns = [self.to_world([float(v) for v in column]) for column in matrix.T]
        return [self.to_world(row) for row in zip(*columns, strict=True)]


def record_heading(
    recorder: Recorder, heading: Heading, *, fixed: bool = False
) -> tuple[Axes, Axes]:
    """The axes of the reference pose, and those of now; the same without a filter.

    `fixed`: the heading must keep its value.
    """
    text = "heading of the reference pose: angle of the hulls' x axis, from +X towards +Y"
    start = math.radians(heading.angle)
    variable = Variable("heading", "rad", text, start=start, display_unit="deg")
    if fixed:
        text = f"{text}; the coefficients are for one direction of the waves from it only"
        variable = replace(variable, description=text, minimum=start, maximum=start)
    given = recorder.parameter(variable)
    reference = Axes.at(given)
    if heading.filter_time is None:
        return reference, reference
    text = "heading, that of the reference pose not included: the yaw, filtered"
    change = recorder.state(Variable("heading_change", "rad", text, local=True))
    return reference, Axes.at(given + change)


def record_filter(recorder: Recorder, heading: Heading, now: Axes, yaw: Number) -> None:
    """The rate of the heading that follows `yaw` [rad], if it does."""
    if heading.filter_time is None:
        return
    text = "time constant with which the heading follows the yaw"
    variable = Variable("heading_filter_time", "s", text, start=heading.filter_time, minimum=1e-3)
    recorder.rate("heading_change", sin(yaw - now.angle) / recorder.parameter(variable))


def reference_places(centers: np.ndarray, reference: Axes) -> list[tuple[Number, Number]]:
    """Reference places (x, y) [m] of the bodies, turned as one.

    `centers` (N, 3) [m] are those with heading 0. They turn about the vertical through the middle.
    """
    middle = centers[:, :2].mean(axis=0)
    places: list[tuple[Number, Number]] = []
    for dx, dy in (centers[:, :2] - middle).tolist():
        x, y, *_ = reference.to_world([dx, dy, 0.0, 0.0, 0.0, 0.0])
        places.append((float(middle[0]) + x, float(middle[1]) + y))
    return places
