"""The radiation memory of one group of coupled motions, and its errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.memory.vector_fitting import Complex, evaluate

TARGET, DAMPING_TARGET = 3e-3, 0.02  # errors that end the search for a higher order
POOR, POOR_DAMPING = 0.02, 0.03  # errors that are warned of


@dataclass(frozen=True)
class Misfit:
    """Errors of a fit to some data.

    Attributes
    ----------
    error : largest error of B over the motions' largest B, and of A over their A∞ [1].
    damping_error : largest error of B over B itself, where that is not negligible [1].
    damping_at : motion (index) and frequency [rad/s] of the `damping_error`.
    """

    error: float
    damping_error: float
    damping_at: tuple[int, float]

    @property
    def demerit(self) -> float:
        """The larger of both errors over its target; 1 or less ends the search for a fit."""
        return max(self.error / TARGET, self.damping_error / DAMPING_TARGET)

    @property
    def is_poor(self) -> bool:
        """True if an error deserves a warning."""
        return self.error > POOR or self.damping_error > POOR_DAMPING


@dataclass(frozen=True, kw_only=True)
class MemoryGroup:
    """The memory of some coupled motions, and how well it agrees with the data.

    Attributes
    ----------
    motions : (m,) indices of the motions.
    surplus : (m, m) [kg, kg.m, kg.m2] to be added to the table's A∞.
    inertia : (m,) [kg, kg.m2] |A∞| of the table.
    misfit : errors where the panels resolve the waves.
    misfit_of_all : errors at all frequencies that were used.
    resolved : (m,) frequencies [rad/s] up to which `misfit` has the error of the damping.
    ends : (m,) the last frequencies [rad/s] that were used.
    doubtful : angular frequencies [rad/s] that were left out as outliers.
    scattered : True if data above `resolved` were left out because they scatter.
    """

    motions: tuple[int, ...]
    surplus: np.ndarray
    inertia: np.ndarray
    misfit: Misfit
    misfit_of_all: Misfit
    resolved: np.ndarray
    ends: np.ndarray
    doubtful: tuple[float, ...] = ()
    scattered: bool = False

    @property
    def error(self) -> float:
        """The `misfit`'s largest error of B and A [1]."""
        return self.misfit.error

    @property
    def change(self) -> float:
        """Largest change of a motion's A∞ over its A∞ of the data [1]."""
        return float((np.abs(self.surplus.diagonal()) / np.maximum(self.inertia, 1e-300)).max())


@dataclass(frozen=True, kw_only=True)
class RadiationGroup(MemoryGroup):
    """Fitted retardation functions of some motions, passive at all frequencies.

    Attributes
    ----------
    poles : (k,) [1/s], one of each conjugate pair (Im ≥ 0), Re < 0.
    residues : (k, m, m) symmetric [force, motion], SI; K(s) = Σ r/(s − p) (+ conjugates).
    """

    poles: Complex
    residues: Complex

    @property
    def order(self) -> int:
        """Number of poles, pairs counting two."""
        return int(sum(2 if pole.imag > 0 else 1 for pole in self.poles))

    def transfer(self, omega: np.ndarray) -> np.ndarray:
        """K(jω) (n, m, m) [N.s/m, N.s, N.m.s] at `omega` (n,) [rad/s]."""
        values = evaluate(omega, self.poles, self.residues.transpose(1, 2, 0))
        return values.transpose(2, 0, 1)

    def impulse_response(self, time: np.ndarray) -> np.ndarray:
        """K(t) (n, m, m) [N/m, N, N.m] at `time` (n,) [s] ≥ 0.

        That is the force after a unit displacement at t = 0.
        """
        twice = np.where(self.poles.imag > 0, 2.0, 1.0)
        modes = twice * np.exp(np.asarray(time)[:, None] * self.poles)
        return np.einsum("tk,kij->tij", modes, self.residues).real
