"""Dormand and Prince's 5(4) pair with error control, on lists of floats.

One-step, so a change of the inputs between two calls costs nothing; the step size found is kept
from call to call. Coefficients: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I,
table 5.2; the fifth-order solution is propagated. Standard library only: this file travels in FMUs.
"""

from collections.abc import Callable, Sequence
from math import isfinite, sqrt

NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0)
STAGES = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
)
WEIGHTS = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)

SAFETY = 0.9
SMALLEST_FACTOR = 0.2
LARGEST_FACTOR = 10.0
SMALLEST_RELATIVE_STEP = 1e-14
FIRST_STEP = 1e-3

Rates = Callable[[float, Sequence[float]], list[float]]


class IntegrationError(ArithmeticError):
    """The step size fell below what floating point resolves, or a rate is not finite."""


class DormandPrince:
    """Advances ẋ = rates(t, x) with a local error ≤ tolerance·(1 + |x|) per step (RMS norm).

    `step` is the step size to be tried next, in seconds; `evaluations`, `accepted` and `rejected`
    count since the start.
    """

    def __init__(self, rates: Rates, *, tolerance: float = 1e-8, step: float = 0.0) -> None:
        if not tolerance > 0:
            raise ValueError(f"tolerance must be positive, got {tolerance}")
        self.rates = rates
        self.tolerance = tolerance
        self.step = step
        self.evaluations = 0
        self.accepted = 0
        self.rejected = 0

    def advance(self, t: float, x: list[float], t_end: float) -> list[float]:
        """The state at `t_end` from state `x` at `t`; t_end is met exactly.

        Raises IntegrationError with the time reached.
        """
        if not x:
            return []
        if self.step <= 0.0:
            self.step = min(FIRST_STEP, t_end - t)
        rate = self._rates(t, x)
        while t < t_end:
            remaining = t_end - t
            last = self.step >= remaining * (1 - 1e-12)
            h = remaining if last else self.step
            if h < SMALLEST_RELATIVE_STEP * max(abs(t), abs(t_end)):
                raise IntegrationError(
                    f"step size {h:.1e} s at t = {t:.9g} s is too small to go on"
                )
            candidate, rate_end, error = self._attempt(t, x, rate, h)
            factor = SAFETY * error**-0.2 if error > 0 else LARGEST_FACTOR
            if error <= 1.0:
                self.accepted += 1
                proposal = h * min(LARGEST_FACTOR, max(SMALLEST_FACTOR, factor))
                # a step cut short by t_end says nothing against the larger step known before
                self.step = max(proposal, self.step) if last else proposal
                t = t_end if last else t + h
                x, rate = candidate, rate_end
            else:
                self.rejected += 1
                self.step = h * max(SMALLEST_FACTOR, factor)
        return x

    def _attempt(
        self, t: float, x: list[float], rate: list[float], h: float
    ) -> tuple[list[float], list[float], float]:
        """One step of size h: state and rate at its end, and the error over the tolerance."""
        k = [rate]
        for node, row in zip(NODES[1:], STAGES[1:], strict=True):
            k.append(self._rates(t + node * h, _combined(x, k, row, h)))
        end = _combined(x, k, WEIGHTS, h)
        k.append(self._rates(t + h, end))
        total = 0.0
        for i, (before, after) in enumerate(zip(x, end, strict=True)):
            error = h * sum(e * rates[i] for e, rates in zip(ERROR, k, strict=True))
            scale = self.tolerance * (1.0 + max(abs(before), abs(after)))
            total += (error / scale) ** 2
        norm = sqrt(total / len(x))
        return end, k[-1], norm if isfinite(norm) else 1e10

    def _rates(self, t: float, x: Sequence[float]) -> list[float]:
        self.evaluations += 1
        return self.rates(t, x)


def _combined(
    x: list[float], k: list[list[float]], weights: tuple[float, ...], h: float
) -> list[float]:
    """x + h Σ wₘ kₘ, summed in the order of the stages."""
    result = []
    for i, value in enumerate(x):
        total = 0.0
        for weight, rates in zip(weights, k, strict=False):
            total += weight * rates[i]
        result.append(value + h * total)
    return result
