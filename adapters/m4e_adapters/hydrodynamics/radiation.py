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
Those of A are relative to A∞: A is part of an inertia, however small the memory in it. Used are
the frequencies up to `Coefficients.memory_limit` and further while a motion's B is more than TAIL
of its largest: beyond, values are small, and what panels spoil first breaks the causality that ties
B to A. Frequencies off the common line, irregular ones above all, are left out.

Where A(ω) is not what A∞ and B say it should be, A∞ is the one that fits best.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics import soundness
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.passivity import Fit, UnprovenError, passive_fit
from m4e_adapters.hydrodynamics.vector_fitting import Complex, Samples, evaluate
from m4e_fmi.errors import InputError

ORDERS = (4, 5, 6, 8, 10, 12, 16)
EVALUATIONS = 10  # of the poles' least squares, derivatives not counted
TARGET, DAMPING_TARGET = 3e-3, 0.02  # errors that end the search for a higher order
POOR, POOR_DAMPING, USELESS = 0.02, 0.03, 0.2  # warned of, refused
NEAR_BEST = 1.5  # how much larger an error than the best is accepted for fewer states
DISAGREE = 0.01  # error of A over A∞ from which A∞ is fitted too
REMEDY = (
    "raise radiation.order or leave it out; use more panels where they are coarse for the highest "
    "waves, or a lower frequencies.maximum; for bodies far apart, whose waves arrive late, raise "
    "frequencies.count"
)
NEGLIGIBLE = 1e-3  # coupling, relative to the geometric mean of the motions' own
SILENT = 1e-6  # B over ω A∞, largest each, below which a motion has no memory
TAIL = 0.05  # of the largest B
WEAK = 5e-3  # B over its largest below which its errors do not count for more
RELEVANT = 0.01  # likewise, from which the damping's relative error is judged


@dataclass(frozen=True)
class RadiationGroup:
    """Fitted retardation functions of some motions, passive at all frequencies.

    Attributes
    ----------
    motions : (m,) indices of the motions.
    poles : (k,) [1/s], one of each conjugate pair (Im ≥ 0), Re < 0.
    residues : (k, m, m) symmetric [force, motion]; K(s) = Σ r/(s − p) (+ conjugates).
    surplus : (m, m) what A∞ is to be more than the table's.
    error : the largest of B over the motions' largest B, and of A over their A∞.
    damping_error : the largest of B over B itself where it is RELEVANT, up to `memory_limit`.
    damping_at : its motion (index) and its frequency [rad/s].
    doubtful : angular frequencies [rad/s] that were left out as outliers.
    """

    motions: tuple[int, ...]
    poles: Complex
    residues: Complex
    surplus: np.ndarray
    error: float
    damping_error: float
    damping_at: tuple[int, float]
    doubtful: tuple[float, ...] = ()

    @property
    def order(self) -> int:
        """Number of poles, pairs counting two."""
        return int(sum(2 if pole.imag > 0 else 1 for pole in self.poles))

    @property
    def demerit(self) -> float:
        """Errors over what is wanted, the largest; 1 or less ends the search."""
        return max(self.error / TARGET, self.damping_error / DAMPING_TARGET)

    @property
    def is_poor(self) -> bool:
        """Whether that deserves a warning."""
        return self.error > POOR or self.damping_error > POOR_DAMPING

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
    below = coefficients.omega <= coefficients.memory_limit
    sound = soundness.dissipative(coefficients, below, progress) | ~below
    data = soundness.symmetric(coefficients, progress)
    added_mass_inf = data.added_mass_inf.copy()
    groups = []
    for motions in _coupled(data, signal):
        group = _group(_Part(data, motions, signal, sound), order)
        text = _report(group, data)
        if group.error > USELESS:
            raise InputError.single(text, REMEDY)
        progress(f"warning: {text}: {REMEDY}" if group.is_poor else text)
        added_mass_inf[np.ix_(motions, motions)] += group.surplus
        groups.append(group)
    return RadiationMemory(tuple(groups), added_mass_inf)


