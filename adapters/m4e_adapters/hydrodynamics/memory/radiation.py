"""Radiation memory: the retardation functions K(jω) = B + jω(A − A∞) as a stable state space.

Motions that are coupled (directly or through others) form a group; a group's whole symmetric matrix
is fitted with *one* set of poles. The states are then driven by the velocities, poles × motions of
them, instead of poles × pairs of motions, and the fitted matrix is exactly symmetric. A single
body symmetric fore and aft has the groups {surge, pitch} and {heave}.

The fits are strictly proper (relative degree one), as K is: K → K(t=0)/(jω). That carries them
beyond the table. K(0) = 0 (a steady velocity feels no memory) is fitted as a further value, and the
residues are chosen among those that make the matrix passive at all frequencies.

Errors count by what they do to a motion. Those of B are relative to the motion's largest B, and
where B is small, so at many a resonance, nearly to B itself: there it alone limits the motion.
Those of A are relative to A∞: A is part of an inertia, however small the memory in it. Frequencies
off the common line, irregular ones above all, are left out.

Of each motion the frequencies up to its `Coefficients.memory_limits` are used, and further, as far
as the panels resolve the waves, while B is more than `reach.TAIL` of its largest. Beyond, values
are small, and what panels spoil first breaks the causality that ties B to A. Where the fit is poor,
the frequencies that the panels do not resolve, or at which data scatter, are left out altogether,
and the tail follows from A∞ and causality; that is kept if it is better where the data are good.

Where A(ω) is not what A∞ and B say it should be, A∞ is the one that fits best.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory import soundness
from m4e_adapters.hydrodynamics.memory.passivity import Fit, UnprovenError, passive_fit
from m4e_adapters.hydrodynamics.memory.reach import Reach, check_counts
from m4e_adapters.hydrodynamics.memory.vector_fitting import Complex, Samples, evaluate
from m4e_fmi.errors import InputError

ORDERS = (4, 5, 6, 8, 10, 12, 16)
EVALUATIONS = 10  # of the poles' least squares, derivatives not counted
TARGET, DAMPING_TARGET = 3e-3, 0.02  # errors that end the search for a higher order
POOR, POOR_DAMPING, USELESS = 0.02, 0.03, 0.2  # warned of, refused
NEAR_BEST = 1.5  # how much larger an error than the best is accepted for fewer states
DISAGREE = 0.01  # error of A over A∞ from which A∞ is fitted too
LARGE_CHANGE = 0.05  # of A∞ by the fit, over A∞, that is warned of
REMEDY = (
    "raise radiation.order or leave it out; use more panels where they are coarse for the highest "
    "waves, or a lower frequencies.maximum; for bodies far apart, whose waves arrive late, raise "
    "frequencies.count"
)
NEGLIGIBLE = 1e-3  # coupling, relative to the geometric mean of the motions' own
SILENT = 1e-6  # largest B over ω A∞ below which a motion has no memory
FELT = 1e-4  # likewise, B over ω times the displaced water's inertia: a damping ratio below 5e-5
WEAK = 5e-3  # B over its largest below which its errors do not count for more
STILL_LARGE = 0.5  # likewise, at the end of the data, from which a missing tail is told
NEARLY = 0.95  # of a motion's memory limit: data up to there are complete
RELEVANT = 0.01  # likewise, from which the damping's relative error is judged


@dataclass(frozen=True)
class Misfit:
    """Errors of a fit to some data.

    Attributes
    ----------
    error : the largest of B over the motions' largest B, and of A over their A∞.
    damping_error : the largest of B over B itself where it is RELEVANT.
    damping_at : its motion (index) and its frequency [rad/s].
    """

    error: float
    damping_error: float
    damping_at: tuple[int, float]

    @property
    def demerit(self) -> float:
        """Errors over what is wanted, the largest; 1 or less ends the search."""
        return max(self.error / TARGET, self.damping_error / DAMPING_TARGET)

    @property
    def is_poor(self) -> bool:
        """Whether that deserves a warning."""
        return self.error > POOR or self.damping_error > POOR_DAMPING


@dataclass(frozen=True)
class RadiationGroup:
    """Fitted retardation functions of some motions, passive at all frequencies.

    Attributes
    ----------
    motions : (m,) indices of the motions.
    poles : (k,) [1/s], one of each conjugate pair (Im ≥ 0), Re < 0.
    residues : (k, m, m) symmetric [force, motion]; K(s) = Σ r/(s − p) (+ conjugates).
    surplus : (m, m) what A∞ is to be more than the table's.
    inertia : (m,) |A∞| of the table.
    misfit : errors where the panels resolve the waves.
    misfit_of_all : errors at all frequencies that were fitted.
    resolved : (m,) frequencies [rad/s] up to which `misfit` tells the error of the damping.
    ends : (m,) the last frequencies [rad/s] that were fitted.
    doubtful : angular frequencies [rad/s] that were left out as outliers.
    scattered : whether data above `resolved` were left out because they scatter.
    """

    motions: tuple[int, ...]
    poles: Complex
    residues: Complex
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
        """That of `misfit`."""
        return self.misfit.error

    @property
    def change(self) -> float:
        """Largest change of a motion's A∞, over its A∞ of the data."""
        return float((np.abs(self.surplus.diagonal()) / np.maximum(self.inertia, 1e-300)).max())

    @property
    def order(self) -> int:
        """Number of poles, pairs counting two."""
        return int(sum(2 if pole.imag > 0 else 1 for pole in self.poles))

    def transfer(self, omega: np.ndarray) -> np.ndarray:
        """K(jω), (n, m, m)."""
        values = evaluate(omega, self.poles, self.residues.transpose(1, 2, 0))
        return values.transpose(2, 0, 1)

    def impulse_response(self, time: np.ndarray) -> np.ndarray:
        """K(t), (n, m, m), for t ≥ 0 [s]: the force after a unit displacement at t = 0."""
        twice = np.where(self.poles.imag > 0, 2.0, 1.0)
        modes = twice * np.exp(np.asarray(time)[:, None] * self.poles)
        return np.einsum("tk,kij->tij", modes, self.residues).real


