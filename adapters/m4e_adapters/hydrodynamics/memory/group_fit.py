"""The best passive fit of one group of coupled motions: its order, its frequencies, its A∞."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.flow import cache
from m4e_adapters.hydrodynamics.memory import soundness
from m4e_adapters.hydrodynamics.memory.passivity import Fit, UnprovenError, passive_fit
from m4e_adapters.hydrodynamics.memory.reach import Reach
from m4e_adapters.hydrodynamics.memory.vector_fitting import Complex, Samples, evaluate
from m4e_fmi.code_hash import package_hash
from m4e_fmi.errors import InputError

TARGET, DAMPING_TARGET = 3e-3, 0.02  # errors that end the search for a higher order
POOR, POOR_DAMPING = 0.02, 0.03  # errors that are warned of


@dataclass(frozen=True)
class Misfit:
    """Errors of a fit to some data.

    Attributes
    ----------
    error : largest error of B over the motions' largest B, and of A over their A∞ [1].
    damping_error : largest error of B over B itself, where that is not negligible [1].
    motion, omega : motion (index) and frequency [rad/s] of the `damping_error`.
    """

    error: float
    damping_error: float
    motion: float
    omega: float

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
    """

    motions: tuple[int, ...]
    surplus: np.ndarray
    inertia: np.ndarray
    misfit: Misfit
    misfit_of_all: Misfit
    resolved: np.ndarray
    ends: np.ndarray
    doubtful: tuple[float, ...] = ()

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
        found = evaluate(self.omega, fit.poles, residues.transpose(1, 2, 0)).transpose(2, 0, 1)
        misfits = self.misfits_of(found, surplus)
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

    def misfits_of(self, found: Complex, surplus: np.ndarray) -> tuple[Misfit, Misfit]:
        """Errors of a memory where the panels resolve the waves, and at all frequencies.

        K(jω) `found` (n, m, m) [N.s/m, N.s, N.m.s] at `omega`; `surplus` (m, m) [kg, kg.m, kg.m2]
        is added to A∞.
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
            motion=self.motions[motion],
            omega=float(self.omega[at]),
        )

    def _full(self, upper: np.ndarray) -> np.ndarray:
        """Symmetric matrices (…, m, m) with the upper triangles `upper` (…, pairs)."""
        size = len(self.motions)
        found = np.zeros((*upper.shape[:-1], size, size), dtype=upper.dtype)
        found[..., self.rows, self.columns] = found[..., self.columns, self.rows] = upper
        return found


ORDERS = (4, 5, 6, 8, 10, 12, 16)
LAST_ORDER = 20  # tried where all of these are poor
EVALUATIONS = 10  # of the poles' least squares, derivatives not counted
NEAR_BEST = 1.5  # how much larger an error than the best is accepted for fewer states
DISAGREE = 0.01  # error of A over A∞ from which A∞ is fitted too


def fit_group(
    data: Coefficients,
    motions: tuple[int, ...],
    signal: np.ndarray,
    sound: np.ndarray,
    *,
    reach: Reach,
    order: int | None,
) -> RadiationGroup:
    """The best fit of one group: to all data, or to the data that the panels resolve.

    `signal` (n, n), booleans: pairs of motions that count. `sound` (nω,), booleans: frequencies
    that count. The shorter data are used if the fit to all is poor or changes A∞, and if they give
    a better one where the panels resolve the waves. InputError if no passive fit is found.
    """

    def within(limits: Reach) -> GroupData:
        return GroupData(data, motions, signal, sound, limits)

    found = _fitted(within(reach), order)
    shorter, own = reach.shorter(), list(motions)
    doubtful = found is None or found.misfit.is_poor or found.change > 0
    if doubtful and (shorter.fitted < reach.fitted)[own].any():
        other = _fitted(within(shorter), order)
        if found is None or (other is not None and other.misfit.demerit < found.misfit.demerit):
            found = other
    if found is None:
        raise InputError.single(
            "no passive radiation memory was found", "use another radiation.order"
        )
    return found


def _fitted(values: GroupData, order: int | None) -> RadiationGroup | None:
    """The best fit to the values; with an A∞ of its own where that halves the error."""
    given = _best(values, order, offset=False)
    if given is not None and given.misfit_of_all.error < DISAGREE:
        return given
    other = _best(values, order, offset=True)
    if given is None:
        return other
    worth = other is not None and other.misfit_of_all.error < given.misfit_of_all.error / 2
    return other if worth else given


def _best(values: GroupData, order: int | None, *, offset: bool) -> RadiationGroup | None:
    """The fit with the fewest poles that is good, or nearly as good as any; None: none passive."""
    samples = values.samples(offset=offset)
    fits: list[RadiationGroup] = []
    for k in (*ORDERS, LAST_ORDER) if order is None else (order,):
        if k == LAST_ORDER and any(not fit.misfit_of_all.is_poor for fit in fits):
            break
        try:
            fit = passive_fit(samples, order=k, evaluations=EVALUATIONS)
        except UnprovenError:
            continue
        fits.append(values.judged_fit(fit))
        if fits[-1].misfit_of_all.demerit <= 1:
            break
    if not fits:
        return None
    best = min((fit.misfit_of_all for fit in fits), key=lambda misfit: misfit.demerit)
    enough = max(1.0, best.demerit if best.is_poor else NEAR_BEST * best.demerit)
    return next(fit for fit in fits if fit.misfit_of_all.demerit <= enough)


LIBRARIES = ("numpy", "scipy")  # whose versions count


def kept_group(
    data: Coefficients,
    motions: tuple[int, ...],
    signal: np.ndarray,
    sound: np.ndarray,
    *,
    reach: Reach,
    order: int | None,
    progress: Callable[[str], object],
) -> RadiationGroup:
    """As `group_fit.fit_group`, computed once for the same data.

    `signal` (n, n), booleans: pairs of motions that count. `sound` (nω,), booleans: frequencies
    that count.
    """
    content: dict[str, ArrayLike] = {
        "code": [package_hash("m4e_adapters.hydrodynamics.memory")],
        "libraries": [f"{name} {version(name)}" for name in LIBRARIES],
        "motions": motions,
        "order": -1 if order is None else order,
        "signal": signal,
        "sound": sound,
        "fitted": reach.fitted,
        "resolved": reach.resolved,
        "omega": data.omega,
        "added_mass": data.added_mass,
        "radiation_damping": data.radiation_damping,
        "added_mass_inf": data.added_mass_inf,
        "limits": data.memory_limits,
    }
    key = cache.content_key(content)
    arrays = cache.found(key, progress)
    if arrays is not None:
        return _unpacked(arrays)
    group = fit_group(data, motions, signal, sound, reach=reach, order=order)
    cache.keep(key, _packed(group), progress)
    return group


def _packed(group: RadiationGroup) -> dict[str, np.ndarray]:
    return {
        name: np.array(astuple(value) if isinstance(value, Misfit) else value)
        for name, value in vars(group).items()
    }


def _unpacked(arrays: Mapping[str, np.ndarray]) -> RadiationGroup:
    fields: dict[str, Any] = dict(arrays)
    for name in ("motions", "doubtful"):
        fields[name] = tuple(arrays[name].tolist())
    for name in ("misfit", "misfit_of_all"):
        fields[name] = Misfit(*arrays[name].tolist())
    return RadiationGroup(**fields)
