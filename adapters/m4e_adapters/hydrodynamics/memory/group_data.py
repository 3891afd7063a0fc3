"""The data that a group of coupled motions is fitted to, and the errors of a fit."""

from __future__ import annotations

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory import soundness
from m4e_adapters.hydrodynamics.memory.passivity import Fit
from m4e_adapters.hydrodynamics.memory.radiation_group import Misfit, RadiationGroup
from m4e_adapters.hydrodynamics.memory.reach import Reach
from m4e_adapters.hydrodynamics.memory.vector_fitting import Complex, Samples, evaluate

WEAK = 5e-3  # B over its largest below which its errors do not count for more
RELEVANT = 0.01  # likewise, from which the damping's relative error is judged


class GroupData:
    """The data of one group of motions, and the errors of fits to them.

    Errors count by what they do to a motion. Those of B are relative to the motion's largest B, and
    where B is small, so at many a resonance, nearly to B itself: there it alone limits the motion.
    Those of A are relative to A∞: A is part of an inertia, however small the memory in it.
    Frequencies off the common line, irregular ones above all, are left out.

    Parameters
    ----------
    signal : (n, n), booleans: pairs of motions whose values are more than noise.
    sound : (nω,), booleans: frequencies at which B is not negative.
    """

    def __init__(
        self,
        data: Coefficients,
        motions: tuple[int, ...],
        signal: np.ndarray,
        sound: np.ndarray,
        reach: Reach,
    ) -> None:
        place, own = np.ix_(motions, motions), list(motions)
        self.motions = motions
        self.rows, self.columns = np.triu_indices(len(motions))
        self.limits, self.resolved = reach.limits[own], reach.resolved[own]
        fitted = np.minimum(reach.fitted[own], data.omega[-1])
        self.ends = fitted
        used = sound & (data.omega <= fitted.max())
        self.omega = data.omega[used]
        real = signal[place]
        every = (range(int(used.sum())), motions, motions)
        self.damping = data.radiation_damping[used][np.ix_(*every)] * real
        self.added_mass = (data.added_mass - data.added_mass_inf)[used][np.ix_(*every)] * real
        matters = data.omega[:, None] <= self.limits
        diagonal = data.radiation_damping.diagonal(axis1=1, axis2=2)[:, own]
        self.own = np.where(matters, diagonal, 0.0).max(axis=0)
        self.inertia = np.abs(data.added_mass_inf.diagonal())[own]
        self.scale = np.sqrt(np.outer(self.own, self.own))
        values = self.damping + 1j * self.omega[:, None, None] * self.added_mass
        self.values = (values / self.scale)[:, self.rows, self.columns].T
        within = self._within(fitted)
        trusted = soundness.on_the_line(self.omega, self.values, within.T)
        self.doubtful = tuple(float(w) for w in self.omega[~trusted])
        self.known = trusted[:, None] & within

    def _within(self, ends: np.ndarray) -> np.ndarray:
        """True (n, pairs) where a frequency is below the `ends` (m,) [rad/s] of both motions."""
        return self.omega[:, None] <= np.minimum(ends[self.rows], ends[self.columns])

    def samples(self, *, offset: bool) -> Samples:
        """The values to fit, K(0) = 0 included; `offset`: with a change of A∞."""
        relative = np.sqrt(np.abs(self.damping.diagonal(axis1=1, axis2=2)) / self.own)
        share = (relative[:, self.rows] * relative[:, self.columns]).T  # of the largest B
        inertia = np.sqrt(np.outer(self.inertia, self.inertia)) / self.scale
        of_damping = np.maximum(share, WEAK) ** -0.5 * self.known.T
        of_mass = self.known.T / (self.omega * inertia[self.rows, self.columns][:, None])
        count = len(self.values)
        # K(0) = 0 weighs as much as a third of the weakest B of a response together
        at_zero = np.full((count, 1), WEAK**-0.5 * np.sqrt(len(self.omega)) / 3)
        nothing = np.zeros((count, 1))
        return Samples(
            omega=np.concatenate([[0.0], self.omega]),
            values=np.concatenate([nothing + 0j, self.values], axis=1),
            weights=np.concatenate([at_zero, of_damping, nothing, of_mass], axis=1),
            offset=offset,
        )

    def judged_fit(self, fit: Fit) -> RadiationGroup:
        """The `fit` in SI units, with its errors."""
        residues = self._full(fit.residues.T) * self.scale
        surplus = self._full(fit.offset) * self.scale
        misfits = self.misfits(fit.poles, residues, surplus)
        return RadiationGroup(
            motions=self.motions,
            poles=fit.poles,
            residues=residues,
            surplus=surplus,
            inertia=self.inertia,
            misfit=misfits[0],
            misfit_of_all=misfits[1],
            resolved=self.resolved,
            ends=self.ends,
            doubtful=self.doubtful,
        )

    def misfits(
        self, poles: Complex, residues: Complex, surplus: np.ndarray
    ) -> tuple[Misfit, Misfit]:
        """Errors of any fit where the panels resolve the waves, and at all frequencies.

        `poles` (k,) [1/s], `residues` (k, m, m) and `surplus` (m, m), SI, as of a RadiationGroup.
        """
        found = evaluate(self.omega, poles, residues.transpose(1, 2, 0)).transpose(2, 0, 1)
        return self.misfits_of(found, surplus)

    def misfits_of(self, found: Complex, surplus: np.ndarray) -> tuple[Misfit, Misfit]:
        """As `misfits`, of a memory K(jω) `found` (n, m, m) [N.s/m, N.s, N.m.s] at `omega`.

        `surplus` (m, m) [kg, kg.m, kg.m2] is added to A∞.
        """
        mass = found.imag / self.omega[:, None, None] + surplus
        errors = found.real - self.damping, mass - self.added_mass
        return self._misfit(*errors, self.resolved), self._misfit(*errors, self.limits)

    def _misfit(self, damping: np.ndarray, mass: np.ndarray, ends: np.ndarray) -> Misfit:
        """Largest errors of (n, m, m); those of B over B count up to `ends` (m,) [rad/s]."""
        further = np.where(ends < self.limits, ends, np.inf)
        known = self._full(self.known & self._within(further))
        damping, mass = np.abs(damping) * known, np.abs(mass) * known
        error = max(
            float((damping / self.scale).max()),
            float((mass / np.sqrt(np.outer(self.inertia, self.inertia))).max()),
        )
        own = self.damping.diagonal(axis1=1, axis2=2)
        counts = (self.omega[:, None] <= ends) & (own > RELEVANT * self.own)
        relative = np.where(counts, damping.diagonal(axis1=1, axis2=2) / np.maximum(own, 1e-300), 0)
        at, motion = np.unravel_index(int(relative.argmax()), relative.shape)
        return Misfit(
            error=error,
            damping_error=float(relative[at, motion]),
            damping_at=(self.motions[motion], float(self.omega[at])),
        )

    def _full(self, upper: np.ndarray) -> np.ndarray:
        """Symmetric matrices (…, m, m) with the upper triangles `upper` (…, pairs)."""
        size = len(self.motions)
        found = np.zeros((*upper.shape[:-1], size, size), dtype=upper.dtype)
        found[..., self.rows, self.columns] = found[..., self.columns, self.rows] = upper
        return found
