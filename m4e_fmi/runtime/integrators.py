"""Integrators on lists of floats: Dormand and Prince's 5(4) pair, the classical Runge-Kutta method.

One-step, so a change of the inputs between two calls costs nothing; the step size found is kept
from call to call. Coefficients: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I,
tables 5.2 and 1.2; of the pair the fifth-order solution is propagated. Standard library only: this
file travels in FMUs.
"""

from collections.abc import Callable, Sequence
from math import ceil, isfinite, sqrt

C2, C3, C4, C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9
A21 = 1 / 5
A31, A32 = 3 / 40, 9 / 40
A41, A42, A43 = 44 / 45, -56 / 15, 32 / 9
A51, A52, A53, A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A61, A62, A63, A64, A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
B1, B3, B4, B5, B6 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
E1, E3, E4, E5, E6, E7 = 71 / 57600, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40

SAFETY = 0.9
SMALLEST_FACTOR = 0.2
LARGEST_FACTOR = 10.0
SMALLEST_RELATIVE_STEP = 1e-14
FIRST_STEP = 1e-3
HOPELESS = 1e10  # error, over the tolerance, of a trial step that gave no number

Rates = Callable[[float, Sequence[float]], list[float]]


class IntegrationError(ArithmeticError):
    """The rates cannot be computed, or change too fast for any step that time resolves."""


class DormandPrince:
    """Advances ẋ = rates(t, x) with a local error ≤ tolerance·(1 + |x|) per step (RMS norm).

    `step` is the step size to be tried next, in seconds; `evaluations`, `accepted` and `rejected`
    count since the start. The last `quadratures` states, on which no rate may depend, have a norm
    of their own; the larger of the two governs.
    """

    def __init__(
        self, rates: Rates, *, tolerance: float = 1e-8, step: float = 0.0, quadratures: int = 0
    ) -> None:
        if not tolerance > 0:
            raise ValueError(f"tolerance must be positive, got {tolerance}")
        self.rates = rates
        self.tolerance = tolerance
        self.step = step
        self.quadratures = quadratures
        self.evaluations = 0
        self.accepted = 0
        self.rejected = 0
        self._trouble = ""  # why the last trial step gave no number

    def advance(self, t: float, x: list[float], t_end: float) -> list[float]:
        """The state at `t_end` from state `x` at `t`; t_end is met exactly.

        A trial step in which `rates` raises ArithmeticError or ValueError is tried again shorter.
        Raises IntegrationError with the time reached.
        """
        if not x or t >= t_end:
            return x
        if self.step <= 0.0:
            self.step = min(FIRST_STEP, t_end - t)
        rate = self._first_rate(t, x)
        smallest = SMALLEST_RELATIVE_STEP * max(abs(t), abs(t_end))
        self.step = max(self.step, smallest)
        while t < t_end:
            remaining = t_end - t
            last = self.step >= remaining - smallest  # no sliver is left over for one more step
            h = remaining if last else self.step
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
            if self.step < smallest and t < t_end:
                cause = f": {self._trouble}" if self._trouble else ""
                message = f"step size {self.step:.1e} s at t = {t:.9g} s is too small to go on"
                raise IntegrationError(message + cause)
        return x

    def _first_rate(self, t: float, x: list[float]) -> list[float]:
        self.evaluations += 1
        try:
            return self.rates(t, x)
        except (ArithmeticError, ValueError) as error:
            raise IntegrationError(f"no rates at t = {t:.9g} s: {error}") from error

    def _attempt(
        self, t: float, x: list[float], k1: list[float], h: float
    ) -> tuple[list[float], list[float], float]:
        """One step of size h: state and rate at its end, and the error over the tolerance."""
        self._trouble = ""
        try:
            return self._step(t, x, k1, h)
        except (ArithmeticError, ValueError) as error:
            self._trouble = str(error)
            return x, k1, HOPELESS

    def _step(
        self, t: float, x: list[float], k1: list[float], h: float
    ) -> tuple[list[float], list[float], float]:
        f = self.rates
        k2 = f(t + C2 * h, [y + h * (A21 * a) for y, a in zip(x, k1, strict=True)])
        k3 = f(t + C3 * h, [y + h * (A31 * a + A32 * b) for y, a, b in zip(x, k1, k2, strict=True)])
        k4 = f(
            t + C4 * h,
            [
                y + h * (A41 * a + A42 * b + A43 * c)
                for y, a, b, c in zip(x, k1, k2, k3, strict=True)
            ],
        )
        k5 = f(
            t + C5 * h,
            [
                y + h * (A51 * a + A52 * b + A53 * c + A54 * d)
                for y, a, b, c, d in zip(x, k1, k2, k3, k4, strict=True)
            ],
        )
        k6 = f(
            t + h,
            [
                y + h * (A61 * a + A62 * b + A63 * c + A64 * d + A65 * e)
                for y, a, b, c, d, e in zip(x, k1, k2, k3, k4, k5, strict=True)
            ],
        )
        end = [
            y + h * (B1 * a + B3 * c + B4 * d + B5 * e + B6 * g)
            for y, a, c, d, e, g in zip(x, k1, k3, k4, k5, k6, strict=True)
        ]
        k7 = f(t + h, end)
        self.evaluations += 6
        tolerance = self.tolerance
        ratios = [
            h
            * (E1 * a + E3 * c + E4 * d + E5 * e + E6 * g + E7 * k)
            / (tolerance * (1.0 + max(abs(y), abs(z))))
            for y, z, a, c, d, e, g, k in zip(x, end, k1, k3, k4, k5, k6, k7, strict=True)
        ]
        motion = len(x) - self.quadratures
        norm = max(_rms(ratios[:motion]), _rms(ratios[motion:]))
        if not isfinite(norm + sum(ratios)):
            raise ArithmeticError("a rate is not finite")
        return end, k7, norm


def _rms(values: Sequence[float]) -> float:
    return sqrt(sum(v * v for v in values) / len(values)) if values else 0.0


class RungeKutta:
    """Advances ẋ = rates(t, x) in the fewest equal steps that are not longer than `step` [s].

    There is no error control: a call costs the same whatever happens, and `tolerance` changes
    nothing.
    """

    def __init__(self, rates: Rates, *, step: float, tolerance: float) -> None:
        self.rates = rates
        self.step = step
        self.tolerance = tolerance

    def advance(self, t: float, x: list[float], t_end: float) -> list[float]:
        """The state at `t_end` from state `x` at `t`. What `rates` raises is passed on."""
        for left in range(max(1, ceil((t_end - t) / self.step * (1 - 1e-9))), 0, -1):
            h = (t_end - t) / left
            x = self._step(t, x, h)
            t = t + h if left > 1 else t_end
        return x

    def _step(self, t: float, x: list[float], h: float) -> list[float]:
        f = self.rates
        k1 = f(t, x)
        k2 = f(t + h / 2, [y + h / 2 * a for y, a in zip(x, k1, strict=True)])
        k3 = f(t + h / 2, [y + h / 2 * b for y, b in zip(x, k2, strict=True)])
        k4 = f(t + h, [y + h * c for y, c in zip(x, k3, strict=True)])
        return [
            y + h / 6 * (a + 2 * b + 2 * c + d)
            for y, a, b, c, d in zip(x, k1, k2, k3, k4, strict=True)
        ]
