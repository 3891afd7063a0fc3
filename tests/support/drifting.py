"""Bodies in waves that only drift: no excitation, no radiation."""

from __future__ import annotations

import numpy as np
from support.calm_water import AREA, DISPLACED, RHO, G, calm

from m4e_adapters.hydrodynamics import Coefficients
from m4e_fmi.program import Program
from m4e_fmi.runtime.engine import Engine

__all__ = ["RHO", "G", "calm", "calm_in_space", "series"]


def calm_in_space(center: tuple[float, float, float] = (0.0, 0.0, -1.0)) -> Coefficients:
    """A body of 100 t in calm water, which takes waves of any direction."""
    omega = np.linspace(0.2, 3.0, 15)
    added = np.diag([2e4, 2e4, 6e4, 3e5, 3e5, 3e5])
    return Coefficients(
        bodies=("float",),
        centers=np.array([center]),
        omega=omega,
        added_mass=np.tile(added, (len(omega), 1, 1)),
        radiation_damping=np.zeros((len(omega), 6, 6)),
        added_mass_inf=added,
        excitation=np.zeros((len(omega), 6), dtype=complex),
        hydrostatic_stiffness=RHO * G * np.diag([0.0, 0.0, AREA, 200.0, 200.0, 0.0]),
        buoyancy=DISPLACED * G * np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        density=RHO,
        harmonics=np.zeros((len(omega), 1, 6), dtype=complex),
    )


def series(
    program: Program, times: np.ndarray, values: dict[str, float] | None = None
) -> dict[str, np.ndarray]:
    """Outputs (n,) of the program at rest, at `times` (n,) [s], for `values` of its parameters."""
    given = program.with_start(values or {})
    engine = Engine(given)
    start = np.array([state.start for state in given.states])
    found = engine.outputs_over(times, np.tile(start, (len(times), 1)))
    return {v.name: found[:, k] for k, v in enumerate(given.outputs)}