def _coupled(data: Coefficients, signal: np.ndarray) -> list[tuple[int, ...]]:
    """Groups of motions connected by damping or memory that is not negligible."""
    from scipy.sparse.csgraph import connected_components

    used = data.omega <= data.memory_limit
    omega, damping = data.omega[used], data.radiation_damping[used]
    surplus = (data.added_mass - data.added_mass_inf)[used]
    inertia = np.abs(data.added_mass_inf.diagonal())
    own = damping.diagonal(axis1=1, axis2=2).max(axis=0)
    radiates = own > SILENT * inertia * omega.max()
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
    ) -> None:
        place = np.ix_(motions, motions)
        self.motions = motions
        self.rows, self.columns = np.triu_indices(len(motions))
        below = data.omega <= data.memory_limit
        largest = data.radiation_damping[below].diagonal(axis1=1, axis2=2).max(axis=0)
        limits = [_limit(data, k, float(largest[k])) for k in motions]
        used = sound & (data.omega <= max(limits))
        self.omega = data.omega[used]
        real = signal[place]
        every = (range(int(used.sum())), motions, motions)
        self.damping = data.radiation_damping[used][np.ix_(*every)] * real
        self.added_mass = (data.added_mass - data.added_mass_inf)[used][np.ix_(*every)] * real
        self.own = largest[list(motions)]
        self.inertia = np.abs(data.added_mass_inf.diagonal())[list(motions)]
        self.scale = np.sqrt(np.outer(self.own, self.own))
        values = self.damping + 1j * self.omega[:, None, None] * self.added_mass
        self.values = (values / self.scale)[:, self.rows, self.columns].T
        trusted = soundness.on_the_line(self.omega, self.values)
        self.doubtful = tuple(float(w) for w in self.omega[~trusted])
        ends = np.array(limits)
        self.known = trusted & (
            self.omega <= np.minimum(ends[self.rows], ends[self.columns])[:, None]
        )
        self.judged = trusted & (self.omega <= data.memory_limit)

    def samples(self, *, offset: bool) -> Samples:
        """What is fitted, K(0) = 0 included."""
        relative = np.sqrt(np.abs(self.damping.diagonal(axis1=1, axis2=2)) / self.own)
        share = (relative[:, self.rows] * relative[:, self.columns]).T  # of the largest B
        inertia = np.sqrt(np.outer(self.inertia, self.inertia)) / self.scale
        of_damping = np.maximum(share, WEAK) ** -0.5 * self.known
        of_mass = self.known / (self.omega * inertia[self.rows, self.columns][:, None])
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
        found = evaluate(self.omega, fit.poles, residues.transpose(1, 2, 0)).transpose(2, 0, 1)
        known = self._full(self.known.T)
        damping = np.abs(found.real - self.damping) * known
        mass = np.abs(found.imag / self.omega[:, None, None] + surplus - self.added_mass) * known
        error = max(
            float((damping / self.scale).max()),
            float((mass / np.sqrt(np.outer(self.inertia, self.inertia))).max()),
        )
        own = self.damping.diagonal(axis1=1, axis2=2)
        counts = self.judged[:, None] & (own > RELEVANT * self.own)
        relative = np.where(counts, damping.diagonal(axis1=1, axis2=2) / np.maximum(own, 1e-300), 0)
        at, motion = np.unravel_index(int(relative.argmax()), relative.shape)
        return RadiationGroup(
            motions=self.motions,
            poles=fit.poles,
            residues=residues,
            surplus=surplus,
            error=error,
            damping_error=float(relative[at, motion]),
            damping_at=(self.motions[motion], float(self.omega[at])),
            doubtful=self.doubtful,
        )

    def _full(self, upper: np.ndarray) -> np.ndarray:
        """Symmetric matrices (…, m, m) of their upper triangles (…, pairs)."""
        size = len(self.motions)
        found = np.zeros((*upper.shape[:-1], size, size), dtype=upper.dtype)
        found[..., self.rows, self.columns] = found[..., self.columns, self.rows] = upper
        return found


def _limit(data: Coefficients, motion: int, largest: float) -> float:
    """Up to which frequency [rad/s] the data of a motion count."""
    own = data.radiation_damping[:, motion, motion]
    peak = int(np.argmax(np.where(data.omega <= data.memory_limit, own, -np.inf)))
    small = np.flatnonzero(own[peak:] <= TAIL * largest)
    end = data.omega[peak + small[0]] if len(small) else data.omega[-1]
    return max(float(end), data.memory_limit)


def _group(part: _Part, order: int | None) -> RadiationGroup:
    """The best fit of a group; with its own A∞ where that is worth it."""
    given = _best(part, order, offset=False)
    if given is not None and given.error < DISAGREE:
        return given
    fitted = _best(part, order, offset=True)
    if given is None or (fitted is not None and fitted.error < given.error / 2):
        given = fitted
    if given is None:
        raise InputError.single(
            "no passive radiation memory was found", "use another radiation.order"
        )
    return given


def _best(part: _Part, order: int | None, *, offset: bool) -> RadiationGroup | None:
    samples = part.samples(offset=offset)
    fits: list[RadiationGroup] = []
    for k in ORDERS if order is None else (order,):
        try:
            fit = passive_fit(samples, order=k, evaluations=EVALUATIONS)
        except UnprovenError:
            continue
        fits.append(part.judged_fit(fit))
        if fits[-1].demerit <= 1:
            break
    if not fits:
        return None
    best = min(fits, key=lambda fit: fit.demerit)
    enough = max(1.0, best.demerit if best.is_poor else NEAR_BEST * best.demerit)
    return next(fit for fit in fits if fit.demerit <= enough)


def _report(group: RadiationGroup, data: Coefficients) -> str:
    names = ", ".join(data.motions[k] for k in group.motions)
    motion, at = group.damping_at
    text = (
        f"radiation of {names}: order {group.order}, error {100 * group.error:.2g} %, of the "
        f"damping at most {100 * group.damping_error:.2g} % ({data.motions[motion]} at {at:.3g} "
        "rad/s)"
    )
    if group.doubtful:
        left_out = ", ".join(f"{w:.3g}" for w in group.doubtful)
        text += f", data off the line at {left_out} rad/s"
    changed = np.abs(group.surplus).max(initial=0.0) > 0
    if changed:
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
