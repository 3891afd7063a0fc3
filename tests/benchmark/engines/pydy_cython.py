"""PyDy: its Cython generator on SymPy's Kane equations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmark.engine import Prepared, UnavailableError
from benchmark.engines.sympy_kane import kane
from benchmark.native_code import Floats
from benchmark.systems import GRAVITY, System
from benchmark.timing import cpu_seconds, python_batch


class PydyCython:
    name = "PyDy Cython"
    largest = 10
    largest_with_loads = 0

    def prepare(self, system: System) -> Prepared:
        try:
            import sympy
            from pydy.codegen import (
                ode_function_generators as pydy,
            )
        except ImportError as error:
            raise UnavailableError(f"PyDy cannot be imported: {error}") from error
        began = cpu_seconds()
        gravity = sympy.Symbol("gravity")
        method, q, u = kane(system, gravity)
        try:
            rates = pydy.generate_ode_function(
                method.forcing,
                q,
                u,
                constants=[gravity],  # without one, its compiled function refuses its arguments
                mass_matrix=method.mass_matrix,
                coordinate_derivatives=sympy.Matrix(u),
                generator="cython",
            )
        except (ImportError, OSError, RuntimeError) as error:
            raise UnavailableError(f"PyDy's extension does not compile: {error}") from error
        preparation = cpu_seconds() - began
        constants = np.array([GRAVITY])
        x = np.array([*system.q, *system.u])

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Floats:
            return rates(np.array([*q, *u]), 0.0, constants)[len(q) :]

        return Prepared(accelerations, python_batch(lambda: rates(x, 0.0, constants)), preparation)