@dataclass(frozen=True)
class RadiationMemory:
    """The `groups` of all motions that radiate, and the A∞ (n, n) that belongs to them."""

    groups: tuple[RadiationGroup, ...]
    added_mass_inf: np.ndarray


def _silent(_: str) -> None:
    pass


def fit_radiation(
    coefficients: Coefficients,
    *,
    order: int | None = None,
    progress: Callable[[str], object] = _silent,
) -> RadiationMemory:
    """The memory of all motions; what was reached is told through `progress`.

    `order` None: for each group the smallest of ORDERS that is accurate to TARGET and
    DAMPING_TARGET, or nearly the best if none is. InputError if the best is USELESS, or if the
    data make energy.
    """
    signal = soundness.meaningful(coefficients)
    reach = Reach.of(coefficients)
    below = coefficients.omega[:, None] <= reach.resolved
    check_counts(coefficients, reach)
    sound = soundness.dissipative(coefficients, below, progress)
    data = soundness.symmetric(coefficients, below, progress)
    added_mass_inf = data.added_mass_inf.copy()
    groups, coupled = [], _coupled(data, signal)
    _tell_of_silent_bodies(data, coupled, progress)
    for motions in coupled:
        group = _group(data, motions, signal, sound, reach, order)
        text = _report(group, data)
        if group.error > USELESS:
            raise InputError.single(text, REMEDY)
        told = group.misfit.is_poor or group.scattered or group.change > LARGE_CHANGE
        progress(f"warning: {text}: {REMEDY}" if told else text)
        _tell_of_early_ends(group, data, progress)
        added_mass_inf[np.ix_(motions, motions)] += group.surplus
        groups.append(group)
    soundness.check_added_mass_inf(data, added_mass_inf)
    return RadiationMemory(tuple(groups), added_mass_inf)


