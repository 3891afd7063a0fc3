"""Hydrodynamic coefficients beside the radiation memory that is fitted to them, for a report.

A kind of FMU with coefficients offers them by its functions `hydrodynamic_data` and
`config_of_file`: docs/adapters.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """A motion of a body, as "float heave", with units of force and position ("N", "m")."""

    name: str
    force_unit: str
    unit: str


@dataclass(frozen=True)
class FittedMemory:
    """The memory of some motions (indices): number of `poles` and `states`, and its errors [1].

    `error` is that of B over its largest and of A over A∞, `damping_error` that of B over itself
    where it is not negligible.
    """

    motions: tuple[int, ...]
    poles: int
    states: int
    error: float
    damping_error: float


@dataclass(frozen=True)
class HydrodynamicData:
    """Coefficients of n motions, and what a program makes of them.

    Attributes
    ----------
    omega : (nω,) angular frequencies [rad/s].
    added_mass, damping : (nω, n, n) of the data [kg, kg.m, kg.m2], [N.s/m, N.s, N.m.s].
    added_mass_inf : (n, n) [kg, kg.m, kg.m2], of the data.
    stiffness : (n, n) hydrostatic [N/m, N, N.m].
    fit_omega : (m,) [rad/s], at which the fit is evaluated.
    fit_added_mass, fit_damping : (m, n, n) of the fit, units as of the data.
    time : (k,) [s].
    memory, fit_memory : (k, n, n) K(t) by the cosine transform of B, and of the fit [N/m, N, N.m].
    directions : (nβ,) [deg] that waves travel to.
    excitation : (nω, nβ, n) complex, e^{−iωt} [N/m, N.m/m].
    memories : the fitted groups.
    states, operations : of the program; operations are those of one evaluation with all outputs.
    findings : (name, text, True if it deserves a warning).
    notes : lines on sources, and warnings.
    """

    title: str
    motions: tuple[Motion, ...]
    omega: np.ndarray
    added_mass: np.ndarray
    damping: np.ndarray
    added_mass_inf: np.ndarray
    stiffness: np.ndarray
    fit_omega: np.ndarray
    fit_added_mass: np.ndarray
    fit_damping: np.ndarray
    time: np.ndarray
    memory: np.ndarray
    fit_memory: np.ndarray
    directions: np.ndarray
    excitation: np.ndarray
    memories: tuple[FittedMemory, ...]
    states: int
    operations: int
    findings: Sequence[tuple[str, str, bool]]
    notes: tuple[str, ...]
