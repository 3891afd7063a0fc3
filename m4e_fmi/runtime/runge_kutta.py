"""The classical Runge-Kutta method of order 4 in equal steps, on lists of floats.

There is no error control: a call costs the same whatever happens. Hairer, Nørsett, Wanner, Solving
Ordinary Differential Equations I, table 1.2. Standard library only: this file travels in FMUs.
"""

from collections.abc import Callable, Sequence
from math import ceil

Rates = Callable[[float, Sequence[float]], list[float]]


class RungeKutta:
    """Advances ẋ = rates(t, x) in the fewest equal steps that are not longer than `step` [s].

    `tolerance` changes nothing.
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
