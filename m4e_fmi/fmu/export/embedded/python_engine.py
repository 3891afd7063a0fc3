"""A program run by plain Python: where the runtime's library cannot be loaded."""

from __future__ import annotations

from collections.abc import Sequence

from . import model  # type: ignore[attr-defined]  # the program's Python form, too
from .dormand_prince import DormandPrince  # type: ignore[import]  # packed beside this file
from .runge_kutta import RungeKutta  # type: ignore[import]


class PythonEngine:
    """`step` [s] is kept between calls of `advance`; the error per step is below `tolerance`.

    With the method rk4 steps are fixed, `step_size` [s] at most; all others are replaced by one.
    """

    def __init__(self, tolerance: float, *, method: str, step_size: float) -> None:
        self._p: list[float] = []
        self._c: list[float] = []
        self._u: list[float] = []
        if method == "rk4":
            self._integrator = RungeKutta(self._rates, step=step_size, tolerance=tolerance)
        else:
            self._integrator = DormandPrince(self._rates, tolerance=tolerance)

    @property
    def step(self) -> float:
        """Size [s] of the step to be tried next."""
        return self._integrator.step

    @step.setter
    def step(self, value: float) -> None:
        self._integrator.step = value

    @property
    def tolerance(self) -> float:
        """Bound of the error per step, relative and absolute."""
        return self._integrator.tolerance

    @tolerance.setter
    def tolerance(self, value: float) -> None:
        self._integrator.tolerance = value

    def set_parameters(self, p: list[float]) -> list[float]:
        """Calculated parameters, after parameters have been set to `p`."""
        self._p = p
        self._c = model.constants(p)
        return model.calculated(p, self._c)

    def set_inputs(self, u: list[float]) -> None:
        """Set the inputs, which are held during a step."""
        self._u = u

    def _rates(self, t: float, x: Sequence[float]) -> list[float]:
        return model.rates(t, x, self._u, self._p, self._c)

    def advance(self, t: float, x: list[float], t_end: float, *, held: bool) -> list[float]:  # noqa: ARG002
        """The states at t_end [s] from the states x at t; every call starts anew, `held` or not."""
        return self._integrator.advance(t, x, t_end)

    def save(self) -> list[float]:
        """Step size that `advance` goes on from, besides states, inputs and parameters."""
        return [self.step]

    def restore(self, saved: list[float]) -> None:
        """Take back what `save` returned."""
        [self.step] = saved

    def outputs(self, t: float, x: list[float]) -> list[float]:
        """Outputs at t [s] and the states x."""
        return model.outputs(t, x, self._u, self._p, self._c)
