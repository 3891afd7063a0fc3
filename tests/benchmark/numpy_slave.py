"""Slave of the benchmark: equations lambdified for NumPy, classical Runge-Kutta steps.

It travels in an FMU, beside `equations.py`, which has `SIZE` and the function of SymPy.
"""

import numpy as np

from .equations import SIZE, _lambdifygenerated  # type: ignore[import]  # packed beside this file
from .slave_base import M4eSlave  # type: ignore[import]


def rates(x):
    matrix, forcing = _lambdifygenerated(x)
    return np.concatenate([x[SIZE:], np.linalg.solve(matrix, forcing)[:, 0]])


class NumpySlave(M4eSlave):
    """The states are the first variables: coordinates, then speeds."""

    def step(self, t, h):  # noqa: ARG002
        x = np.array(self.values[: 2 * SIZE])
        k1 = rates(x)
        k2 = rates(x + h / 2 * k1)
        k3 = rates(x + h / 2 * k2)
        k4 = rates(x + h * k3)
        self.values[: 2 * SIZE] = (x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)).tolist()
