"""A program run by plain Python: where the runtime's library cannot be loaded."""

from . import model  # type: ignore[attr-defined]  # the program's Python form, too
from .dormand_prince import DormandPrince  # type: ignore[import]  # packed beside this file
from .runge_kutta import RungeKutta  # type: ignore[import]


class PythonEngine:
    """`step` [s] is kept between calls of `advance`; the error per step is below `tolerance`.

    With the method rk4 steps are fixed, `step_size` [s] at most; all others are replaced by one.
    """

    def __init__(self, tolerance, *, method, step_size):
        self._p, self._c, self._u = [], [], []
        if method == "rk4":
            self._integrator = RungeKutta(self._rates, step=step_size, tolerance=tolerance)
        else:
            self._integrator = DormandPrince(self._rates, tolerance=tolerance)

    @property
    def step(self):
        return self._integrator.step

    @step.setter
    def step(self, value):
        self._integrator.step = value

    @property
    def tolerance(self):
        return self._integrator.tolerance

    @tolerance.setter
    def tolerance(self, value):
        self._integrator.tolerance = value

    def set_parameters(self, p):
        """Take parameters; returns the calculated ones."""
        self._p = p
        self._c = model.constants(p)
        return model.calculated(p, self._c)

    def set_inputs(self, u):
        self._u = u

    def _rates(self, t, x):
        return model.rates(t, x, self._u, self._p, self._c)

    def advance(self, t, x, t_end):
        """The states at t_end [s] from the states x at t."""
        return self._integrator.advance(t, x, t_end)

    def outputs(self, t, x):
        return model.outputs(t, x, self._u, self._p, self._c)