def _tell_of_silent_bodies(
    data: Coefficients, groups: list[tuple[int, ...]], progress: Callable[[str], object]
) -> None:
    """Name the bodies none of whose motions has a memory."""
    radiating = {motion // 3 for motions in groups for motion in motions}
    for k, name in enumerate(data.bodies):
        if k not in radiating:
            progress(f"body {name!r} has no radiation memory: it makes next to no waves")


def _coupled(data: Coefficients, signal: np.ndarray) -> list[tuple[int, ...]]:
    """Groups of motions connected by damping or memory that is not negligible."""
    from scipy.sparse.csgraph import connected_components

    used = data.omega[:, None] <= data.memory_limits
    both = used[:, :, None] & used[:, None, :]
    damping = data.radiation_damping * both
    surplus = (data.added_mass - data.added_mass_inf) * both
    inertia = np.abs(data.added_mass_inf.diagonal())
    diagonal = damping.diagonal(axis1=1, axis2=2)
    own = diagonal.max(axis=0)
    least = np.maximum(SILENT * inertia, FELT * soundness.displaced_inertia(data))
    radiates = (diagonal / data.omega[:, None]).max(axis=0) > least
    linked = signal & np.outer(radiates, radiates)
    shares = [
        np.abs(values).max(axis=0) / np.sqrt(np.where(linked, np.outer(size, size), 1.0))
        for values, size in ((damping, own), (surplus, inertia))
    ]
    linked &= np.maximum(*shares) > NEGLIGIBLE
    _, labels = connected_components(linked, directed=False)
    groups: dict[int, list[int]] = {}
    for motion in np.flatnonzero(radiates):
        groups.setdefault(int(labels[motion]), []).append(int(motion))
    return [tuple(members) for members in groups.values()]


class _Part:
    """The data of a group, and the errors of fits to them."""

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
        """Which values of which pairs of motions are below the ends of both, (n, pairs)."""
        return self.omega[:, None] <= np.minimum(ends[self.rows], ends[self.columns])

    def samples(self, *, offset: bool) -> Samples:
        """What is fitted, K(0) = 0 included."""
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
        """`fit` in physical units, with its errors."""
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
        """Errors, where the panels resolve the waves and of all these data, of any fit to any."""
        found = evaluate(self.omega, poles, residues.transpose(1, 2, 0)).transpose(2, 0, 1)
        mass = found.imag / self.omega[:, None, None] + surplus
        errors = found.real - self.damping, mass - self.added_mass
        return self._misfit(*errors, self.resolved), self._misfit(*errors, self.limits)

    def _misfit(self, damping: np.ndarray, mass: np.ndarray, ends: np.ndarray) -> Misfit:
        """Of errors (n, m, m), the damping's relative to itself up to `ends` (m,) [rad/s]."""
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
        """Symmetric matrices (…, m, m) of their upper triangles (…, pairs)."""
        size = len(self.motions)
        found = np.zeros((*upper.shape[:-1], size, size), dtype=upper.dtype)
        found[..., self.rows, self.columns] = found[..., self.columns, self.rows] = upper
        return found


def _group(
    data: Coefficients,
    motions: tuple[int, ...],
    signal: np.ndarray,
    sound: np.ndarray,
    reach: Reach,
    order: int | None,
) -> RadiationGroup:
    """The best fit of a group: of all data, or of those that panels resolve.

    The latter if the former is poor, or has another A∞ than the data, and only if it is better
    where panels resolve the waves. If that is poor, too, of those that do not scatter, if that fit
    is not poor and better there.
    """
    found = _fitted(_Part(data, motions, signal, sound, reach), order)
    shorter, own = reach.shorter(), list(motions)
    doubtful = found is None or found.misfit.is_poor or found.change > 0
    if doubtful and (shorter.fitted < reach.fitted)[own].any():
        other = _fitted(_Part(data, motions, signal, sound, shorter), order)
        if found is None or (other is not None and other.misfit.demerit < found.misfit.demerit):
            found = other
    if found is None or found.misfit.is_poor:
        smooth = reach.smooth(data, motions)
        if (smooth.fitted < shorter.fitted)[own].any():
            part = _Part(data, motions, signal, sound, smooth)
            other = _fitted(part, order)
            if other is not None and not other.misfit.is_poor and _is_better(other, found, part):
                found = replace(other, scattered=True)
    if found is None:
        raise InputError.single(
            "no passive radiation memory was found", "use another radiation.order"
        )
    return found


def _is_better(one: RadiationGroup, other: RadiationGroup | None, part: _Part) -> bool:
    """Whether a fit to `part` is better there than another fit, of which there may be none."""
    if other is None:
        return True
    misfit, _ = part.misfits(other.poles, other.residues, other.surplus)
    return one.misfit.demerit < misfit.demerit


def _fitted(part: _Part, order: int | None) -> RadiationGroup | None:
    """The best fit of some data; with its own A∞ where that is worth it."""
    given = _best(part, order, offset=False)
    if given is not None and given.misfit_of_all.error < DISAGREE:
        return given
    other = _best(part, order, offset=True)
    if given is None:
        return other
    worth = other is not None and other.misfit_of_all.error < given.misfit_of_all.error / 2
    return other if worth else given


def _best(part: _Part, order: int | None, *, offset: bool) -> RadiationGroup | None:
    samples = part.samples(offset=offset)
    fits: list[RadiationGroup] = []
    for k in ORDERS if order is None else (order,):
        try:
            fit = passive_fit(samples, order=k, evaluations=EVALUATIONS)
        except UnprovenError:
            continue
        fits.append(part.judged_fit(fit))
        if fits[-1].misfit_of_all.demerit <= 1:
            break
    if not fits:
        return None
    best = min((fit.misfit_of_all for fit in fits), key=lambda misfit: misfit.demerit)
    enough = max(1.0, best.demerit if best.is_poor else NEAR_BEST * best.demerit)
    return next(fit for fit in fits if fit.misfit_of_all.demerit <= enough)


def _tell_of_early_ends(
    group: RadiationGroup, data: Coefficients, progress: Callable[[str], object]
) -> None:
    """Warn of data that end where a motion's damping is still large."""
    told = []
    for end, motion in zip(group.ends.tolist(), group.motions, strict=True):
        own = data.radiation_damping[data.omega <= end, motion, motion]
        share = float(own[-1] / own.max())
        if share > STILL_LARGE and end < NEARLY * data.memory_limits[motion]:
            told.append(f"{data.motions[motion]} at {end:.3g} rad/s ({100 * share:.2g} %)")
    if told:
        progress(
            "warning: the data of the radiation memory end where the damping is still more than "
            f"half its largest value: {', '.join(told)}; beyond, it follows from added mass and "
            "causality and may be off by tens of percent: raise frequencies.maximum; use more "
            "panels where they are coarse for the highest waves"
        )


def _report(group: RadiationGroup, data: Coefficients) -> str:
    names = ", ".join(data.motions[k] for k in group.motions)
    motion, at = group.misfit.damping_at
    text = (
        f"radiation of {names}: order {group.order}, error {100 * group.error:.2g} %, of the "
        f"damping at most {100 * group.misfit.damping_error:.2g} % ({data.motions[motion]} at "
        f"{at:.3g} rad/s)"
    )
    ends = np.minimum(data.memory_limits[list(group.motions)], data.omega[-1])
    if group.scattered:
        text += f" up to {group.resolved.min():.3g} rad/s; data above scatter and are left out"
    elif (group.resolved < ends).any():
        text += f" where the panels resolve the waves, up to {group.resolved.min():.3g} rad/s"
    if group.doubtful:
        left_out = ", ".join(f"{w:.3g}" for w in group.doubtful)
        text += f", data off the line at {left_out} rad/s"
    if group.change > 0:
        masses = ", ".join(
            f"{data.motions[k]} {value:.4g} for {value - more:.4g}"
            for k, value, more in zip(
                group.motions,
                data.added_mass_inf.diagonal()[list(group.motions)] + group.surplus.diagonal(),
                group.surplus.diagonal(),
                strict=True,
            )
        )
        text += f"; A(ω) and A∞ disagree, A∞ is by the fit: {masses}"
    return text
