"""Linear equations δẋ = A δx + B w, δy = C δx + D w, and their harmonics in waves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.points import Floats, OperatingPoint
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.waves import Complex, InWaves
from m4e_fmi.errors import RunError
from m4e_fmi.program import Variable
from m4e_fmi.simulate.limits import limited, limits_of

DRIFT = 1e-6
"""Mean rate, over that which a unit change of all states causes, from which on it is told."""
SCALINGS = 20
RANK = 1e-10
"""Singular values of the equations at rest below this part of the largest are zero."""


@dataclass(frozen=True)
class Held:
    """Changes of a mean that something holds at rest; a free body's surge and yaw are none.

    `columns` (n, r) are r such changes of the states, `rows` (r, n) the combinations of rates that
    balance them.
    """

    rows: Floats
    columns: Floats

    @classmethod
    def by(cls, A: Floats) -> Held:
        """Of the linear equations A (n, n) at rest, in SI."""
        rows, columns = np.ones(len(A)), np.ones(len(A))
        for _ in range(SCALINGS):  # so that the rank does not depend on units
            sizes = np.abs(A * np.outer(rows, columns))
            rows /= np.sqrt(_or_one(sizes.max(axis=1, initial=0.0)))
            columns /= np.sqrt(_or_one(sizes.max(axis=0, initial=0.0)))
        left, values, right = np.linalg.svd(A * np.outer(rows, columns))
        known = int(np.sum(values > RANK * values[0])) if len(A) else 0
        return cls(left[:, :known].T * rows, columns[:, None] * right[:known].T)

    def step(self, A: Floats, rates: Floats) -> Floats:
        """The change (n,) that makes `rates` (n,) zero as far as they are held, by A (n, n), SI.

        RunError if nothing holds a mean in these equations that is held at rest.
        """
        try:
            inner = np.linalg.solve(self.rows @ A @ self.columns, self.rows @ rates)
        except np.linalg.LinAlgError:
            message = "what holds the mean at rest does not hold it in this sea"
            raise RunError(message, "take a lower sea, or simulate") from None
        return np.asarray(-self.columns @ inner, dtype=float)


@dataclass(frozen=True)
class LinearEquations:
    """A (n, n), B (n, m), C (k, n), D (k, m) in SI, and what they are relative to.

    `rates` (n,) and `outputs` (k,) are those without motion.
    """

    name: str
    A: Floats
    B: Floats
    C: Floats
    D: Floats
    rates: Floats
    outputs: Floats

    @classmethod
    def of(cls, local: LocalEquations) -> LinearEquations:
        """Those about the point itself."""
        found = local.at_rest
        name = local.point.program.name
        return cls(name, found.A, found.B, found.C, found.D, found.rates, found.values)

    @classmethod
    def averaged(cls, local: LocalEquations, steps: Floats, forces: Floats) -> LinearEquations:
        """Those with the mean derivatives over the `steps` (s, n) with `forces` (s, m), in SI."""
        n, count = local.n, len(steps)
        weights = np.full((1, count), 1.0 / count, dtype=complex)
        slopes = np.real(local.averages(steps, forces, weights)[0])
        values = local.values(steps, forces).mean(axis=0)
        return cls(
            local.point.program.name,
            slopes[:n, :n], slopes[:n, n:], slopes[n:, :n], slopes[n:, n:], values[:n], values[n:],
        )  # fmt: skip

    def harmonics(
        self, omega: Floats, forces: Complex, *, decay: float = 0.0
    ) -> tuple[Complex, Complex]:
        """States (k, n) and outputs (k, outputs) [SI], for `forces` (k, m) [SI], those of inputs.

        With a `decay` [1] all motions decay by that part of ω, a guess where nothing damps them.
        For e^{−iωt} with `omega` (k,) [rad/s]. RunError at an undamped natural frequency.
        """
        shifted = (decay - 1j) * omega[:, None, None] * np.eye(len(self.A)) - self.A
        try:
            states = np.linalg.solve(shifted, (forces @ self.B.T)[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            message = f"{self.name}: one of the periods is an undamped natural period"
            raise RunError(message, "leave it out, or give the system some damping") from None
        outputs: Complex = states @ self.C.T + forces @ self.D.T
        return np.asarray(states, dtype=complex), outputs


def adrift(rest: LinearEquations, rates: Floats, states: Sequence[Variable]) -> str:
    """The state with the largest mean of its `rates` (n,) [SI], "" if changes balance them all.

    `rest` are the equations at rest.
    """
    if not len(rates):
        return ""
    left = np.abs(rates) / (1.0 + np.abs(rest.A).sum(axis=1))
    worst = int(np.argmax(left))
    return states[worst].name if left[worst] > DRIFT else ""


def _or_one(values: Floats) -> Floats:
    return np.where(values > 0.0, values, 1.0)


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
